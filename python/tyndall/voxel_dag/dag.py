# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels of a cube as a graph: what they are, asked and traced as they are packed; and its files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyndall import _native
from tyndall._native import Progress

from .checks import MOST_INDEX, doublings, indices, per_row, points, refuse, whole
from .exports import Exports

_keys = count()

#: Below it a cube is less than a brick.
LEAST_LEVEL = 2


@dataclass(frozen=True, kw_only=True)
class LevelCounts:
    """How many cubes of one size the voxels take."""

    side: int  #: In voxels.
    node_count: int  #: Distinct ones, which are stored; 0 for a side of 2: those are bytes of their brick's word.
    tree_node_count: int  #: Those of an octree, which shares nothing.


class VoxelDag(Exports):
    """Voxels of a cube. Immutable; safe from any thread."""

    def __init__(self, native: _native.VoxelDag) -> None:
        self._native = native
        self._key = next(_keys)

    @property
    def key(self) -> int:
        """No other object of this process has the same."""
        return self._key

    @property
    def native(self) -> _native.VoxelDag:
        """What the native side calls it by."""
        return self._native

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
        """What ``geometry_bytes`` and ``attribute_bytes`` are the sum of.

        Of attributes: counts, materials, indices, mean_materials and mean_indices.
        """
        return self._native.bytes_by_part

    def levels(self, progress: Progress | None = None) -> list[LevelCounts]:
        """From cubes of 2 voxels a side to the whole one; none of an empty DAG. Reads every node. Raises Cancelled."""
        return [
            LevelCounts(side=1 << level, node_count=distinct, tree_node_count=in_tree)
            for level, distinct, in_tree in self._native.levels(progress or Progress())
        ]

    @property
    def attribute_bytes(self) -> int:
        """Of colours, normals, channels and what finds them, as they lie in memory and in the file."""
        return self._native.attribute_bytes

    @property
    def attribute_errors(self) -> dict[str, float]:
        """What is lost, over voxels: ``mean_cie94``, ``most_cie94``, ``mean_degrees``, ``most_degrees``.

        Raises InvalidInput where there are no attributes.
        """
        return self._native.attribute_errors

    @property
    def has_colors(self) -> bool:
        """Whether voxels have colours."""
        return self._native.has_colors

    @property
    def has_normals(self) -> bool:
        """Whether voxels have normals."""
        return self._native.has_normals

    @property
    def channels(self) -> list[str]:
        """Names of further values."""
        return self._native.channels

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

    def colors_at(
        self, coordinates: ArrayLike, level: int | None = None, progress: Progress | None = None
    ) -> NDArray[np.uint8]:
        """Colours of voxels, (k, 3), as sRGB encodes them.

        At a ``level`` the mean, in linear light, of what is set of the cube around each, of which 2 ** level lie along
        a side. Raises InvalidInput, which names the first voxel that is not set, and Cancelled.
        """
        return self._native.colors_at(*self._cubes(coordinates, level), progress or Progress())

    def normals_at(
        self, coordinates: ArrayLike, level: int | None = None, progress: Progress | None = None
    ) -> NDArray[np.float32]:
        """Normals of voxels, (k, 3), of length 1; at a level, the direction of their sum, as colors_at() has it."""
        return self._native.normals_at(*self._cubes(coordinates, level), progress or Progress())

    def channel_at(
        self, name: str, coordinates: ArrayLike, level: int | None = None, progress: Progress | None = None
    ) -> NDArray[np.uint8]:
        """Values of a channel, (k,); at a level, their rounded mean, as colors_at() has it."""
        return self._native.channel_at(name, *self._cubes(coordinates, level), progress or Progress())

    def _cubes(self, coordinates: ArrayLike, level: int | None) -> tuple[NDArray[np.uint32], int]:
        return indices(coordinates, "coordinates"), doublings(level, self.resolution)

    def coarse_cubes(
        self, level: int, most_cubes: int, progress: Progress | None = None
    ) -> tuple[NDArray[np.uint32], int]:
        """Cubes of a grid of 2^level a side that hold a voxel, (k, 3), in Morton order; and their level.

        That is lower than ``level`` where there would be more than ``most_cubes``, and never finer than the voxels.
        Takes as long as there are cubes, however many voxels lie in them. Raises Cancelled.
        """
        return self._native.coarse_cubes(level, most_cubes, progress or Progress())

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

        ``level``: cubes, 2 ** level along a side, are hit whole, [1, log2 of the resolution]. ``spread``, one
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


def load(
    path: str | os.PathLike[str],
    progress: Progress | None = None,
    *,
    level: int | None = None,
    attributes: bool = True,
) -> VoxelDag:
    """Read a ``.tdag`` file. Raises IoError, which names the path and the section that is damaged, and Cancelled.

    ``level``: not the voxels, but the cubes of which 2 ** level lie along a side, at least 2, as voxels with their mean
    colours. Of the levels that a file has apart, nothing else is read. ``attributes=False``: the voxels alone; their
    colours, normals and channels are not read.
    """
    if level is None:
        read = _native.load_voxel_dag if attributes else _native.load_voxel_geometry
        return VoxelDag(read(path, progress or Progress()))
    if whole("level", level, 17) < LEAST_LEVEL:
        raise refuse(f"level is {level}: from 2 on, 4 cubes a side, there are voxels")
    return VoxelDag(_native.load_voxel_dag_top(path, level, progress or Progress()))
