# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds in native memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import _native
from .direction_programs import build_direction_program
from .fingerprints import fingerprint
from .linear_colours import linear_texels
from .native_light_links import group_index
from .scene_description import SceneDescription, World
from .usable_parts import usable

if TYPE_CHECKING:
    from .native_scene import NativeParts


def build_world(description: SceneDescription, parts: NativeParts, reports: list[str]) -> _native.World:
    """The world's sampling tables take a while for a large image: kept as long as the world stays the same."""
    world = description.world
    group = group_index(world.light_group, description.light_groups)
    current = (fingerprint(world), group)
    if parts.world is None or parts.world[0] != current:
        found = usable([world], lambda one: _make_world(one, group), "World", reports)
        parts.world = (current, found[0] if found else _make_world(World(name=world.name), group))
    return parts.world[1]


def _make_world(world: World, light_group: int) -> _native.World:
    return _native.World(
        name=world.name,
        radiance=world.radiance,
        pixels=None if world.image is None else linear_texels(world.image),
        image_from_world=world.image_from_world.astype(np.float32, order="C"),
        seen_pixels=None if world.seen_image is None else linear_texels(world.seen_image),
        seen_program=None if world.seen_program is None else build_direction_program(world.seen_program),
        light_group=light_group,
        lights_surfaces=world.lights_surfaces,
        scatters_in_media=world.scatters_in_media,
    )
