# SPDX-License-Identifier: GPL-3.0-or-later
"""A sun object that stands for the dominant light of the world's image: where, how wide and how bright it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Euler, Vector

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import empty_scene, material, node, plane
from support.small_scenes import read as sent
from tyndall.scene_description import LightKind

pytestmark = pytest.mark.dealt

HALF_ANGLE_RAD = 0.08
TOWARDS = Vector((0.5, -0.4, 0.75)).normalized()
SKY = (0.2, 0.3, 0.5)
DISC = (60.0, 50.0, 40.0)


def sky(towards: Vector = TOWARDS, *, is_float: bool = True, disc: tuple[float, ...] = DISC) -> bpy.types.Image:
    """256 x 128: an even sky with an even disc, whose rim is soft by its share of the texels."""
    height, fine = 128, 4
    image = bpy.data.images.new("Sky", 2 * height, height, float_buffer=is_float)
    longitude = (0.5 - (np.arange(2 * height * fine) + 0.5) / (2 * height * fine)) * 2 * np.pi
    latitude = ((np.arange(height * fine) + 0.5) / (height * fine) - 0.5) * np.pi
    lon, lat = np.meshgrid(longitude, latitude)
    cosine = np.cos(lat) * np.cos(lon) * towards.x + np.cos(lat) * np.sin(lon) * towards.y + np.sin(lat) * towards.z
    share = (cosine > math.cos(HALF_ANGLE_RAD)).reshape(height, fine, 2 * height, fine).mean(axis=(1, 3))[..., None]
    pixels = np.ones((height, 2 * height, 4), np.float32)
    pixels[..., :3] = np.array(SKY) + share * (np.array(disc) - SKY)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def under(
    make_image: Callable[[], bpy.types.Image] = sky, strength: float = 1.0, rotation: tuple[float, ...] = (0, 0, 0)
) -> bpy.types.Scene:
    """A white plane below the image, which Mapping turns."""
    scene = empty_scene(size_px=16)
    image = make_image()
    tree = scene.world.node_tree
    texture, background = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes["Background"]
    texture.image = image
    background.inputs["Strength"].default_value = strength
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = rotation
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    white = material("White", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)).outputs[0])
    plane(material=white)
    return scene


def made_sun() -> bpy.types.Object:
    assert bpy.ops.tyndall.sun_from_world() == {"FINISHED"}
    sun = bpy.context.scene.world.tyndall.sun
    assert sun.type == "LIGHT"
    return sun


@pytest.mark.parametrize("rotation", [(0, 0, 0), (0, 0, 1.0), (0.4, -0.7, 1.0)])
def test_the_object_stands_where_the_image_has_its_sun(rotation: tuple[float, float, float]) -> None:
    """However the image is turned; as wide as the disc, and as bright: pi sin^2 of what it is over the sky."""
    under(strength=2.0, rotation=rotation)
    sun = made_sun()
    # Mapping's Point turns the directions by which the image is read.
    expected = Euler(rotation).to_matrix().inverted() @ TOWARDS
    assert sun.matrix_world.to_3x3().col[2].angle(expected) < 0.003
    assert sun.data.angle == pytest.approx(2 * HALF_ANGLE_RAD, rel=0.05)
    [light] = sent().lights
    excess = np.array(DISC) - SKY
    assert light.kind == LightKind.SUN
    assert light.strength == pytest.approx(2 * np.pi * math.sin(HALF_ANGLE_RAD) ** 2 * excess, rel=0.01)
    assert light.half_angle_rad == pytest.approx(HALF_ANGLE_RAD, rel=0.05)


def test_the_image_loses_what_the_sun_takes_and_the_camera_sees_it_all() -> None:
    scene = under()
    before = sent().world
    made_sun()
    world = sent().world
    assert world.seen_image.key == before.image.key
    assert world.image.pixels[..., :3] == pytest.approx(np.broadcast_to(SKY, (128, 256, 3)), abs=1e-5)
    camera = scene.camera
    camera.data.type = "PERSP"
    camera.rotation_euler = (
        TOWARDS.to_track_quat("Z", "Y").to_matrix() @ Euler((0, math.pi, 0)).to_matrix()
    ).to_euler()
    seen = tyndall_pixels(scene)
    assert seen.max() == pytest.approx(max(DISC), rel=0.01)
    scene.world.tyndall.takes_sun = False
    assert sent().world.seen_image is None
    assert np.array_equal(tyndall_pixels(scene), seen)


@pytest.mark.parametrize("normal", [TOWARDS, Vector((0, 0, 1))])
def test_a_plane_receives_as_much_as_from_the_image_and_as_in_cycles(normal: Vector) -> None:
    """Cycles reads the image alone, for the sun is hidden from it."""
    scene = under()
    scene.camera.matrix_world = (
        normal.to_track_quat("Z", "Y").to_matrix().to_4x4() @ scene.camera.matrix_world.to_3x3().to_4x4()
    )
    scene.camera.location = 3 * normal
    bpy.data.objects["Plane"].rotation_euler = normal.to_track_quat("Z", "Y").to_euler()
    image_alone = tyndall_pixels(scene, 64).mean(axis=(0, 1))
    sun = made_sun()
    with_sun = tyndall_pixels(scene, 64).mean(axis=(0, 1))
    assert with_sun == pytest.approx(image_alone, rel=0.01)
    sun.hide_render = True
    assert with_sun == pytest.approx(cycles_pixels(scene, 256, seed=1).mean(axis=(0, 1)), rel=0.02)


def test_updating_moves_the_same_object_and_keeps_its_edits() -> None:
    scene = under()
    sun = made_sun()
    bpy.ops.tyndall.occluder_edit_add(kind="CLOSE")
    scene.world.tyndall.takes_sun = False
    mapping = next(one for one in scene.world.node_tree.nodes if one.type == "MAPPING")
    mapping.inputs["Rotation"].default_value = (0, 0, 1.2)
    scene.world.tyndall.takes_sun = True
    bpy.context.view_layer.update()
    sent_before = sent()
    assert any("degrees beside its image's" in line for line in sent_before.reports)
    assert made_sun() == sun
    assert len(sun.data.tyndall.occluder_edits) == 1
    assert len([one for one in scene.objects if one.type == "LIGHT"]) == 1
    assert sun.matrix_world.to_3x3().col[2].angle(Euler((0, 0, -1.2)).to_matrix() @ TOWARDS) < 0.003
    assert not any("beside" in line for line in sent().reports)


def test_a_sun_that_was_deleted_or_is_hidden_leaves_the_image_its_light() -> None:
    scene = under()
    sun = made_sun()
    sun.hide_render = sun.hide_viewport = True
    shown = sent()
    assert shown.world.seen_image is None
    assert any("keeps its sun" in line and "not drawn" in line for line in shown.reports)
    bpy.data.objects.remove(sun)
    shown = sent()
    assert shown.world.image.pixels.max() > 30
    assert any("keeps its sun: it has no sun object" in line for line in shown.reports)
    assert made_sun() is not None
    assert scene.world.tyndall.takes_sun


def flat(value: float) -> bpy.types.Image:
    image = bpy.data.images.new("Flat", 64, 32, float_buffer=True)
    image.pixels.foreach_set(np.full(64 * 32 * 4, value, np.float32))
    return image


@pytest.mark.parametrize("kind", ["uniform", "missing", "none", "black world", "no world"])
def test_a_world_without_a_dominant_light_is_refused_with_one_message(kind: str) -> None:
    """And nothing is changed."""
    scene = under()
    texture = next(one for one in scene.world.node_tree.nodes if one.type == "TEX_ENVIRONMENT")
    if kind == "uniform":
        texture.image = flat(0.7)
    elif kind == "missing":
        texture.image = bpy.data.images.new("Gone", 8, 8)
        texture.image.source, texture.image.filepath = "FILE", "//not there.hdr"
    elif kind == "none":
        scene.world.node_tree.nodes.remove(texture)
    elif kind == "black world":
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    else:
        scene.world = None
    message = {
        "uniform": "Flat.*no dominant light",
        "missing": "Gone.*missing",
        "none": "no environment image",
        "black world": "World",
        "no world": "no world",
    }[kind]
    with pytest.raises(RuntimeError, match=f"(?s){message}"):
        bpy.ops.tyndall.sun_from_world()
    assert not [one for one in scene.objects if one.type == "LIGHT"]


def test_an_image_that_has_no_sun_any_more_is_left_as_it_is() -> None:
    scene = under()
    made_sun()
    next(one for one in scene.world.node_tree.nodes if one.type == "TEX_ENVIRONMENT").image = flat(0.7)
    shown = sent()
    assert shown.world.seen_image is None
    assert any('"Flat" has no sun to take out' in line for line in shown.reports)


def test_bytes_and_packed_images_have_suns_too(tmp_path: Path) -> None:
    """Clipped at 1, as photographs are; the packed pixels count after the file is gone."""
    under(partial(sky, is_float=False, disc=(1.0, 1.0, 1.0)))
    image = bpy.data.images["Sky"]
    image.filepath_raw, image.file_format = str(tmp_path / "sky.png"), "PNG"
    image.save()
    image.pack()
    (tmp_path / "sky.png").unlink()
    sun = made_sun()
    assert sun.matrix_world.to_3x3().col[2].angle(TOWARDS) < 0.01
    assert sun.data.angle == pytest.approx(2 * HALF_ANGLE_RAD, rel=0.1)


def test_it_is_kept_by_save_and_load(tmp_path: Path) -> None:
    scene = under()
    bpy.data.images["Sky"].pack()
    name = made_sun().name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "sun.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "sun.blend"))
    scene = bpy.context.scene
    assert scene.world.tyndall.takes_sun
    assert scene.world.tyndall.sun == scene.objects[name]
    assert sent().world.seen_image is not None


def test_it_throws_shafts_into_fog() -> None:
    """What a world of the same light spreads over all its directions, the sun sends along one."""
    scene = under()
    bpy.ops.tyndall.add_fog_box()
    made_sun()
    scene.view_layers[0].tyndall.use_pass_shafts = True
    tyndall_pixels(scene)
    statistics = last_render.statistics_of("Scene")
    assert "light shafts: rays" in statistics["counts"]
    assert not any(one["what"].startswith("light shafts of Sun") for one in statistics["skipped"])
