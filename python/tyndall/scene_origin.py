# SPDX-License-Identifier: GPL-3.0-or-later
"""What native positions are relative to, so that float32 keeps its digits wherever the scene lies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .scene_description import Instances, SceneDescription


def places_of(groups: list[Instances], description: SceneDescription) -> NDArray[np.float64]:
    """Where all that has a place stands, (n, 3), the groups' instances first."""
    places = [group.world_from_object[:, :3, 3] for group in groups]
    places += [group.world_from_object[:, :3, 3] for group in description.voxel_objects]
    places += [group.world_from_object[:, :3, 3] for group in description.strand_objects]
    places += [volume.world_from_object[None, :3, 3] for volume in description.volumes]
    if not places:
        places = [light.world_from_light[None, :3, 3] for light in description.lights]
    return np.concatenate([*places, np.zeros((0, 3))])


def origin_of(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """The median of the placed objects, rounded: outliers do not move it, and motions seldom do.

    In whole metres, and in steps as large as the scene: where it moves, so do all coordinates, and nothing is kept.
    """
    points = places[np.isfinite(places).all(axis=1)]
    if len(points) == 0:
        return np.zeros(3)
    median = np.median(points, axis=0)
    return _rounded(median, float(np.median(np.abs(points - median).max(axis=1))))


def free_places(places: NDArray[np.float64]) -> int:
    """How many of them, whichever, may go anywhere without another ``origin_of`` them all: 0, or more by large steps.

    ``k`` of them move a median by no more than ``k`` steps among the sorted, and the distances to it by as much.
    """
    points = places[np.isfinite(places).all(axis=1)]
    middle = len(points) // 2
    counts = [count for count in _FREE if count < middle // 2]
    if not counts:
        return 0
    ends = [end for count in counts for end in (middle - 1 - count, middle + count)]
    sorted_points = np.partition(points, ends, axis=0)
    median = np.median(points, axis=0)
    distances = np.abs(points - median).max(axis=1)
    sorted_distances = np.partition(distances, ends)
    for count in counts:
        low, high = sorted_points[middle - 1 - count], sorted_points[middle + count]
        shift = 1.001 * float(np.maximum(high - median, median - low).max())
        near, far = sorted_distances[middle - 1 - count] - shift, sorted_distances[middle + count] + shift
        if _step_m(near) == _step_m(far) and np.array_equal(_rounded(low, near), _rounded(high, far)):
            return count
    return 0


#: Counts that are tried, most first.
_FREE = (4096, 512, 64, 8)


def _step_m(spread_m: float) -> float:
    return float(2.0 ** np.ceil(np.log2(4.0 * min(max(spread_m, 0.25), 1e30))))


def _rounded(median: NDArray[np.float64], spread_m: float) -> NDArray[np.float64]:
    step_m = _step_m(spread_m)
    origin: NDArray[np.float64] = np.round(median / step_m) * step_m
    return origin
