# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a scene stands elsewhere than in the description before, found without looking at what is the same object.

Differs: descriptions are never changed, so what two of them share is the same; of 100,000 groups one comparison of
addresses each is left.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import compress, count
from operator import is_not

import numpy as np

from .fingerprints import ARRAYS_OF_INSTANCES, PLAIN_OF_INSTANCES, fingerprint
from .scene_description import Instances, SceneDescription

MOST_MOVED = 4096  #: Groups; of more a new scene is built.
_SHARED = ("voxel_objects", "strand_objects", "materials", "media", "volumes")


def moved_groups(before: SceneDescription, after: SceneDescription) -> list[int] | None:
    """Which of ``after.instances`` stand elsewhere; None where more than places may differ. Lights do not count."""
    if (
        not (after.instances or after.voxel_objects or after.strand_objects)  # then lights say where the scene is
        or any(getattr(before, name) is not getattr(after, name) for name in _SHARED)
        or before.world.medium is not after.world.medium
        or before.light_groups != after.light_groups
        or len(before.instances) != len(after.instances)
    ):
        return None
    changed = list(compress(count(), map(is_not, before.instances, after.instances)))
    if len(changed) > MOST_MOVED:
        return None
    are_alike = all(_are_alike(before.instances[index], after.instances[index]) for index in changed)
    return changed if are_alike else None


def sharing(before: SceneDescription, after: SceneDescription) -> SceneDescription:
    """``after`` with all parts of ``before`` that it has, too, in their place: of the rest alone something is new."""
    same = {
        name: getattr(before, name)
        for name in _SHARED
        if fingerprint(getattr(before, name)) == fingerprint(getattr(after, name))
    }
    if len(before.instances) == len(after.instances):
        same["instances"] = tuple(
            one if one is other or fingerprint(one) == fingerprint(other) else other
            for one, other in zip(before.instances, after.instances, strict=True)
        )
    return replace(after, **same)


def is_same(before: SceneDescription, after: SceneDescription) -> bool:
    """Whether both give the same picture. Cheap where they share most of their groups."""
    if before is after:
        return True
    changed = moved_groups(before, after)
    if changed is None:
        return fingerprint(replace(before, reports=())) == fingerprint(replace(after, reports=()))
    pairs = [(before.instances[index], after.instances[index]) for index in changed]
    return all(np.array_equal(one.world_from_object, other.world_from_object) for one, other in pairs) and (
        fingerprint((before.lights, before.world)) == fingerprint((after.lights, after.world))
    )


def _are_alike(before: Instances, after: Instances) -> bool:
    """But for where they stand."""
    if before.mesh.key != after.mesh.key or before.world_from_object.shape != after.world_from_object.shape:
        return False
    for name in ARRAYS_OF_INSTANCES:
        one, other = getattr(before, name), getattr(after, name)
        if one is None or other is None:
            if one is not other:
                return False
        elif not np.array_equal(one, other, equal_nan=True):
            return False
    return all(getattr(before, name) == getattr(after, name) for name in PLAIN_OF_INSTANCES)
