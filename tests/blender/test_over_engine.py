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
from numpy.typing import NDArray

from addon import last_render, over_engine, panels
from addon.engine import failures, sessions
from addon.over_engine import compositor, fog
from addon.over_engine.shafts_scene import shafts_scene_of
from addon.panels import over_engine as over_engine_panel
from support.exr import read_planes
from support.recording_layout import HeadlessContext, drawn
from support.small_scenes import add, cube, empty_scene, light, material, node, plane

Picture = NDArray[np.float32]
WIDTH_PX, HEIGHT_PX = 32, 18


@pytest.fixture
def hall(tmp_path: Path) -> bpy.types.Scene:
    """Cubes on a floor in coloured fog under a sun, against a black sky; Cycles, a ray through each pixel's centre."""
    scene = empty_scene()
    scene.render.resolution_x, scene.render.resolution_y = WIDTH_PX, HEIGHT_PX
    scene.camera.data.type = "PERSP"
    scene.camera.location, scene.camera.rotation_euler = (0, -9, 3), (math.radians(80), 0, 0)
    for index, place in enumerate(((-2, 0, 1), (2.5, 3, 1))):
        surface = (0.7, 0.5 - 0.2 * index, 0.3, 1)
        grey = material(
            "Paint", lambda new, _, colour=surface: node(new, "ShaderNodeBsdfDiffuse", Color=colour).outputs[0]
        )
        cube(f"Cube {index}", grey).location = place
    plane(material=bpy.data.materials["Paint"])
    light("SUN", (0, 0, 5), energy=10.0, angle=0.0).rotation_euler = (0.7, 0.4, 0)
    box = cube(
        "Fog",
        material(
            "Fog",
            volume=lambda new, _: node(
                new, "ShaderNodeVolumeScatter", Color=(0.9, 0.6, 0.3, 1), Density=0.08, Anisotropy=0.2
            ).outputs[0],
        ),
    )
    box.scale, box.location = (12, 12, 4), (0, 0, 3)
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 1, 0.0
    scene.tyndall.shafts.method = "EXACT"
    use_cycles(scene)
    scene.render.filepath = str(tmp_path / "frame.exr")
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode = "OPEN_EXR", "RGBA"
    settings.color_depth, settings.exr_codec = "32", "NONE"
    bpy.context.view_layer.update()
    return scene


def use_cycles(scene: bpy.types.Scene, samples: int = 1) -> None:
    """Direct light alone, through pixel centres where there is one sample, else over the whole pixel."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples = "CPU", samples
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.volume_bounces = 0
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    if samples > 1:
        cycles.pixel_filter_type = "BOX"


def rendered(scene: bpy.types.Scene) -> Picture:
    """F12, and what it writes: (height, width, 4)."""
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return read_planes(Path(scene.render.filepath))[""].copy()


def set_up(scene: bpy.types.Scene) -> None:
    """As an artist does it: two buttons."""
    assert bpy.ops.tyndall.over_engine_set_up() == {"FINISHED"}
    assert bpy.ops.tyndall.leave_fog() == {"FINISHED"}
    assert over_engine.problems(scene) == []


def own_render(scene: bpy.types.Scene) -> Picture:
    """All of it by us: surfaces, fog and shafts."""
    scene.tyndall.over_engine.is_enabled, scene.render.engine = False, "TYNDALL"
    return rendered(scene)


def node_output(scene: bpy.types.Scene, name: str) -> Picture:
    """What an output of our node has, as a render."""
    tree = compositor.tree_of(scene)
    (output,) = compositor.outputs_of(tree)
    before = output.links[0].from_socket
    tree.links.new(compositor.compose_node(scene).outputs[name], output)
    picture = rendered(scene)
    tree.links.new(before, output)
    return picture


def picture_without_fog(scene: bpy.types.Scene) -> Picture:
    """What the scene's engine gives to the compositor: the switch is off, and the fog left out all the same."""
    scene.tyndall.over_engine.is_enabled = False
    for _, left in fog.left_nodes():
        left.mute = False
    picture = rendered(scene)
    scene.tyndall.over_engine.is_enabled = True
    return picture


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


def test_off_the_picture_is_the_engines_own(hall: bpy.types.Scene) -> None:
    """Bit for bit, fog included; on again it is what it was."""
    before = rendered(hall)
    set_up(hall)
    composite = rendered(hall)
    hall.tyndall.over_engine.is_enabled = False
    assert np.array_equal(rendered(hall), before)
    hall.tyndall.over_engine.is_enabled = True
    assert np.array_equal(rendered(hall), composite)
    assert np.abs(composite - before).max() > 0.01


