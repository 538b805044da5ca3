# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxel objects in native memory: one shape per DAG, however often it stands in the scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .native_scene import NativeParts
    from .scene_description import Instances, VoxelObjects


@dataclass(frozen=True, kw_only=True)
class BuiltVoxels:
    """What a native scene takes of voxel objects."""

    arguments: dict[str, Any]
    object_names: list[str]


def build_voxels(
    groups: tuple[VoxelObjects, ...], parts: NativeParts, origin: NDArray[np.float64], default_material: int
) -> BuiltVoxels:
    """New shapes go into ``parts``, those that are gone leave it."""
    kept: dict[int, _native.VoxelShape] = {}
    for group in groups:
        key = group.dag.key
        if key in kept:
            continue
        native = parts.voxels.get(key)
        parts.counts["voxels sent" if native is None else "voxels reused"] += 1
        kept[key] = native if native is not None else _native.VoxelShape(group.dag.native, group.object_names[0])
    parts.voxels = kept
    index = {key: number for number, key in enumerate(kept)}
    counts = [len(group.object_names) for group in groups]

    def repeated(values: list[int], dtype: type[np.integer[Any]]) -> NDArray[Any]:
        return np.repeat(np.array(values, dtype=dtype), counts)

    return BuiltVoxels(
        arguments={
            "shapes": list(kept.values()),
            "shape_indices": repeated([index[group.dag.key] for group in groups], np.uint32),
            "world_from_shape": relative_matrices([group.world_from_object for group in groups], origin),
            "shape_materials": repeated(
                [default_material if group.material is None else group.material for group in groups], np.uint32
            ),
            "shape_shows_to": repeated([shows_to(group) for group in groups], np.uint8),
        },
        object_names=[name for group in groups for name in group.object_names],
    )


def shows_to(group: Instances | VoxelObjects) -> int:
    """A bit for each kind of ray, as native/scene/instance_masks.hpp numbers them."""
    flags = (group.is_camera_visible, group.casts_shadow, group.is_bounce_visible, group.is_mirror_visible)
    return sum(flag << bit for bit, flag in enumerate(flags))


def relative_matrices(matrices: list[NDArray[np.float64]], origin: NDArray[np.float64]) -> NDArray[np.float32]:
    """(n, 4, 4): the subtraction happens in double precision, so that a scene 60 km out keeps its millimetres."""
    if not matrices:
        return np.zeros((0, 4, 4), dtype=np.float32)
    joined = np.concatenate(matrices).astype(np.float64)
    joined[:, :3, 3] -= origin
    with np.errstate(over="ignore"):  # what does not fit becomes infinite: the scene drops it with a report
        return joined.astype(np.float32, order="C")
