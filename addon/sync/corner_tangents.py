# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents of meshes with faces of any number of corners, by their triangles: Blender knows those of three and four.

Based on: Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", thesis, University of Copenhagen 2008: a corner's
          tangent is the mean of those of the triangles around it that share its place, normal and UV coordinates and
          its side of the map, weighted by their angles there.
Differs:  a corner that several triangles of one face share has one tangent. Where more than two triangles meet at an
          edge, they are neighbours in pairs, in the order of triangles. No bpy here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .unit_vectors import unit_vectors

if TYPE_CHECKING:
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]

_NEXT, _LAST = (1, 2, 0), (2, 0, 1)


def corner_tangents(
    positions: NDArray[np.float32],
    normals: NDArray[np.float32],
    uvs: NDArray[np.float32],
    triangles: NDArray[np.intp],
) -> NDArray[np.float32]:
    """Tangent and side of v, (corners, 4), of positions and normals (corners, 3) and UV coordinates (corners, 2).

    ``triangles``, (n, 3), are indices of corners. Corners of no triangle, and those whose triangles are all points or
    lines on the map, have a tangent of 0.
    """
    along, is_turned_over, has_area = _along_u(positions[triangles], uvs[triangles])
    group = _groups(_welded(positions, normals, uvs)[triangles], is_turned_over)
    weighted = _weighted(positions[triangles], normals[triangles].astype(np.float64), along)
    weighted[~has_area] = 0.0
    sums = np.stack(
        [np.bincount(group.ravel(), weighted[..., axis].ravel(), minlength=group.size) for axis in range(3)], axis=1
    )
    of_corners = np.zeros((len(positions), 4), np.float32)
    of_corners[triangles, :3] = unit_vectors(sums)[group]
    of_corners[triangles, 3] = np.where(is_turned_over, -1.0, 1.0)[:, None]
    return of_corners


def _along_u(
    corners: NDArray[np.float32], uvs: NDArray[np.float32]
) -> tuple[FloatArray, NDArray[np.bool_], NDArray[np.bool_]]:
    """Per triangle the direction in which u grows, (n, 3), whether the map shows it turned over, and at all."""
    places, on_map = corners.astype(np.float64), uvs.astype(np.float64)
    first, second = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    (u1, v1), (u2, v2) = ((on_map[:, i] - on_map[:, 0]).T for i in (1, 2))
    area = u1 * v2 - v1 * u2
    along = unit_vectors((first * v2[:, None] - second * v1[:, None]) * np.sign(area)[:, None])
    return along, area < 0.0, area != 0.0


def _welded(positions: NDArray[np.float32], normals: NDArray[np.float32], uvs: NDArray[np.float32]) -> NDArray[np.intp]:
    """A number for each corner; those that share place, normal and UV coordinates have one."""
    values = np.concatenate([positions, normals, uvs], axis=1, dtype=np.float32) + np.float32(0.0)  # no -0
    rows = np.ascontiguousarray(values).view(np.dtype((np.void, values.shape[1] * 4))).ravel()
    _, numbers = np.unique(rows, return_inverse=True)
    return numbers.reshape(-1).astype(np.intp)


def _groups(places: NDArray[np.intp], is_turned_over: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each corner of each triangle, (n, 3), the group that shares a tangent: a number below 3 n."""
    count = len(places)
    start, end = places, places[:, _NEXT]
    slots = np.arange(3 * count).reshape(count, 3)  # a slot is a corner of a triangle
    low, high = np.minimum(start, end).ravel(), np.maximum(start, end).ravel()
    order = np.lexsort((slots.ravel(), high, low))
    one, other = order[:-1], order[1:]
    meets = (low[one] == low[other]) & (high[one] == high[other]) & (start.ravel()[one] == end.ravel()[other])
    meets &= is_turned_over[one // 3] == is_turned_over[other // 3]
    meets[1:] &= ~meets[:-1]  # an edge is shared by two
    one, other = one[meets], other[meets]
    following = slots[:, _NEXT].ravel()
    # Across an edge the start of the one is the end of the other, and the other way round.
    return _connected(
        3 * count, np.concatenate([one, following[one]]), np.concatenate([following[other], other])
    ).reshape(count, 3)


def _connected(count: int, one: NDArray[np.intp], other: NDArray[np.intp]) -> NDArray[np.intp]:
    """The lowest number that each of ``count`` reaches over pairs."""
    lowest = np.arange(count)
    while True:
        before = lowest.copy()
        least = np.minimum(lowest[one], lowest[other])
        for ends in (one, other):
            np.minimum.at(lowest, before[ends], least)
            np.minimum.at(lowest, ends, least)
        lowest = lowest[lowest]
        if np.array_equal(lowest, before):
            return lowest


def _weighted(corners: NDArray[np.float32], normals: FloatArray, along: FloatArray) -> FloatArray:
    """The triangles' directions at their corners, (n, 3, 3): across the normal there, times the angle."""
    corners = corners.astype(np.float64)
    ahead, back = (unit_vectors(_across(corners[:, turn] - corners, normals)) for turn in (_NEXT, _LAST))
    angles = np.arccos(np.clip((ahead * back).sum(axis=2), -1.0, 1.0))
    weighted: FloatArray = unit_vectors(_across(along[:, None], normals)) * angles[..., None]
    return weighted


def _across(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    across: FloatArray = vectors - normals * (vectors * normals).sum(axis=-1, keepdims=True)
    return across