def test_removing_leaves_no_trace(hall: bpy.types.Scene) -> None:
    before = rendered(hall)
    things = everything()
    set_up(hall)
    assert everything() != things
    bpy.ops.tyndall.over_engine_remove()
    compose, fog_group = "Light Shafts over Picture", "Left to Light Shafts"
    assert everything() - things == {compose, fog_group}, "the groups are there for the next time"
    assert things <= everything()
    assert compositor.tree_of(hall) is None
    assert np.array_equal(rendered(hall), before)


def everything() -> set[str]:
    """Scenes and node groups of the file, and what is linked in materials."""
    links = [
        f"{owner.name}: {link.from_node.name} to {link.to_node.name}"
        for owner in bpy.data.materials
        if owner.node_tree
        for link in owner.node_tree.links
    ]
    return {*bpy.data.scenes.keys(), *bpy.data.node_groups.keys(), *links}


def artists_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    """Picture, Glare, output, and a blur that leads nowhere."""
    if compositor.HAS_GROUPS:
        tree = bpy.data.node_groups.new("Mine", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        scene.compositing_node_group = tree
        output = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("CompositorNodeComposite")
    picture, flip, blur = (tree.nodes.new(f"CompositorNode{kind}") for kind in ("RLayers", "Flip", "Blur"))
    tree.links.new(picture.outputs["Image"], flip.inputs["Image"])
    tree.links.new(picture.outputs["Image"], blur.inputs["Image"])
    tree.links.new(flip.outputs[0], output.inputs[0])
    return tree


def links_of(tree: bpy.types.NodeTree) -> set[tuple[str, str, str, str]]:
    return {
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    }


def test_the_artists_nodes_stay_as_they_are(hall: bpy.types.Scene) -> None:
    """Ours go before the output; setting up twice does nothing twice; removing restores the links."""
    tree = artists_tree(hall)
    nodes, links = set(tree.nodes.keys()), links_of(tree)
    places = {node.name: tuple(node.location) for node in tree.nodes}
    set_up(hall)
    assert len(tree.nodes) == len(nodes) + 2
    assert links - links_of(tree) == {link for link in links if "Flip" in link[0]}
    assert all(tuple(tree.nodes[name].location) == place for name, place in places.items())
    composite, once = rendered(hall), links_of(tree)
    bpy.ops.tyndall.over_engine_set_up()
    hall.tyndall.over_engine.is_enabled = True
    assert (len(tree.nodes), links_of(tree), len(bpy.data.scenes)) == (len(nodes) + 2, once, 2)
    assert np.array_equal(rendered(hall), composite)
    bpy.ops.tyndall.over_engine_remove()
    assert (set(tree.nodes.keys()), links_of(tree), len(bpy.data.scenes)) == (nodes, links, 1)


def test_nodes_that_were_added_since_stay_linked(hall: bpy.types.Scene) -> None:
    """Whether the nodes before them were made for us, or by the artist."""
    set_up(hall)
    tree, node = compositor.tree_of(hall), compositor.compose_node(hall)
    flip = tree.nodes.new("CompositorNodeFlip")
    output = node.outputs["Image"].links[0].to_socket
    tree.links.new(node.outputs["Image"], flip.inputs["Image"])
    tree.links.new(flip.outputs[0], output)
    assert over_engine.problems(hall) == []
    bpy.ops.tyndall.over_engine_set_up()
    assert len(tree.nodes) == 5
    before = picture_without_fog(hall)
    bpy.ops.tyndall.over_engine_remove()
    assert [link.from_node.type for link in flip.inputs["Image"].links] == ["R_LAYERS"]
    assert [link.from_node.name for link in output.links] == [flip.name]
    assert before.any()


def test_it_survives_undo_save_and_reload(hall: bpy.types.Scene, tmp_path: Path) -> None:
    """The switch, the second scene, the nodes and the fog, and the picture."""
    bpy.ops.ed.undo_push(message="before")
    set_up(hall)
    composite = rendered(hall)
    bpy.ops.ed.undo_push(message="set up")
    bpy.ops.ed.undo()
    hall = bpy.context.scene
    assert (over_engine.is_set_up(hall), len(bpy.data.scenes)) == (False, 1)
    assert not hall.tyndall.over_engine.is_enabled
    bpy.ops.ed.redo()
    hall = bpy.context.scene
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)
    blend = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.read_factory_settings()
    bpy.ops.wm.open_mainfile(filepath=blend)
    hall = bpy.context.scene
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)


