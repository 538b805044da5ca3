# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxel objects and strands in native memory: one shape each, however often it stands in the scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from .instance_arrays import randoms_of
from .scene_description import StrandObjects

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .native_scene import NativeParts
    from .scene_description import PlacedObjects, SceneDescription, VoxelObjects


@dataclass(frozen=True, kw_only=True)
class BuiltShapes:
    """What a native scene takes of voxel objects and strands."""

    arguments: dict[str, Any]
    groups: list[VoxelObjects | StrandObjects]  #: Whose placements have a name each.


def build_shapes(
    description: SceneDescription,
    parts: NativeParts,
    origin: NDArray[np.float64],
    default_material: int,
    reports: list[str],
    progress: _native.Progress,
) -> BuiltShapes:
    """New shapes go into ``parts``, those that are gone leave it."""
    _build_voxels(description.voxel_objects, parts)
    strand_groups = _build_strands(description.strand_objects, parts, reports, progress)
    groups: list[VoxelObjects | StrandObjects] = [*description.voxel_objects, *strand_groups]
    keys: list[int | str] = [*parts.voxels, *parts.strands]
    index = {key: number for number, key in enumerate(keys)}
    counts = [len(group.object_names) for group in groups]

    def repeated(values: list[int], dtype: type[np.integer[Any]]) -> NDArray[Any]:
        return np.repeat(np.array(values, dtype=dtype), counts)

    return BuiltShapes(
        arguments={
            "shapes": [*parts.voxels.values(), *parts.strands.values()],
            "shape_indices": repeated([index[_key(group)] for group in groups], np.uint32),
            "world_from_shape": relative_matrices([group.world_from_object for group in groups], origin),
            "shape_materials": repeated(
                [default_material if group.material is None else group.material for group in groups], np.uint32
            ),
            "shape_shows_to": repeated([shows_to(group) for group in groups], np.uint8),
            "shape_randoms": randoms_of(groups),
        },
        groups=groups,
    )


def _key(group: VoxelObjects | StrandObjects) -> int | str:
    return group.strands.key if isinstance(group, StrandObjects) else group.dag.key


def _build_strands(
    groups: tuple[StrandObjects, ...], parts: NativeParts, reports: list[str], progress: _native.Progress
) -> list[StrandObjects]:
    """The groups whose strands can be used."""
    kept: dict[str, _native.Strands] = {}
    refused: set[str] = set()
    for group in groups:
        strands = group.strands
        if strands.key in kept or strands.key in refused:
            continue
        native = parts.strands.get(strands.key)
        parts.counts["strands sent" if native is None else "strands reused"] += 1
        if native is None:
            progress.message = f"Sending {strands.name}"
            try:
                native = _native.Strands(
                    strands.name,
                    int(strands.form),
                    strands.points,
                    strands.first_points,
                    strands.ribbon_pieces,
                    strands.layers,
                    strands.uv_maps,
                    strands.randoms,
                    progress,
                )
            except _native.InvalidInput as error:
                reports.append(f"{error}: left out")
                refused.add(strands.key)
                continue
        kept[strands.key] = native
    parts.strands = kept
    return [group for group in groups if group.strands.key in kept]


def _build_voxels(groups: tuple[VoxelObjects, ...], parts: NativeParts) -> None:
    kept: dict[int, _native.VoxelShape] = {}
    for group in groups:
        key = group.dag.key
        if key in kept:
            continue
        native = parts.voxels.get(key)
        parts.counts["voxels sent" if native is None else "voxels reused"] += 1
        kept[key] = native if native is not None else _native.VoxelShape(group.dag.native, group.object_names[0])
    parts.voxels = kept


def shows_to(group: PlacedObjects) -> int:
    """A bit per kind of ray, as native/scene/instance_masks.hpp has them; then held out, catcher, lights media."""
    to_others = (group.casts_shadow, group.is_bounce_visible, group.is_mirror_visible, group.is_glass_visible)
    flags = (group.is_camera_visible, *to_others, group.is_held_out, group.is_shadow_catcher, group.lights_media)
    return sum(flag << bit for bit, flag in enumerate(flags))


def relative_matrices(matrices: list[NDArray[np.float64]], origin: NDArray[np.float64]) -> NDArray[np.float32]:
    """(n, 4, 4): the subtraction happens in double precision, so that a scene 60 km out keeps its millimetres."""
    if not matrices:
        return np.zeros((0, 4, 4), dtype=np.float32)
    joined = np.concatenate(matrices).astype(np.float64)
    joined[:, :3, 3] -= origin
    with np.errstate(over="ignore"):  # what does not fit becomes infinite: the scene drops it with a report
        return joined.astype(np.float32, order="C")
