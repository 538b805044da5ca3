# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and lists of voxels become graphs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall import _native
from tyndall._native import Progress

from .checks import (
    MOST_INDEX,
    attribute_config,
    budget,
    channels,
    colors,
    cube,
    indices,
    named,
    normals,
    points,
    refuse,
    whole,
)
from .config import Config
from .dag import VoxelDag
from .surfaces import surface

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


def voxelize(
    positions_m: ArrayLike, triangles: ArrayLike, config: Config | None = None, progress: Progress | None = None
) -> VoxelDag:
    """The surface of a mesh, or all that it closes around, and what the configuration says that its voxels carry.

    The result depends on neither the order of triangles nor the number of threads.

    ``positions_m``: (n, 3), float32 or float64, in metres; ``triangles``: (m, 3), three indices of positions each.
    Raises InvalidInput, which names the vertex, the triangle or the setting; IoError, which names a picture's file; and
    Cancelled.
    """
    config = config or Config()
    positions = points(positions_m, "positions_m")
    return VoxelDag(
        _native.voxelize(
            positions=positions,
            triangles=indices(triangles, "triangles"),
            resolution=whole("resolution", config.resolution, MOST_INDEX),
            rule=named(_native.VoxelizeRule, "rule", config.rule),
            bounds=cube(config.bounds_m),
            surface=surface(config, len(positions)),
            is_solid=config.solid,
            symmetry=named(_native.VoxelSymmetry, "symmetry", config.symmetry),
            attribute_config=attribute_config(config),
            memory_budget_bytes=budget(config),
            progress=progress or Progress(),
        )
    )


def from_coordinates(
    coordinates: ArrayLike, config: Config | None = None, progress: Progress | None = None
) -> VoxelDag:
    """Of voxels x, y and z, (n, 3) whole numbers below ``config.resolution``, in any order; they may repeat.

    Without ``bounds_m`` a voxel is a cube of 1 m, and the first begins at 0. The rule has nothing to say. Colours,
    normals and channels have a row per voxel; where one repeats, its last row counts. Raises InvalidInput, which names
    the voxel or the setting, and Cancelled.
    """
    config = config or Config()
    resolution = whole("resolution", config.resolution, MOST_INDEX)
    if resolution.bit_count() != 1:
        raise refuse(f"resolution is {resolution}, no power of two")
    if config.textures is not None or config.solid or isinstance(config.normals, str):
        raise refuse("textures, solid and the normals of faces are for meshes")
    voxels = indices(coordinates, "coordinates")
    return VoxelDag(
        _native.voxel_dag_of(
            coordinates=voxels,
            level=resolution.bit_length() - 1,
            bounds=cube(config.bounds_m) or ([0.0, 0.0, 0.0], float(resolution)),
            symmetry=named(_native.VoxelSymmetry, "symmetry", config.symmetry),
            colors=colors(config.colors, len(voxels)),
            normals=normals(config.normals, len(voxels)),
            channels=channels(config.channels, len(voxels)),
            attribute_config=attribute_config(config),
            memory_budget_bytes=budget(config),
            progress=progress or Progress(),
        )
    )


def filled_shares(
    positions_m: ArrayLike,
    triangles: ArrayLike,
    lower_m: ArrayLike,
    step_m: ArrayLike,
    counts: ArrayLike,
    progress: Progress | None = None,
) -> NDArray[np.float32]:
    """How much of each box of a lattice a closed mesh fills, in [0, 1], of shape ``counts``.

    ``lower_m`` is the first box's lower corner, ``step_m`` a box's sides: (3,) each. Parts of the mesh that overlap
    count once. Raises InvalidInput, which names the vertex, the edge at which it is open, or the setting; and
    Cancelled.
    """
    lower, step = (np.asarray(value, np.float64).tolist() for value in (lower_m, step_m))
    return _native.filled_shares(
        positions=points(np.asarray(positions_m, np.float32), "positions_m"),
        triangles=indices(triangles, "triangles"),
        lower=lower,
        step=step,
        counts=[int(count) for count in np.asarray(counts)],
        progress=progress or Progress(),
    )