def test_appended_it_brings_all_of_it_along(hall: bpy.types.Scene, tmp_path: Path) -> None:
    set_up(hall)
    composite = rendered(hall)
    path, blend = hall.render.filepath, str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.name = "Other"
    with bpy.data.libraries.load(blend, link=False) as (_, wanted):
        wanted.scenes = ["Scene"]
    appended = bpy.data.scenes["Scene"]
    if bpy.app.version < (4, 0, 0):  # appends no scene that a node reads
        assert "deleted" in over_engine.problems(appended)[0]
        over_engine.set_up(appended)
    assert over_engine.problems(appended) == []
    assert shafts_scene_of(appended) is not None
    appended.render.filepath = path
    assert np.array_equal(rendered(appended), composite)


def test_new_objects_and_collections_are_seen(hall: bpy.types.Scene) -> None:
    """Whether they come into the scene itself or into a collection of it, and they go again; at once in a script."""
    set_up(hall)
    before, middle = rendered(hall), (HEIGHT_PX // 2, WIDTH_PX // 2)
    open_view = node_output(hall, "Transmittance")[middle][0]
    wall = cube("Wall", bpy.data.materials["Paint"])
    wall.location, wall.scale = (0, -3, 2), (1, 0.1, 2)
    blocked = node_output(hall, "Transmittance")[middle][0]
    assert blocked > open_view + 0.1
    collection = bpy.data.collections.new("Props")
    hall.collection.children.link(collection)
    hall.collection.objects.unlink(wall)
    collection.objects.link(wall)
    assert node_output(hall, "Transmittance")[middle][0] == blocked
    bpy.data.objects.remove(wall)
    bpy.data.collections.remove(collection)
    assert np.array_equal(rendered(hall), before)


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


def test_fog_of_a_linked_material_is_named(hall: bpy.types.Scene, tmp_path: Path) -> None:
    """It cannot be changed, and would be drawn twice."""
    blend = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend, copy=True)
    bpy.data.materials.remove(bpy.data.materials["Fog"])
    with bpy.data.libraries.load(blend, link=True) as (_, wanted):
        wanted.materials = ["Fog"]
    bpy.data.objects["Fog"].data.materials[0] = wanted.materials[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert bpy.ops.tyndall.leave_fog() == {"CANCELLED"}
    assert not any(node.type == "GROUP" for node in wanted.materials[0].node_tree.nodes)


def test_without_media_the_picture_is_the_engines(hall: bpy.types.Scene) -> None:
    bpy.data.objects.remove(bpy.data.objects["Fog"])
    before = rendered(hall)
    bpy.ops.tyndall.over_engine_set_up()
    assert bpy.ops.tyndall.leave_fog() == {"CANCELLED"}
    assert np.array_equal(rendered(hall), before)


def test_a_deleted_scene_leaves_the_picture_alone_and_is_mended(hall: bpy.types.Scene) -> None:
    set_up(hall)
    composite = rendered(hall)
    picture = picture_without_fog(hall)
    bpy.data.scenes.remove(shafts_scene_of(hall))
    assert "deleted" in over_engine.problems(hall)[0]
    assert np.array_equal(rendered(hall), picture)
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)


def test_a_missing_group_is_named_and_mended(hall: bpy.types.Scene) -> None:
    set_up(hall)
    composite = rendered(hall)
    bpy.data.node_groups.remove(bpy.data.node_groups["Light Shafts over Picture"])
    assert "missing" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []
    assert np.array_equal(rendered(hall), composite)


def test_what_the_artist_did_to_the_nodes_is_named(hall: bpy.types.Scene) -> None:
    """Muted, unlinked, removed, or compositing off: each has its words, and the button mends what it may."""
    set_up(hall)
    tree, node = compositor.tree_of(hall), compositor.compose_node(hall)
    node.mute = True
    assert "muted" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    hall.render.use_compositing = False
    assert "Post Processing" in over_engine.problems(hall)[0]
    hall.render.use_compositing = True
    (output,) = compositor.outputs_of(tree)
    tree.links.new(node.inputs["Image"].links[0].from_socket, output)
    assert "do not reach" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []
    for layer in [layer for layer in tree.nodes if layer.type == "R_LAYERS" and layer.scene != hall]:
        tree.nodes.remove(layer)
    assert "No node reads" in over_engine.problems(hall)[0]
    bpy.ops.tyndall.over_engine_set_up()
    assert over_engine.problems(hall) == []


