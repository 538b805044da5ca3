# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of a light's occluders, as an artist adds them, and as they are sent."""

from __future__ import annotations

import bpy
import numpy as np

from addon.item_lists import in_order
from tyndall.scene_description import OccluderEdit

from .small_scenes import cube, empty_scene, light, plane, read


def sun_over_cube() -> bpy.types.Light:
    """The active light of a scene with a cube on a floor."""
    empty_scene()
    cube()
    plane()
    thing = light("SUN", (0, 0, 5))
    bpy.context.view_layer.objects.active = thing
    return thing.data


def add_edits(*kinds: str) -> None:
    for kind in kinds:
        assert bpy.ops.tyndall.occluder_edit_add(kind=kind) == {"FINISHED"}


def names(owner: bpy.types.Light) -> list[str]:
    return [edit.name for edit in in_order(owner.tyndall.occluder_edits)]


def sent(light_name: str = "Sun") -> tuple[OccluderEdit, ...]:
    (description,) = [one for one in read().lights if one.name == light_name]
    return description.occluder_edits


def reports() -> list[str]:
    return [line for line in read().reports if "edit" in line]


def image(name: str, values: np.ndarray) -> bpy.types.Image:
    """Grey and opaque, from (height, width) display values."""
    made = bpy.data.images.new(name, values.shape[1], values.shape[0], alpha=True)
    pixels = np.ones((*values.shape, 4), np.float32)
    pixels[..., :3] = values[..., None]
    made.pixels.foreach_set(pixels.ravel())
    return made


def curves(owner: bpy.types.ID) -> dict[str, bpy.types.FCurve]:
    """By path; of the layers of an action since 4.4."""
    animation = owner.animation_data
    if not getattr(animation.action, "is_action_layered", False):
        found = list(animation.action.fcurves)
    else:
        strips = (strip for layer in animation.action.layers for strip in layer.strips)
        bags = (strip.channelbag(animation.action_slot) for strip in strips)
        found = [curve for bag in bags if bag for curve in bag.fcurves]
    return {curve.data_path: curve for curve in found}
