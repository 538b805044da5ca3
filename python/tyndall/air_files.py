# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air as grids, for OpenVDB files and Blender's volumes, and painted air back from such grids.

Grids lie in the space of the painted box: [0, 1]^3 of it is the box, and voxel i of n has its centre at (i + 0.5) / n.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .air_tiles import VOLUME_KINDS, local_from_index
from .baked_air import bake_air
from .volumes import SparseGrid, from_dense, values_at

if TYPE_CHECKING:
    from ._native import Progress
    from .air_tiles import Resolution
    from .heterogeneity import Heterogeneity, PaintedAir
    from .scene_description import FloatArray

#: Shares of a voxel below this are rounding of matrices.
_ALIGNED = 1e-3


def baked_density(
    heterogeneity: Heterogeneity, resolution: Resolution, local_from_unit: ArrayLike, progress: Progress
) -> SparseGrid:
    """What the air scatters relative to even air, noise and paint together, as a grid "density".

    Raises InvalidInput as ``bake_air`` does, and Cancelled.
    """
    values = np.float32(heterogeneity.intensity) * bake_air(heterogeneity, resolution, progress)
    return from_dense("density", values.transpose(2, 1, 0), local_from_index(resolution, local_from_unit))


def painted_grids(painted: PaintedAir, resolution: Resolution, local_from_unit: ArrayLike) -> list[SparseGrid]:
    """Grids "amount", "level" and "intensity"; one of which nothing is painted has no leaves."""
    matrix = local_from_index(resolution, local_from_unit)
    grids = []
    for name, kind in VOLUME_KINDS.items():
        values: FloatArray | None = getattr(painted, name)
        across = np.empty((0, 0, 0), np.float32) if values is None else values.transpose(2, 1, 0)
        grids.append(from_dense(name, across, matrix, background=kind.neutral))
    return grids


def resolution_of(grid: SparseGrid, local_from_unit: ArrayLike) -> Resolution | None:
    """Voxels along the sides of the box if the grid's are those of a box like this one; None: it lies otherwise."""
    index_from_unit = np.linalg.inv(grid.local_from_index) @ np.asarray(local_from_unit, np.float64)
    size = np.rint(np.diag(index_from_unit)[:3])
    if (size < 1).any() or np.abs(index_from_unit[:3, :3] - np.diag(size)).max() > _ALIGNED:
        return None
    if np.abs(index_from_unit[:3, 3] + 0.5).max() > _ALIGNED:
        return None
    return int(size[0]), int(size[1]), int(size[2])


def painted_values(grid: SparseGrid, resolution: Resolution, local_from_unit: ArrayLike) -> FloatArray:
    """(nz, ny, nx): the grid at the voxels of a box of so many along x, y, z, trilinear; exact where voxels agree."""
    index_from_place = np.linalg.inv(grid.local_from_index) @ local_from_index(resolution, local_from_unit)
    places = np.stack(np.meshgrid(*(np.arange(count) for count in resolution), indexing="ij"), axis=-1).reshape(-1, 3)
    at = places @ index_from_place[:3, :3].T + index_from_place[:3, 3]
    nearest = np.rint(at)
    at = np.where(np.abs(at - nearest) < _ALIGNED, nearest, at)
    first = np.floor(at)
    share = (at - first).astype(np.float32)
    values = np.zeros(len(at), np.float32)
    for corner in product((0, 1), repeat=3):
        weights = np.prod(np.where(corner, share, 1.0 - share), axis=1)
        used = np.flatnonzero(weights)
        values[used] += weights[used] * values_at(grid, first[used].astype(np.int64) + corner)
    return np.ascontiguousarray(values.reshape(resolution).transpose(2, 1, 0))
