# SPDX-License-Identifier: GPL-3.0-or-later
"""What Geometry > Pointiness and Random Per Island say of a mesh: by its edges, a number at each vertex. No bpy here.

Based on: Cycles 4.5, intern/cycles/blender/mesh.cpp and src/util/disjoint_set.h, for what it computes: the angle
          between a vertex's normal and the mean direction of its edges, averaged with its neighbours'; and the number
          of an island's root, hashed. The roots are those of unions by rank in the order of edges: hence a loop.
Differs:  vertices are one where their coordinates are equal; Cycles forgives a difference of the last digits.
Cost:     of a million edges, 1 s for the islands, 1.4 s for pointiness.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .random_numbers import as_unit_floats, hashes_of_one
from .unit_vectors import unit_vectors

if TYPE_CHECKING:
    from numpy.typing import NDArray


def pointiness(
    positions: NDArray[np.float32], normals: NDArray[np.float32], edges: NDArray[np.intp]
) -> NDArray[np.float32]:
    """From 0, where a vertex points out, to 1, (vertices,); 0 without an edge. ``edges``, (n, 2), of vertices."""
    _, first, place = np.unique(positions + np.float32(0.0), axis=0, return_index=True, return_inverse=True)
    place = place.reshape(-1)
    ends = np.unique(np.sort(place[edges], axis=1), axis=0)  # each edge once
    places, count = positions[first].astype(np.float64), len(first)
    normal = unit_vectors(_sums(count, [(place, normals.astype(np.float64))]))
    along = unit_vectors(places[ends[:, 1]] - places[ends[:, 0]])
    edge_count = np.bincount(ends.ravel(), minlength=count)
    mean = _sums(count, [(ends[:, 0], along), (ends[:, 1], -along)]) / np.maximum(edge_count, 1)[:, None]
    own = np.where(edge_count > 0, np.arccos(np.clip((normal * mean).sum(axis=1), -1.0, 1.0)) / np.pi, 0.0)
    around = _sums(count, [(ends[:, 0], own[ends[:, 1], None]), (ends[:, 1], own[ends[:, 0], None])])[:, 0]
    smooth: NDArray[np.float32] = ((own + around) / (edge_count + 1)).astype(np.float32)[place]
    return smooth


def random_per_island(vertex_count: int, edges: NDArray[np.intp]) -> NDArray[np.float32]:
    """The same number from 0 to 1 for all vertices that edges connect, (vertices,)."""
    parents, ranks = list(range(vertex_count)), [0] * vertex_count
    for one, other in edges.tolist():
        high, low = _root(parents, one), _root(parents, other)
        if high == low:
            continue
        if ranks[high] < ranks[low]:
            high, low = low, high
        parents[low] = high
        ranks[high] += ranks[high] == ranks[low]
    roots = np.array(parents, np.intp)
    while not np.array_equal(roots[roots], roots):
        roots = roots[roots]
    return as_unit_floats(hashes_of_one(roots.astype(np.uint32)))


def _root(parents: list[int], vertex: int) -> int:
    while (parent := parents[vertex]) != vertex:
        parents[vertex] = vertex = parents[parent]  # the way is halved
    return vertex


def _sums(count: int, parts: list[tuple[NDArray[np.intp], NDArray[np.float64]]]) -> NDArray[np.float64]:
    """Of rows by their place."""
    channels = range(parts[0][1].shape[1])
    columns = [sum(np.bincount(at, rows[:, i], minlength=count) for at, rows in parts) for i in channels]
    return np.stack(columns, axis=1)