def test_a_copied_scene_gets_its_own(hall: bpy.types.Scene) -> None:
    """Until then its nodes read the light shafts of the scene that it was copied from, and the panel says so."""
    set_up(hall)
    copied = hall.copy()
    if compositor.HAS_GROUPS:
        assert "make it single-user" in over_engine.problems(copied)[0]
        copied.compositing_node_group = copied.compositing_node_group.copy()
    assert over_engine.problems(copied) != []
    with bpy.context.temp_override(scene=copied):
        bpy.ops.tyndall.over_engine_set_up()
    assert (over_engine.problems(copied), over_engine.problems(hall)) == ([], [])
    assert shafts_scene_of(copied) != shafts_scene_of(hall)


@pytest.mark.parametrize("why", ["linked", "switched off", "shared", "Tyndall", "shafts"])
def test_where_it_cannot_be_set_up_the_button_says_why(hall: bpy.types.Scene, tmp_path: Path, why: str) -> None:
    words = {
        "linked": "linked",
        "switched off": "Use Nodes",
        "shared": "single-user",
        "Tyndall": "itself",
        "shafts": "holds",
    }
    if why == ("switched off" if compositor.HAS_GROUPS else "shared"):
        pytest.skip("of the other versions")
    scene = hall
    if why == "linked":
        artists_tree(hall)
        blend = str(tmp_path / "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=blend, copy=True)
        with bpy.data.libraries.load(blend, link=True) as (_, wanted):
            wanted.scenes = ["Scene"]
        scene = wanted.scenes[0]
    elif why == "switched off":
        artists_tree(hall)
        hall.use_nodes = False
    elif why == "shared":
        artists_tree(hall)
        bpy.data.scenes.new("Other").compositing_node_group = hall.compositing_node_group
    elif why == "Tyndall":
        hall.render.engine = "TYNDALL"
    else:
        set_up(hall)
        scene = shafts_scene_of(hall)
    assert words[why] in over_engine.why_not(scene)
    with bpy.context.temp_override(scene=scene):
        assert not bpy.ops.tyndall.over_engine_set_up.poll()
    if why not in {"shafts", "linked"}:
        scene.tyndall.over_engine.is_enabled = True
        assert not over_engine.is_set_up(scene)


def test_a_scene_that_turns_to_us_has_its_shafts_once(hall: bpy.types.Scene) -> None:
    own = own_render(hall)
    use_cycles(hall)
    set_up(hall)
    hall.render.engine = "TYNDALL"
    assert np.array_equal(rendered(hall), own)
    assert "itself" in over_engine.problems(hall)[0]


def test_without_a_camera_blender_says_so(hall: bpy.types.Scene) -> None:
    set_up(hall)
    hall.camera = None
    assert "no camera" in over_engine.problems(hall)[0]
    with pytest.raises(RuntimeError, match=r"(?i)no camera"):
        bpy.ops.render.render()


def test_an_error_of_ours_leaves_the_picture_alone_and_is_told(hall: bpy.types.Scene) -> None:
    """Blender hands errors of the second scene to nobody: the panel says what it was, and the picture has no shafts."""
    hall.camera.scale.z = 0.0
    set_up(hall)
    composite = rendered(hall)
    assert "its scale is 0" in failures.last_error()
    assert "its scale is 0" in last_render.statistics_of(hall.name)["reports"][0]
    assert np.array_equal(composite, picture_without_fog(hall))


@pytest.mark.parametrize("panel", over_engine_panel.CLASSES)
def test_the_panel_says_what_is(hall: bpy.types.Scene, panel: type[bpy.types.Panel]) -> None:
    """Under any engine: how to set it up, then settings, what is wrong, and what the last render did."""
    assert "Set Up" in drawn(panel, engine="CYCLES")
    set_up(hall)
    rendered(hall)
    shown = drawn(panel, engine="CYCLES")
    assert "Set Up Again" not in shown
    assert {"default_value", "pixel_samples", "method", "Leave Fog to the Shafts", "Remove"} <= set(shown)
    assert any("last render" in line for line in shown)
    assert drawn(panels.transfer_functions.TYNDALL_PT_sidebar_transfer_functions, engine="CYCLES")
    bpy.data.scenes.remove(shafts_scene_of(hall))
    assert "Set Up Again" in drawn(panel, engine="CYCLES")
    bpy.ops.tyndall.over_engine_remove()
    hall.render.engine = "TYNDALL"
    assert not panel.poll(HeadlessContext(engine="TYNDALL"))
