# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties that Attribute nodes read of objects and view layers: custom ones first, then any other by its path.

Based on: BKE_object_dupli_find_rgba_attribute and BKE_view_layer_find_rgba_attribute of Blender, which Cycles asks.
Differs:  what instancers give is the instance's own, see instancer_values.py.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    import bpy

    from .instances import Placement

Rgba = tuple[float, float, float, float]
Asked = tuple[str, str]  #: What a node asks: a kind, and the name of a property or attribute.
#: Kinds of what instancers give; the first is a node's attribute type.
INSTANCER_KINDS = ATTRIBUTE, UV, GENERATED = "INSTANCER", "UV of the instancer", "Generated of the instancer"

MISSING: Rgba = (0.0, 0.0, 0.0, 0.0)
_NO_MORE = (0.0, 0.0, 0.0, 1.0)  #: Channels of an array that is shorter.
_QUOTED = re.compile(r"""\[(["']).*\1\]$""")  #: A path that ends in a custom property.
_NUMBERS = {"BOOLEAN", "INT", "FLOAT"}


class PropertyReader:
    """Of one depsgraph."""

    def __init__(self, depsgraph: bpy.types.Depsgraph) -> None:
        self._layer = depsgraph.view_layer_eval
        self._scene = depsgraph.scene_eval

    def read(self, kind: str, name: str, placement: Placement) -> Rgba | int | None:
        """Of a node's attribute type, or another of INSTANCER_KINDS. What nobody has is 0, and so is its alpha.

        The number of a value where each instance has its own; None where what an instancer gives is not known.
        """
        if placement.instancer_numbers is not None and kind in INSTANCER_KINDS:
            return placement.instancer_numbers.get((kind, name))
        if placement.is_instanced and kind in INSTANCER_KINDS:
            return None
        if kind in (UV, GENERATED):
            return MISSING
        owners = self._of_layer() if kind == "VIEW_LAYER" else _of_object(placement)
        return first_numbers(owners, name) or MISSING

    def _of_layer(self) -> Iterator[bpy.types.bpy_struct[Any]]:
        yield self._layer
        yield self._scene
        if self._scene.world is not None:
            yield self._scene.world


def _of_object(placement: Placement) -> Iterator[bpy.types.bpy_struct[Any]]:
    yield placement.source
    if placement.source.data is not None:
        yield placement.source.data


def first_numbers(owners: Iterable[bpy.types.bpy_struct[Any]], path: str) -> Rgba | None:
    """Of the first owner that has some; None: nobody has."""
    return next((value for owner in owners if (value := numbers_of(owner, path)) is not None), None)


def numbers_of(owner: bpy.types.bpy_struct[Any], path: str) -> Rgba | None:
    value = _custom(owner, path)
    if value is None:
        value = _at_path(owner, path)
    if isinstance(value, (bool, int, float)):
        return float(value), float(value), float(value), 1.0
    if isinstance(value, str) or not hasattr(value, "__len__") or not 0 < len(value) <= len(_NO_MORE):
        return None
    channels = [*value, *_NO_MORE[len(value) :]]
    if not all(isinstance(channel, (bool, int, float)) for channel in channels):
        return None
    red, green, blue, alpha = (float(channel) for channel in channels)
    return red, green, blue, alpha


def _custom(owner: bpy.types.bpy_struct[Any], name: str) -> object:
    """None as well for those of add-ons, which are groups."""
    value: object = owner.get(name)
    return None if hasattr(value, "keys") else value


def _at_path(owner: bpy.types.bpy_struct[Any], path: str) -> object:
    """Python's paths lead to parts of arrays as well, Blender's do not."""
    before, _, name = path.rpartition(".")
    try:
        if _QUOTED.search(path):
            return owner.path_resolve(path)
        holder = owner.path_resolve(before) if before else owner
        known = getattr(holder, "bl_rna", None) and holder.bl_rna.properties.get(name)
        return getattr(holder, name) if known and known.type in _NUMBERS else None
    except (ValueError, AttributeError):  # no such path
        return None
