# SPDX-License-Identifier: GPL-3.0-or-later
"""Cubes of a grid as what is seen of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def exposed_cubes(cubes: NDArray[np.uint32]) -> list[NDArray[np.intp]]:
    """Indices of the cubes with a face that no other one covers.

    One array for each way that a face looks: down x, up x, down y, up y, down z, up z.
    """
    places = cubes.astype(np.int64) + 1
    codes = _codes(places)
    steps = np.repeat(np.eye(3, dtype=np.int64), 2, axis=0) * [[-1], [1], [-1], [1], [-1], [1]]
    return [np.flatnonzero(~np.isin(_codes(places + step), codes)) for step in steps]


def exposed_faces(cubes: NDArray[np.uint32], exposed: list[NDArray[np.intp]] | None = None) -> list[NDArray[np.uint32]]:
    """Corners of those faces, (m, 4, 3) each, counter-clockwise as seen from outside. ``exposed``: exposed_cubes()."""
    exposed = exposed_cubes(cubes) if exposed is None else exposed
    return [cubes[indices][:, None, :] + _quad(way // 2, way % 2) for way, indices in enumerate(exposed)]


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
