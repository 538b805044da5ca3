# SPDX-License-Identifier: GPL-3.0-or-later
"""Light shafts over the picture of Cycles: what the compositor puts together, against our own render of everything.

With a sun without size, no bounces and rays through pixel centres Cycles has no noise: pictures compare float by float.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import last_render, over_engine
from addon.engine import sessions
from addon.over_engine import compositor
from addon.over_engine.shafts_scene import shafts_scene_of
from support.exr import read_planes
from support.over_engine_scene import (
    HEIGHT_PX,
    WIDTH_PX,
    Picture,
    hall_in_fog,
    node_output,
    own_render,
    picture_without_fog,
    rendered,
    set_up,
    use_cycles,
)
from support.small_scenes import add, cube, light, node


@pytest.fixture
def hall(tmp_path: Path) -> bpy.types.Scene:
    return hall_in_fog(tmp_path)


def test_the_composite_is_picture_times_transmittance_plus_shafts(hall: bpy.types.Scene) -> None:
    """To float precision."""
    set_up(hall)
    composite = rendered(hall)[..., :3]
    shafts, transmittance = (node_output(hall, name)[..., :3] for name in ("Air Light", "Transmittance"))
    picture = picture_without_fog(hall)[..., :3]
    assert picture.max() > 0.2
    assert shafts.max() > 0.05
    assert transmittance.min() < 0.8
    assert np.allclose(composite, picture * transmittance + shafts, rtol=1e-6, atol=1e-7)


def test_strength_and_mask_are_inputs_of_the_node(hall: bpy.types.Scene) -> None:
    """Strength brightens the air and leaves what it takes away; where the mask is 0, the picture is the engine's."""
    set_up(hall)
    shafts, transmittance = (node_output(hall, name)[..., :3] for name in ("Air Light", "Transmittance"))
    picture = picture_without_fog(hall)[..., :3]
    inputs = compositor.compose_node(hall).inputs
    inputs["Strength"].default_value = 2.0
    assert np.allclose(rendered(hall)[..., :3], picture * transmittance + 2.0 * shafts, rtol=1e-6, atol=1e-7)
    inputs["Mask"].default_value = 0.25
    expected = picture * (0.75 + 0.25 * transmittance) + 0.5 * shafts
    assert np.allclose(rendered(hall)[..., :3], expected, rtol=1e-6, atol=1e-7)
    inputs["Mask"].default_value = 0.0
    assert np.array_equal(rendered(hall)[..., :3], picture)


def test_it_is_our_own_render_where_a_pixel_sees_one_depth(hall: bpy.types.Scene) -> None:
    """Of Cycles' picture and our air, and of everything by us: rays through pixel centres see one depth each.

    That takes Cycles' surfaces as dim as fog makes them: the fog that is left to us still shadows them there.
    """
    set_up(hall)
    composite = rendered(hall)
    own = own_render(hall)
    assert own[..., :3].max() > 0.2
    assert np.abs(composite - own).max() < 1e-6


@pytest.mark.dealt
def test_where_a_pixel_mixes_depths_the_error_is_their_covariance(hall: bpy.types.Scene) -> None:
    """Of a pixel over radiances L and transmittances T, mean(L) mean(T) stands for mean(L T)."""
    set_up(hall)
    fine = 16
    hall.render.resolution_x, hall.render.resolution_y = fine * WIDTH_PX, fine * HEIGHT_PX
    transmittance = blocks(node_output(hall, "Transmittance"), fine)
    radiance = blocks(picture_without_fog(hall), fine)
    hall.render.resolution_x, hall.render.resolution_y = WIDTH_PX, HEIGHT_PX

    use_cycles(hall, 256)
    hall.tyndall.pixel_samples, hall.tyndall.pixel_filter, hall.tyndall.filter_width_px = 256, "BOX", 1.0
    composite = rendered(hall)[..., :3]
    difference = composite - own_render(hall)[..., :3]
    covariance = (radiance * transmittance).mean(axis=2) - radiance.mean(axis=2) * transmittance.mean(axis=2)
    bound = np.ptp(radiance, axis=2) * np.ptp(transmittance, axis=2) / 4.0
    # 256 rays find an edge's share of a pixel to within a hundredth; the covariance is seven times as much.
    assert 0.05 < np.abs(difference).max() < 0.09
    assert np.abs(difference + covariance).max() < 0.01
    assert (np.abs(difference) < bound + 0.01).all()
    assert np.median(np.abs(difference)) < 1e-6, "most pixels see one depth"


