# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels of a cube as a graph: what they are, asked and traced as they are packed; and its files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyndall import _native
from tyndall._native import Progress

from .checks import indices, points, refuse


@dataclass(frozen=True, kw_only=True)
class LevelCounts:
    """How many cubes of one size the voxels take."""

    side: int  #: In voxels.
    node_count: int  #: Distinct ones, which are stored; 0 for a side of 2: those are bytes of their brick's word.
    tree_node_count: int  #: Those of an octree, which shares nothing.


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
    def bytes_by_part(self) -> dict[str, int]:
        """What ``geometry_bytes`` is the sum of."""
        return self._native.bytes_by_part

    def levels(self, progress: Progress | None = None) -> list[LevelCounts]:
        """From cubes of 2 voxels a side to the whole one; none of an empty DAG. Reads every node. Raises Cancelled."""
        return [
            LevelCounts(side=1 << level, node_count=distinct, tree_node_count=in_tree)
            for level, distinct, in_tree in self._native.levels(progress or Progress())
        ]

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

    def coarse_cubes(
        self, level: int, most_cubes: int, progress: Progress | None = None
    ) -> tuple[NDArray[np.uint32], int]:
        """Cubes of a grid of 2^level a side that hold a voxel, (k, 3), in Morton order; and their level.

        That is lower than ``level`` where there would be more than ``most_cubes``, and never finer than the voxels.
        Takes as long as there are cubes, however many voxels lie in them. Raises Cancelled.
        """
        return self._native.coarse_cubes(level, most_cubes, progress or Progress())

    def trace(
        self, origins_m: ArrayLike, directions: ArrayLike, progress: Progress | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float32]]:
        """The first voxel along each ray: distance in metres, (k,); voxel, (k, 3); normal of its face, (k, 3).

        ``origins_m`` and ``directions``: (k, 3); directions may have any length. A miss has an infinite distance. A ray
        that begins in a voxel hits it at 0, without a normal. Raises InvalidInput and Cancelled.
        """
        origins = np.ascontiguousarray(points(origins_m, "origins_m"), np.float64)
        ways = np.ascontiguousarray(points(directions, "directions"), np.float64)
        if origins.shape != ways.shape:
            raise refuse(f"{len(origins)} origins_m, but {len(ways)} directions")
        return self._native.trace(origins, ways, progress or Progress())

    def save(self, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
        """Write a ``.tdag`` file, whole or not at all. Raises IoError, which names the path, and Cancelled."""
        self._native.save(path, progress or Progress())


def load(path: str | os.PathLike[str], progress: Progress | None = None) -> VoxelDag:
    """Read a ``.tdag`` file. Raises IoError, which names the path and the section that is damaged, and Cancelled."""
    return VoxelDag(_native.load_voxel_dag(path, progress or Progress()))
