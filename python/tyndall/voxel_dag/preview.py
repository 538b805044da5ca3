# SPDX-License-Identifier: GPL-3.0-or-later
"""Coarse pictures of a graph's voxels: the cubes of one level that are not empty, at most so many, and their faces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tyndall._native import Progress

from .dag import VoxelDag


def preview(
    dag: VoxelDag, level: int, most_cubes: int, progress: Progress | None = None
) -> tuple[NDArray[np.uint32], int]:
    """Cubes of a grid of 2^level a side that hold a voxel, (k, 3), in Morton order; and their level.

    That is lower than ``level`` where there would be more than ``most_cubes``, and never finer than the voxels. Goes
    through all voxels once. Raises Cancelled.
    """
    finest = dag.resolution.bit_length() - 1
    level = min(level, finest)
    parts = [np.zeros((0, 3), np.uint32)]
    for voxels in _polled(dag, progress or Progress()):
        parts.append(_without_repeats(voxels >> np.uint32(finest - level)))
        if sum(map(len, parts)) > most_cubes:
            parts = [_without_repeats(np.concatenate(parts))]
            while len(parts[0]) > most_cubes and level > 0:
                level -= 1
                parts = [_without_repeats(parts[0] >> np.uint32(1))]
    return _without_repeats(np.concatenate(parts)), level


def _polled(dag: VoxelDag, progress: Progress) -> Iterator[NDArray[np.uint32]]:
    for voxels in dag.coordinates():
        progress.poll()
        yield voxels


def _without_repeats(cubes: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """In Morton order equal ones follow each other."""
    is_new = np.ones(len(cubes), np.bool_)
    is_new[1:] = (cubes[1:] != cubes[:-1]).any(axis=1)
    return cubes[is_new]


def exposed_faces(cubes: NDArray[np.uint32]) -> list[NDArray[np.uint32]]:
    """Corners of the faces that no other cube covers, (m, 4, 3) each, counter-clockwise as seen from outside.

    One array for each way that a face looks: down x, up x, down y, up y, down z, up z.
    """
    places = cubes.astype(np.int64) + 1
    codes = _codes(places)
    faces = []
    for axis in range(3):
        for end in (0, 1):
            towards = np.zeros(3, np.int64)
            towards[axis] = 2 * end - 1
            bare = cubes[~np.isin(_codes(places + towards), codes)]
            faces.append(bare[:, None, :] + _quad(axis, end))
    return faces


def _codes(places: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number for each; at most 2^18 along each axis."""
    return places[:, 0] << 40 | places[:, 1] << 20 | places[:, 2]


def _quad(axis: int, end: int) -> NDArray[np.uint32]:
    """Corners of a face of the unit cube, (4, 3)."""
    turn = [(0, 0), (1, 0), (1, 1), (0, 1)] if end == 1 else [(0, 0), (0, 1), (1, 1), (1, 0)]
    corners = np.empty((4, 3), np.uint32)
    corners[:, axis] = end
    corners[:, [(axis + 1) % 3, (axis + 2) % 3]] = turn
    return corners
