# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of instances as the arrays that a native scene takes: one entry per instance, or per name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene_description import Instances, PlacedObjects

NO_PARTICLE = NO_ROW = 0xFFFFFFFF  #: As native/scene/scene.hpp has them.


def names_of(groups: list[Instances]) -> tuple[list[str], list[int], NDArray[np.uint32]]:
    """Names, how many of them each group has, and which of them each instance: a group seldom has more than one."""
    names: list[str] = []
    name_counts: list[int] = []
    indices: list[NDArray[np.uint32]] = [np.zeros(0, np.uint32)]
    for group in groups:
        own = group.object_names
        is_one = not own or own.count(own[0]) == len(own)
        indices.append(np.arange(len(own), dtype=np.uint32) * np.uint32(not is_one) + np.uint32(len(names)))
        name_counts.append(min(len(own), 1) if is_one else len(own))
        names += own[: name_counts[-1]]
    return names, name_counts, np.concatenate(indices)


def randoms_of(groups: Sequence[PlacedObjects]) -> NDArray[np.float32]:
    """Of every instance."""
    each = (np.zeros(len(group.object_names), np.float32) if group.random is None else group.random for group in groups)
    return np.concatenate([np.zeros(0, np.float32), *each])


def particles_of(groups: list[Instances]) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """The states of all particles, and which of them each instance is; both empty where none is one."""
    if all(group.particles is None for group in groups):
        return np.zeros((0, 14), np.float32), np.zeros(0, np.uint32)
    states: list[NDArray[np.float32]] = []
    indices: list[NDArray[np.uint32]] = []
    count = 0
    for group in groups:
        of_group = np.full(len(group.object_names), NO_PARTICLE, np.uint32)
        if group.particles is not None:
            is_one = ~np.isnan(group.particles[:, 0])
            found = group.particles[is_one]
            of_group[is_one] = np.arange(count, count + len(found), dtype=np.uint32)
            states.append(found)
            count += len(found)
        indices.append(of_group)
    return np.ascontiguousarray(np.concatenate(states), np.float32), np.concatenate(indices)


def instancer_values_of(groups: list[Instances]) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """(rows, values, 4), and which row each instance has; both empty where none has one."""
    found = [group.instancer_values for group in groups if group.instancer_values is not None]
    if not found:
        return np.zeros((0, 0, 4), np.float32), np.zeros(0, np.uint32)
    indices: list[NDArray[np.uint32]] = []
    count = 0
    for group in groups:
        own = len(group.object_names)
        if group.instancer_values is None:
            indices.append(np.full(own, NO_ROW, np.uint32))
        else:
            indices.append(np.arange(count, count + own, dtype=np.uint32))
            count += own
    return np.ascontiguousarray(np.concatenate(found), np.float32), np.concatenate(indices)


def colors_of(groups: Sequence[PlacedObjects], counts: list[int]) -> NDArray[np.float32]:
    """As often as ``counts`` say, (n, 4)."""
    each = np.array([group.color for group in groups], np.float32).reshape(-1, 4)
    return np.repeat(each, counts, axis=0)


def repeated(values: Iterable[float], counts: list[int], dtype: type[np.number[Any]]) -> NDArray[Any]:
    """Each value as often as ``counts`` say."""
    return np.repeat(np.array(list(values), dtype=dtype), counts)
