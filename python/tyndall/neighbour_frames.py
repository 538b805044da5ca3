# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames before and after one, for its Vector pass: where instances and the vertices of meshes are in them.

Differs:  objects are found again by name and by the order in which they are read; what is not found, or more or fewer
          instances, stands still.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene_description import Camera, Instances, SceneDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class Neighbour:
    """Another frame."""

    description: SceneDescription
    camera: Camera


@dataclass(frozen=True, kw_only=True, eq=False)
class Neighbours:
    """Of a frame whose description is ``now``."""

    now: SceneDescription
    before: Neighbour
    after: Neighbour


def native_neighbours(
    neighbours: Neighbours,
    has_mesh: Callable[[str], bool],
    instance_count: int,
    origin_in_world: NDArray[np.float64],
    native_camera: Callable[[Camera], Any],
    reports: list[str],
) -> tuple[Any, Any]:
    """What the native side takes. ``has_mesh``: whether the scene has the mesh of this key; the others are left out."""
    groups = [group for group in neighbours.now.instances if has_mesh(group.mesh.key)]
    if sum(len(group.object_names) for group in groups) != instance_count:  # the native ones have other numbers
        reports.append("Pass Vector: beside instances that cannot be drawn it has the camera's motion alone")
        groups = []

    def arguments(neighbour: Neighbour) -> tuple[Any, NDArray[np.float32], list[tuple[int, NDArray[np.float32]]]]:
        matrices, deformed = _motions(groups, neighbour.description.instances, origin_in_world)
        return native_camera(neighbour.camera), matrices, deformed

    return arguments(neighbours.before), arguments(neighbours.after)


def _motions(
    groups: list[Instances], there: tuple[Instances, ...], origin: NDArray[np.float64]
) -> tuple[NDArray[np.float32], list[tuple[int, NDArray[np.float32]]]]:
    """By instance: from here to there; and those whose vertices move. No matrices where nothing moves."""
    found: dict[tuple[str, ...], list[Instances]] = defaultdict(list)
    for group in reversed(there):
        found[group.object_names].append(group)
    counts = [len(group.object_names) for group in groups]
    firsts = np.cumsum([0, *counts])
    matrices: NDArray[np.float32] | None = None
    deformed: list[tuple[int, NDArray[np.float32]]] = []
    for group, first, end in zip(groups, firsts[:-1], firsts[1:], strict=True):
        others = found[group.object_names]
        other = others.pop() if others else group
        if other.mesh.key != group.mesh.key and _has_same_triangles(group, other):
            deformed += [
                (int(first) + index, _places(other, index, origin)) for index in range(len(group.object_names))
            ]
        elif not np.array_equal(other.world_from_object, group.world_from_object):
            if matrices is None:
                matrices = np.tile(np.eye(4, dtype=np.float32), (int(firsts[-1]), 1, 1))
            matrices[first:end] = _there_from_here(group, other, origin)
    return np.zeros((0, 4, 4), np.float32) if matrices is None else matrices, deformed


def _has_same_triangles(group: Instances, other: Instances) -> bool:
    return len(group.mesh.positions) == len(other.mesh.positions) and np.array_equal(
        group.mesh.triangles, other.mesh.triangles
    )


def _places(group: Instances, index: int, origin: NDArray[np.float64]) -> NDArray[np.float32]:
    """Of vertices, in the scene's space."""
    matrix = group.world_from_object[index]
    places = group.mesh.positions.astype(np.float64) @ matrix[:3, :3].T + (matrix[:3, 3] - origin)
    return np.ascontiguousarray(places, np.float32)


def _there_from_here(group: Instances, other: Instances, origin: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 4, 4), in the scene's space; what has no extent here stays."""
    here, there = group.world_from_object.copy(), other.world_from_object.copy()
    here[:, :3, 3] -= origin
    there[:, :3, 3] -= origin
    is_flat = np.linalg.det(here[:, :3, :3]) == 0.0
    here[is_flat] = there[is_flat] = np.eye(4)
    moved: NDArray[np.float64] = there @ np.linalg.inv(here)
    return moved
