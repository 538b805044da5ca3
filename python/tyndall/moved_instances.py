# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a scene stands elsewhere than in the description before, found without looking at what is the same object.

Differs: descriptions are never changed, so what two of them share is the same; of 100,000 groups one comparison of
addresses each is left.
"""

from __future__ import annotations

from dataclasses import fields
from itertools import compress, count
from operator import is_not

import numpy as np

from .scene_description import Instances, SceneDescription

MOST_MOVED = 4096  #: Groups; of more a new scene is built.
_SHARED = ("voxel_objects", "strand_objects", "materials", "media", "volumes")


def moved_groups(before: SceneDescription, after: SceneDescription) -> list[int] | None:
    """Which of ``after.instances`` stand elsewhere; None where more than places may differ. Lights do not count."""
    if (
        not (after.instances or after.voxel_objects or after.strand_objects)  # then lights say where the scene is
        or any(getattr(before, name) is not getattr(after, name) for name in _SHARED)
        or before.world.medium is not after.world.medium
        or len(before.instances) != len(after.instances)
    ):
        return None
    changed = list(compress(count(), map(is_not, before.instances, after.instances)))
    if len(changed) > MOST_MOVED:
        return None
    are_alike = all(_are_alike(before.instances[index], after.instances[index]) for index in changed)
    return changed if are_alike else None


def _are_alike(before: Instances, after: Instances) -> bool:
    """But for where they stand."""
    if before.mesh.key != after.mesh.key or before.world_from_object.shape != after.world_from_object.shape:
        return False
    if before.random is None or after.random is None:
        if before.random is not after.random:
            return False
    elif not np.array_equal(before.random, after.random):
        return False
    names = {entry.name for entry in fields(Instances)} - {"mesh", "world_from_object", "random"}
    return all(getattr(before, name) == getattr(after, name) for name in names)
