# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that shows what a light sees, before and after its edits."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from support.small_scenes import empty_scene, light, plane


def pixels(image: bpy.types.Image) -> np.ndarray:
    values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)[..., 0]


@pytest.fixture
def lamp() -> bpy.types.Object:
    empty_scene()
    plane()
    thing = light("SUN", (0, 0, 5))
    bpy.context.view_layer.objects.active = thing
    return thing


def test_the_maps_become_images_and_are_written_anew(lamp: bpy.types.Object) -> None:
    assert bpy.ops.tyndall.occluder_edit_add(kind="HOLES") == {"FINISHED"}
    edit = lamp.data.tyndall.occluder_edits[0]
    edit.noise.probability = 1.0
    assert bpy.ops.tyndall.show_light_depth(resolution=64) == {"FINISHED"}
    before, after = (bpy.data.images[f"{lamp.name} depth {when}"] for when in ("before", "after"))
    assert (pixels(before) == 0.0).any()
    assert (pixels(after) == 1.0).all()
    edit.is_enabled = False
    assert bpy.ops.tyndall.show_light_depth(resolution=32) == {"FINISHED"}
    assert max(after.size) <= 40
    assert np.array_equal(pixels(after), pixels(before))


def test_without_an_occluder_it_says_so(lamp: bpy.types.Object) -> None:
    for thing in [thing for thing in bpy.data.objects if thing.type == "MESH"]:
        bpy.data.objects.remove(thing)
    with pytest.raises(RuntimeError, match=f'nothing casts a shadow before light "{lamp.name}"'):
        bpy.ops.tyndall.show_light_depth()
