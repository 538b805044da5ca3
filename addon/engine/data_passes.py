# SPDX-License-Identifier: GPL-3.0-or-later
"""What passes tell beside light: the settings of mist, indices and Cryptomattes, and the manifests that name mattes.

Names, and what they belong to, are Cycles': a file of either is read by the same nodes and the same programs.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from tyndall.mattes import MATTE_NAMES, matte_stamps
from tyndall.renderer import DataConfig

from .passes import matte_kinds, matte_ranks, valid_aovs

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.types import Depsgraph, Object, ViewLayer, World

    from tyndall.scene_description import SceneDescription

_MIST_EXPONENTS = {"LINEAR": 1.0, "QUADRATIC": 2.0, "INVERSE_QUADRATIC": 0.5}


def data_config(depsgraph: Depsgraph, view_layer: ViewLayer) -> DataConfig:
    """What the view layer's data passes need beside the scene; what nobody asks for is not looked for."""
    return replace(
        view_data_config(depsgraph.scene_eval.world if view_layer.use_pass_mist else None),
        matte_ranks=matte_ranks(view_layer),
        asset_of=_assets(depsgraph) if view_layer.use_pass_cryptomatte_asset else {},
        material_index=_material_indices(depsgraph) if view_layer.use_pass_material_index else {},
        aovs=tuple((aov.name, aov.type == "COLOR") for aov in valid_aovs(view_layer)),
    )


def view_data_config(world: World | None) -> DataConfig:
    """What data passes of a viewport need: the world's mist, if there is one."""
    if world is None:
        return DataConfig()
    mist = world.mist_settings
    return DataConfig(mist_start_m=mist.start, mist_depth_m=mist.depth, mist_exponent=_MIST_EXPONENTS[mist.falloff])


class MatteNames:
    """By kind of Cryptomatte, what a picture's mattes may hold: of all moments that it shows."""

    def __init__(self) -> None:
        self._names: dict[str, dict[str, None]] = {}

    def add(self, depsgraph: Depsgraph, view_layer: ViewLayer, description: SceneDescription) -> None:
        for kind in matte_kinds(view_layer):
            self._names.setdefault(kind, {}).update(dict.fromkeys(_matte_names(kind, depsgraph, description)))

    def stamps(self, layer_name: str) -> dict[str, str]:
        """What files of the picture say about it, by Cryptomatte's rules."""
        fields: dict[str, str] = {}
        for kind, names in self._names.items():
            fields |= matte_stamps(f"{layer_name}.{kind}", names)
        return fields


def _matte_names(kind: str, depsgraph: Depsgraph, description: SceneDescription) -> Iterable[str]:
    if kind == "CryptoMaterial":
        return (MATTE_NAMES.get(material.name, material.name) for material in description.materials)
    groups = (*description.instances, *description.voxel_objects, *description.strand_objects)
    names = (name for group in groups for name in dict.fromkeys(group.object_names))
    if kind == "CryptoObject":
        return names
    asset_of = _assets(depsgraph)
    return (asset_of.get(name, name) for name in names)


def _assets(depsgraph: Depsgraph) -> dict[str, str]:
    """Of objects with a parent: the first of their ancestors."""
    things = (thing for thing in depsgraph.ids if isinstance(thing, bpy.types.Object))
    return {thing.name: _root(thing).name for thing in things if thing.parent is not None}


def _root(thing: Object) -> Object:
    while thing.parent is not None:
        thing = thing.parent
    return thing


def _material_indices(depsgraph: Depsgraph) -> dict[str, float]:
    materials = (thing for thing in depsgraph.ids if isinstance(thing, bpy.types.Material))
    return {material.name: float(material.pass_index) for material in materials if material.pass_index != 0}