@pytest.mark.dealt
def test_over_a_blurred_picture_the_air_blurs_too(hall: bpy.types.Scene) -> None:
    """The camera moves while Cycles' shutter is open: the error is at most what the air changes by in that time.

    Against the mean of our own renders over that time, L T + S: the composite has mean(L) T + S of the moment in the
    middle where the air is seen with a single sample, and mean(L) mean(T) + mean(S) with as many as there are moments.
    """
    camera = hall.camera
    for frame, x in ((1, -1.0), (3, 1.0)):
        camera.location.x = x
        camera.keyframe_insert("location", frame=frame)
    for curve in curves_of(camera):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    set_up(hall)
    moments = [(index + 0.5) / 32 - 0.25 for index in range(16)]  # of a shutter that is open for half a frame
    radiance, transmittance, shafts = [], [], []
    for moment in moments:
        hall.frame_set(2 if moment >= 0 else 1, subframe=moment % 1.0)
        transmittance.append(node_output(hall, "Transmittance")[..., :3])
        shafts.append(node_output(hall, "Air Light")[..., :3])
        radiance.append(picture_without_fog(hall)[..., :3])
    hall.frame_set(2)
    hall.cycles.samples, hall.render.use_motion_blur, hall.render.motion_blur_shutter = 256, True, 0.5
    blurred = rendered(hall)[..., :3]
    error = np.abs(blurred - np.mean(np.multiply(radiance, transmittance) + shafts, axis=0))
    bound = np.max(radiance, axis=0) * np.ptp(transmittance, axis=0) + np.ptp(shafts, axis=0)
    assert 0.03 < error.max() < 0.08
    assert (error < bound + 0.02).all(), "16 moments place an edge in time to a thirty-second of the shutter"
    assert np.median(error) < 1e-6
    hall.tyndall.pixel_samples, hall.tyndall.pixel_filter, hall.tyndall.filter_width_px = 16, "BOX", 0.01
    of_means = np.mean(radiance, axis=0) * np.mean(transmittance, axis=0) + np.mean(shafts, axis=0)
    error = np.abs(rendered(hall)[..., :3] - of_means)
    print("ERR2", error.max(), np.median(error))
    assert error.max() < 0.02
    assert np.median(error) < 1e-6


def curves_of(thing: bpy.types.Object) -> list[bpy.types.FCurve]:
    """Of an object's own action."""
    action = thing.animation_data.action
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return list(action.layers[0].strips[0].channelbag(thing.animation_data.action_slot).fcurves)


def blocks(picture: Picture, side_px: int) -> Picture:
    """Of each pixel, the finer ones in it: (height, width, side_px^2, 3)."""
    height, width = picture.shape[0] // side_px, picture.shape[1] // side_px
    split = picture[..., :3].reshape(height, side_px, width, side_px, 3)
    return split.transpose(0, 2, 1, 3, 4).reshape(height, width, side_px**2, 3)


@pytest.mark.parametrize("is_cropped", [False, True])
def test_a_border_shows_the_same_pixels(hall: bpy.types.Scene, *, is_cropped: bool) -> None:
    set_up(hall)
    whole = rendered(hall)
    render = hall.render
    render.use_border, render.use_crop_to_border = True, is_cropped
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.2, 0.7
    inside = (slice(3, 12), slice(8, 24))
    framed = rendered(hall)
    assert np.allclose(framed if is_cropped else framed[inside], whole[inside], atol=1e-6)
    if not is_cropped:
        framed[inside] = 0
        assert not framed.any()


def test_an_animation_follows_markers_and_keys(hall: bpy.types.Scene, tmp_path: Path) -> None:
    """Cameras bound to markers act in their own frame; so do keys of our settings, which are the artist's scene's."""
    second = add("Second", hall.camera.data.copy(), location=(-6, -7, 4))
    second.rotation_euler = (math.radians(70), 0, math.radians(-40))
    hall.timeline_markers.new("one", frame=1).camera = hall.camera
    hall.timeline_markers.new("two", frame=2).camera = second
    shafts = hall.tyndall.shafts
    for frame, attenuates in ((1, True), (3, False)):
        shafts.attenuates_light = attenuates
        shafts.keyframe_insert("attenuates_light", frame=frame)
    hall.frame_end = 3
    set_up(hall)
    hall.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(animation=True)
    pictures = [read_planes(tmp_path / f"frame_{frame:04d}.exr")[""] for frame in (1, 2, 3)]
    hall.animation_data_clear()
    hall.timeline_markers.clear()
    hall.render.filepath = str(tmp_path / "still.exr")
    cameras = (bpy.data.objects["Camera"], second, second)
    for picture, camera, attenuates in zip(pictures, cameras, (True, True, False), strict=True):
        hall.camera, shafts.attenuates_light = camera, attenuates
        assert np.allclose(picture, rendered(hall), atol=1e-6)
    assert np.abs(pictures[0] - pictures[1]).max() > 0.05
    assert np.abs(pictures[1] - pictures[2]).max() > 0.005


