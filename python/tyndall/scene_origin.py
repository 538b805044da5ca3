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
    spread_m = float(np.median(np.abs(points - median).max(axis=1)))
    step_m = 2.0 ** np.ceil(np.log2(4.0 * min(max(spread_m, 0.25), 1e30)))
    origin: NDArray[np.float64] = np.round(median / step_m) * step_m
    return origin
