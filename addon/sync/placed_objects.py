# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene description takes of a placement whatever is placed: a mesh, strands or voxels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .random_numbers import as_unit_floats

if TYPE_CHECKING:
    from .instances import Placement


def placed(placement: Placement) -> dict[str, Any]:
    """All arguments of ``tyndall.scene_description.PlacedObjects``."""
    return {
        "world_from_object": placement.world_from_object(),
        "object_names": (placement.object_name,) * len(placement.matrices),
        "is_camera_visible": placement.is_camera_visible,
        "casts_shadow": placement.casts_shadow,
        "is_bounce_visible": placement.is_bounce_visible,
        "is_mirror_visible": placement.is_mirror_visible,
        "is_glass_visible": placement.is_glass_visible,
        "lights_media": placement.lights_media,
        "is_held_out": placement.is_held_out,
        "is_shadow_catcher": placement.is_shadow_catcher,
        "lighting": placement.lighting,
        "color": placement.color,
        "pass_index": float(placement.pass_index),
        "random": as_unit_floats(placement.random_numbers),
    }
