# SPDX-License-Identifier: GPL-3.0-or-later
"""What a mesh would take as voxels, before any is made: their number, memory, bytes of the file, seconds.

A thin surface has a voxel for each column along the main axis of its normal; a conservative one, on average, one for
each column along every axis. Areas as they are seen along the axes say how many: exactly for large flat faces, but for
their rims; too many where faces lie within the same voxels.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyndall import _native

from .checks import budget, cube, indices, points, refuse
from .config import Config

#: Voxels a side of a brick, of which a word of 64 bits and a code are kept.
_BRICK = 4
_BYTES_PER_BRICK = 16
#: Of the voxels' geometry in a file: the dragon of 6.2 M voxels takes 0.23 bytes for each, of 98.1 M 0.145.
_FILE_BYTES_PER_VOXEL = 0.25
#: Per core, from a mesh to a packed graph with 48 symmetries: the dragon at 8,192.
_VOXELS_PER_S = 38e6
_START_S = 0.05  #: Of whatever mesh.
_COPIES = 4  #: Of attributes, while they are ordered and packed.
_ORDER_BYTES = 16  #: Of a voxel that has any: where it goes, and what goes there.
_LEAST_RESOLUTION = 4


@dataclass(frozen=True, kw_only=True)
class Extent:
    """All that an estimate needs to know of a mesh, whatever the resolution."""

    side_m: float  #: Of the cube that is voxelized.
    main_m2: float  #: Areas of the triangles as they are seen along the main axes of their normals.
    all_m2: float  #: As they are seen along x, y and z, together.


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Within a factor of two, for surfaces that are larger than their voxels."""

    resolution: int
    voxel_count: int
    memory_bytes: int  #: Of the voxels or of the graph's tables, the larger: what a budget bounds.
    file_bytes: int  #: At most: less where parts are alike.
    seconds: float  #: On all cores of this machine, with nothing beside.


def extent_of(positions_m: ArrayLike, triangles: ArrayLike, config: Config | None = None) -> Extent:
    """Of a mesh as ``voxelize`` takes it. Vertices must be finite. Raises InvalidInput."""
    positions = np.asarray(points(positions_m, "positions_m"), np.float64)
    corners = indices(triangles, "triangles")
    if corners.size and corners.max() >= len(positions):
        raise refuse(f"triangles name vertex {corners.max()} of {len(positions)}")
    bounds = cube((config or Config()).bounds_m)
    used = positions[np.unique(corners)]
    side_m = bounds[1] if bounds is not None else float(np.ptp(used, axis=0).max(initial=0.0)) if len(used) else 0.0
    seen_m2 = _seen_areas_m2(positions, corners)
    return Extent(side_m=side_m, main_m2=float(seen_m2.max(axis=1).sum()), all_m2=float(seen_m2.sum()))


def _seen_areas_m2(positions: NDArray[np.float64], corners: NDArray[np.uint32]) -> NDArray[np.float64]:
    """Of each triangle, along x, y and z."""
    origin = positions[corners[:, 0]]
    cross: NDArray[np.float64] = np.cross(positions[corners[:, 1]] - origin, positions[corners[:, 2]] - origin)
    return 0.5 * np.abs(cross)


def estimate(extent: Extent, config: Config, attribute_bytes: float = 0.0) -> Estimate:
    """Of the mesh at ``config.resolution``, with so many bytes of colours and the like for each voxel."""
    columns_per_m2 = (config.resolution / extent.side_m) ** 2 if extent.side_m > 0.0 else 0.0
    voxels = max(1, round(columns_per_m2 * (extent.main_m2 if config.rule == "thin" else extent.all_m2)))
    bricks = max(1, round(columns_per_m2 / _BRICK**2 * extent.all_m2))
    tables_bytes = _native.estimated_voxel_build_bytes(bricks, config.resolution.bit_length() - 1)
    attribute_memory_bytes = _COPIES * attribute_bytes + _ORDER_BYTES if attribute_bytes > 0.0 else 0.0
    return Estimate(
        resolution=config.resolution,
        voxel_count=voxels,
        memory_bytes=max(_BYTES_PER_BRICK * bricks, tables_bytes) + round(attribute_memory_bytes * voxels),
        file_bytes=round((_FILE_BYTES_PER_VOXEL + attribute_bytes) * voxels),
        seconds=_START_S + voxels / (_VOXELS_PER_S * (os.cpu_count() or 1)),
    )


def largest_that_fits(extent: Extent, config: Config, attribute_bytes: float = 0.0) -> Estimate | None:
    """At ``config.resolution``, or at the highest below it that the budget allows; None: not even the lowest fits."""
    while True:
        found = estimate(extent, config, attribute_bytes)
        if found.memory_bytes <= budget(config):
            return found
        if config.resolution <= _LEAST_RESOLUTION:
            return None
        config = replace(config, resolution=config.resolution // 2)
