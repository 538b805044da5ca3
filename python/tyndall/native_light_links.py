# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups and light linking as the native side counts them: groups by their place in the scene, sets by bits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .scene_description import LightLinks, ObjectLighting

if TYPE_CHECKING:
    from collections.abc import Sequence


_NO_GROUP = 255  #: What native lights have that are in none.
_PLAIN = ObjectLighting()


def group_index(name: str, light_groups: Sequence[str]) -> int:
    """Of a light's group; one that the scene does not hold apart is none."""
    return light_groups.index(name) if name in light_groups else _NO_GROUP


def link_masks(links: LightLinks | None) -> tuple[int, int]:
    """Of receivers and of blockers; None: all of both."""
    links = links if links is not None else LightLinks()
    return links.receiver_sets, links.blocker_sets


def lighting_arrays(
    each: Sequence[ObjectLighting | None], counts: Sequence[int], light_groups: Sequence[str]
) -> dict[str, Any]:
    """What a native scene takes of objects' names: each entry as often as ``counts`` say."""
    if all(lighting is None for lighting in each):  # of 100,000 objects, most scenes' case
        count = sum(counts)
        return {
            "object_light_groups": np.full(count, _NO_GROUP, np.uint8),
            "object_sets": np.zeros((count, 2), np.uint8),
            "object_links": np.full((count, 2), ~np.uint64(0), np.uint64),
        }
    known = [lighting if lighting is not None else _PLAIN for lighting in each]
    groups = [group_index(lighting.light_group, light_groups) for lighting in known]
    sets = [(lighting.receiver_set, lighting.blocker_set) for lighting in known]
    links = [link_masks(lighting.links) for lighting in known]
    return {
        "object_light_groups": np.repeat(np.array(groups, np.uint8), counts),
        "object_sets": np.repeat(np.array(sets, np.uint8).reshape(-1, 2), counts, axis=0),
        "object_links": np.repeat(np.array(links, np.uint64).reshape(-1, 2), counts, axis=0),
    }
