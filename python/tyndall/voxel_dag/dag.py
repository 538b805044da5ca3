# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels of a cube as a graph: what they are, asked and traced as they are packed; and its files."""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyndall import _native
from tyndall._native import Progress

from .checks import MOST_INDEX, indices, per_row, points, refuse, whole


class VoxelDag:
    """Voxels of a cube. Immutable; safe from any thread."""

    def __init__(self, native: _native.VoxelDag) -> None:
        self._native = native

    @property
    def resolution(self) -> int:
        """Voxels a side."""
        return self._native.resolution

    @property
    def voxel_count(self) -> int:
        """Those that are set."""
        return self._native.voxel_count

    @property
    def node_count(self) -> int:
        """Distinct nodes, bricks of 4 x 4 x 4 voxels among them."""
        return self._native.node_count

    @property
    def geometry_bytes(self) -> int:
        """Of all nodes, as they lie in memory and in the file."""
        return self._native.geometry_bytes

    @property
    def bounds_m(self) -> NDArray[np.float64]:
        """Lower and upper corner of the cube, (2, 3)."""
        lower_m, side_m = self._native.bounds_m
        return np.array([lower_m, np.add(lower_m, side_m)])

    def contains(self, coordinates: ArrayLike) -> NDArray[np.bool_]:
        """Whether voxels are set, (k,), for whole numbers x, y and z, (k, 3). What lies outside is not.

        Raises InvalidInput.
        """
        return self._native.contains(indices(coordinates, "coordinates"))

    def coordinates(self) -> Iterator[NDArray[np.uint32]]:
        """All voxels in Morton order (x changes fastest), some at a time: (k, 3)."""
        return iter(self._native.coordinates())

    def trace(
        self,
        origins_m: ArrayLike,
        directions: ArrayLike,
        level: int | None = None,
        *,
        spread: ArrayLike = 0.0,
        progress: Progress | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float32]]:
        """The first voxel along each ray: distance in metres, (k,); voxel, (k, 3); normal of its face, (k, 3).

        ``origins_m`` and ``directions``: (k, 3); directions may have any length. A miss has an infinite distance. A ray
        that begins in a voxel hits it at 0, without a normal.

        ``level``: 1 traces the octants of the whole, each number more their octants, and None voxels. ``spread``, one
        number or (k,): how much wider a ray's cone becomes per metre; a cube that is no wider than the cone where it
        begins is hit whole. The voxel is then the lowest of that cube. Raises InvalidInput and Cancelled.
        """
        origins, ways = _rays(origins_m, directions)
        finest = self.resolution.bit_length() - 1
        return self._native.trace(
            origins,
            ways,
            finest if level is None else whole("level", level, finest),
            per_row(spread, len(origins), "spread"),
            progress or Progress(),
        )

    def occluded(
        self,
        origins_m: ArrayLike,
        directions: ArrayLike,
        end_m: ArrayLike = np.inf,
        progress: Progress | None = None,
    ) -> NDArray[np.bool_]:
        """Whether a voxel begins along each ray before ``end_m``, one number or (k,): (k,).

        ``origins_m`` and ``directions``: (k, 3); directions may have any length. Raises InvalidInput and Cancelled.
        """
        origins, ways = _rays(origins_m, directions)
        return self._native.occluded(origins, ways, per_row(end_m, len(origins), "end_m"), progress or Progress())

    def smooth_normals(
        self,
        coordinates: ArrayLike,
        radius: int = 3,
        directions: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> NDArray[np.float32]:
        """Normals of the surface that the voxels up to ``radius`` voxels around each one are, (k, 3).

        ``coordinates``: voxels x, y and z, (k, 3). Normals look against ``directions``, those of rays, (k, 3); without
        them to where fewer voxels are, out of a solid. They are 0 where the voxels around are no surface. Raises
        InvalidInput and Cancelled.
        """
        voxels = indices(coordinates, "coordinates")
        ways = np.ascontiguousarray(points([] if directions is None else directions, "directions"), np.float64)
        if directions is not None and ways.shape != voxels.shape:
            raise refuse(f"{len(voxels)} coordinates, but {len(ways)} directions")
        return self._native.smooth_normals(voxels, ways, whole("radius", radius, MOST_INDEX), progress or Progress())

    def save(self, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
        """Write a ``.tdag`` file, whole or not at all. Raises IoError, which names the path, and Cancelled."""
        self._native.save(path, progress or Progress())


def _rays(origins_m: ArrayLike, directions: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """As many origins as directions."""
    origins = np.ascontiguousarray(points(origins_m, "origins_m"), np.float64)
    ways = np.ascontiguousarray(points(directions, "directions"), np.float64)
    if origins.shape != ways.shape:
        raise refuse(f"{len(origins)} origins_m, but {len(ways)} directions")
    return origins, ways


def load(path: str | os.PathLike[str], progress: Progress | None = None) -> VoxelDag:
    """Read a ``.tdag`` file. Raises IoError, which names the path and the section that is damaged, and Cancelled."""
    return VoxelDag(_native.load_voxel_dag(path, progress or Progress()))