def test_from_the_second_frame_on_an_animation_keeps_lights_maps(hall: bpy.types.Scene, tmp_path: Path) -> None:
    """Blender tells the second scene's engine nothing of an animation; a still keeps none."""
    set_up(hall)
    hall.tyndall.shafts.method = "EPIPOLAR"
    hall.frame_end = 3
    hall.render.filepath = str(tmp_path / "frame_")
    kept: list[bool] = []

    def note(scene: bpy.types.Scene, *_: object) -> None:
        counts = last_render.statistics_of(scene.name)["counts"]
        kept.append(any(counts.get(f"{name}: kept", 0) > 0 for name in ("depth map", "slope rows")))

    bpy.app.handlers.render_post.append(note)
    try:
        bpy.ops.render.render(animation=True)
        bpy.ops.render.render()
    finally:
        bpy.app.handlers.render_post.remove(note)
    assert kept == [False, False, True, False]
    assert not sessions._kept, "nothing is kept after the last frame"  # noqa: SLF001


def test_of_several_view_layers_all_count_or_one(hall: bpy.types.Scene) -> None:
    """An object that any of them shows ends view rays, unless one layer is chosen."""
    collection = bpy.data.collections.new("Front")
    hall.collection.children.link(collection)
    wall = cube("Wall", bpy.data.materials["Paint"])
    hall.collection.objects.unlink(wall)
    collection.objects.link(wall)
    wall.location, wall.scale = (0, -3, 2), (1, 0.1, 2)
    hall.view_layers[0].layer_collection.children["Front"].exclude = True
    hall.view_layers.new("Front")
    set_up(hall)
    middle = (HEIGHT_PX // 2, WIDTH_PX // 2)
    seen = {}
    for name in ("", "ViewLayer", "Front", "Gone"):
        hall.tyndall.over_engine.view_layer = name
        seen[name] = node_output(hall, "Transmittance")[middle][2]
    assert seen[""] == seen["Front"] == seen["Gone"] > seen["ViewLayer"]
    assert "Gone" in over_engine.problems(hall)[0]
    shown = shafts_scene_of(hall)
    assert [layer.name for layer in shown.view_layers] == ["Light Shafts"]


def test_a_transparent_film_is_as_opaque_as_our_own(hall: bpy.types.Scene) -> None:
    """Fog before the sky has an alpha; surfaces have 1."""
    hall.render.film_transparent = True
    set_up(hall)
    composite = rendered(hall)
    own = own_render(hall)
    assert 0.5 < own[..., 3].min() < 0.7
    assert own[..., 3].max() == 1.0
    assert np.abs(composite - own).max() < 1e-6


def test_fog_of_the_world_is_left_too(hall: bpy.types.Scene) -> None:
    """Cycles' camera no longer sees it, its surfaces are as dim as in it, and ours draws it."""
    for name in ("Fog", "Sun"):
        bpy.data.objects.remove(bpy.data.objects[name])
    light("POINT", (0, -2, 3), energy=600.0, shadow_soft_size=0.0)
    tree = hall.world.node_tree
    medium = node(tree.nodes.new, "ShaderNodeVolumeScatter", Density=0.05)
    tree.links.new(medium.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    set_up(hall)
    composite = rendered(hall)
    own = own_render(hall)
    assert own[..., :3].max() > 0.1
    assert np.allclose(composite, own, rtol=1e-4, atol=1e-6)


def test_without_media_the_picture_is_the_engines(hall: bpy.types.Scene) -> None:
    bpy.data.objects.remove(bpy.data.objects["Fog"])
    before = rendered(hall)
    bpy.ops.tyndall.over_engine_set_up()
    assert bpy.ops.tyndall.leave_fog() == {"CANCELLED"}
    assert np.array_equal(rendered(hall), before)
