# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures before lights colour surfaces and air as in Cycles: whatever the nodes say of where they are read."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from support.agreement_scenes import LIGHT_AT, Arrangement, build
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.lamp_scenes import (
    IS_4,
    PLACES,
    Link,
    New,
    Socket,
    assert_air_like_cycles,
    assert_like_cycles,
    mapped,
    picture,
    read_through,
    smooth_picture,
    stage,
)
from support.small_scenes import material, node, plane, read
from tyndall.scene_description import LightProjection, LightTexture

pytestmark = pytest.mark.dealt


@pytest.mark.parametrize("kind", ["SPOT", "POINT"])
@pytest.mark.parametrize("place", PLACES)
def test_an_image_is_read_where_cycles_reads_it(kind: str, place: str) -> None:
    lamp = stage(kind)
    read_through(lamp, PLACES[place])
    if not IS_4 and place in {"nothing", "UV", "mapped UV"}:  # 3.x has one texel for all
        scene = bpy.context.scene
        np.testing.assert_allclose(tyndall_pixels(scene), cycles_pixels(scene, 1, seed=1), rtol=2e-3)
        return
    assert_like_cycles()


def coloured(make: Callable[[New, Link, Socket], Socket]) -> Callable[[bpy.types.Node], None]:
    """Put nodes between an image and the Emission node that it feeds."""

    def apply(image: bpy.types.Node) -> None:
        tree = image.id_data
        emission = next(one for one in tree.nodes if one.type == "EMISSION")
        result = make(tree.nodes.new, tree.links.new, image.outputs["Color"])
        tree.links.new(result, emission.inputs["Color"])

    return apply


def _mixed(new: New, link: Link, colour: Socket) -> Socket:
    mix = node(new, "ShaderNodeMixRGB", Fac=0.7, Color2=(0.3, 0.9, 0.5, 1))
    link(colour, mix.inputs["Color1"])
    return mix.outputs[0]


def _masked(new: New, link: Link, colour: Socket) -> Socket:
    """Between two colours, by the image's grey."""
    mix = node(new, "ShaderNodeMixRGB", Color1=(0.1, 0.0, 0.4, 1), Color2=(0.9, 0.8, 0.2, 1))
    link(colour, mix.inputs["Fac"])
    return mix.outputs[0]


def _inverted(new: New, link: Link, colour: Socket) -> Socket:
    invert, multiply = new("ShaderNodeInvert"), node(new, "ShaderNodeMixRGB", Fac=1.0, Color2=(1.0, 0.4, 0.6, 1))
    multiply.blend_type = "MULTIPLY"
    link(colour, invert.inputs["Color"])
    link(invert.outputs[0], multiply.inputs["Color1"])
    return multiply.outputs[0]


@pytest.mark.parametrize("make", [_mixed, _masked, _inverted])
def test_constants_mix_with_an_image(make: Callable[[New, Link, Socket], Socket]) -> None:
    coloured(make)(read_through(stage("SPOT"), PLACES["normal"]))
    assert_like_cycles()
    assert read().reports == ()


def test_an_image_can_be_the_strength() -> None:
    image = read_through(stage("SPOT"), PLACES["normal"])
    tree = image.id_data
    emission = next(one for one in tree.nodes if one.type == "EMISSION")
    tree.links.remove(emission.inputs["Color"].links[0])
    emission.inputs["Color"].default_value = (0.2, 0.5, 0.9, 1.0)
    tree.links.new(image.outputs["Color"], emission.inputs["Strength"])
    assert_like_cycles()


@pytest.mark.parametrize("kind", ["SPOT", "POINT"])
def test_an_environment_is_thrown_around(kind: str) -> None:
    """What suits it best, and what it is made for: a direction of the world."""
    turned = mapped(PLACES["incoming"], Rotation=(0.4, 0.3, 0.8))
    read_through(stage(kind), turned, "ShaderNodeTexEnvironment")
    assert_like_cycles()


@pytest.mark.parametrize("extension", ["REPEAT", "CLIP", "EXTEND"])
def test_beside_the_image_its_extension_holds(extension: str) -> None:
    read_through(stage("SPOT"), mapped(PLACES["thrown"], Scale=(2.0, 3.0, 1.0)), extension=extension)
    assert_like_cycles()


@pytest.mark.parametrize("kind", ["SPOT", "POINT"])
def test_an_image_has_a_mapping_of_its_own(kind: str) -> None:
    placed = read_through(stage(kind), PLACES["normal"]).texture_mapping
    placed.scale, placed.translation, placed.rotation = (1.5, 0.8, 1.2), (0.3, -0.2, 0.1), (0.4, 0.3, 0.8)
    assert_like_cycles(4e-3)


def test_an_image_wraps_around_a_point_light() -> None:
    read_through(stage("POINT"), PLACES["normal"], projection="SPHERE")
    assert_like_cycles()


def test_a_missing_image_is_magenta_as_in_cycles() -> None:
    lamp = stage("SPOT")
    read_through(lamp, PLACES["normal"]).image = None
    description = read()
    assert description.reports == ('Light "Spot": an image node without an image is magenta',)
    red, green, blue = description.lights[0].strength
    assert red == blue > green == 0.0


# --- in the air ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("light_name", "place", "is_soft"),
    [
        ("spot", "thrown", False),
        ("spot", "parametric", False),
        ("point", "incoming", False),
        pytest.param("spot 0.1 m", "thrown", False, marks=pytest.mark.long),
        pytest.param("spot 0.1 m", "thrown", True, marks=pytest.mark.long),
        pytest.param("point 0.2 m", "normal", True, marks=pytest.mark.costly),
    ],
)
def test_a_lamps_picture_colours_the_fog(light_name: str, place: str, is_soft: bool) -> None:  # noqa: FBT001
    """Soft: a sphere that emits, as 4.0 has it, whose normals are read."""
    if is_soft and bpy.app.version < (4, 2, 0):
        pytest.skip("before 4.2 there is no choice")

    def make() -> None:
        build(Arrangement(light=light_name)).tyndall.shafts.resolution = 2048
        lamp = next(thing for thing in bpy.context.scene.objects if thing.type == "LIGHT")
        vector = mapped(PLACES[place], Scale=(1.2, 0.9, 1.0), Location=(0.4, 0.6, 0.0))
        if light_name.startswith("point"):
            image = read_through(lamp, PLACES[place], "ShaderNodeTexEnvironment")
        else:
            image = read_through(lamp, vector)
        image.image = smooth_picture()
        if is_soft:
            lamp.data.use_soft_falloff = False

    assert_air_like_cycles(f"gobo {light_name} {place}", make, make, 128 if "m" in light_name else 1)


def pane_before_the_sun(width_m: float) -> bpy.types.Object:
    """A sheet of coloured film across the sun, out of the camera's sight: tiles of a picture, ``width_m`` wide."""
    data = bpy.context.scene.objects["Sun"]
    turn = data.matrix_world.to_3x3().normalized().to_4x4()

    def film(new: New, link: Link) -> Socket:
        image, clear = new("ShaderNodeTexImage"), new("ShaderNodeBsdfTransparent")
        image.image = smooth_picture()
        link(image.outputs["Color"], clear.inputs["Color"])
        return clear.outputs[0]

    half = 5 * width_m
    pane = plane(material=material("Film", film), half_side=half)
    for loop in pane.data.loops:
        corner = pane.data.vertices[loop.vertex_index].co
        pane.data.uv_layers[0].data[loop.index].uv = (corner.x / width_m + 0.5, corner.y / width_m + 0.5)
    pane.matrix_world = Matrix.Translation(LIGHT_AT) @ turn @ Matrix.Translation((0, 0, 8))
    pane.visible_camera = False
    return pane


def test_a_suns_gobo_is_a_film_before_it() -> None:
    def make_film() -> None:
        build(Arrangement())
        pane_before_the_sun(2.0)

    def make_gobo() -> None:
        build(Arrangement())
        ours = bpy.data.lights["Sun"].tyndall
        ours.gobo_image, ours.gobo_size_m, ours.gobo_extension = smooth_picture(), 2.0, "REPEAT"

    assert_air_like_cycles("sun gobo", make_film, make_gobo)


@pytest.mark.costly
def test_stained_glass_colours_the_fog() -> None:
    """An image in a Transparent node. EXACT is 0.3 % dark here, for the hundred texels that a ray's shadow crosses."""

    def make() -> None:
        build(Arrangement()).tyndall.shafts.resolution = 2048
        pane_before_the_sun(2.0)

    assert_air_like_cycles("stained glass", make, make, methods=("EPIPOLAR",))


def test_a_glass_pane_lets_its_colour_pass() -> None:
    stage("SUN")
    colour = (0.9, 0.3, 0.1, 1.0)
    pane = plane(1.0, material("Glass", lambda new, _: node(new, "ShaderNodeBsdfGlass", Color=colour).outputs[0]))
    pane.visible_camera = False
    ours = tyndall_pixels(bpy.context.scene)
    assert any("Glass" in line and "transparent in its colour" in line for line in read().reports)
    bpy.data.objects.remove(pane)
    plain = tyndall_pixels(bpy.context.scene)
    np.testing.assert_allclose(ours.mean(axis=(0, 1)), plain.mean(axis=(0, 1)) * colour[:3], rtol=1e-4)


# --- our own property ------------------------------------------------------------------------------------------------
def gobo_of(lamp: bpy.types.Object) -> LightTexture:
    (description,) = (one for one in read().lights if one.name == lamp.name)
    assert description.texture is not None
    return description.texture


def test_a_suns_gobo_lies_across_its_light_in_metres() -> None:
    lamp = stage("SUN")
    ours = lamp.data.tyndall
    ours.gobo_image, ours.gobo_size_m, ours.gobo_extension, ours.gobo_strength = picture(), 2.5, "MIRROR", 0.25
    ours.gobo_offset_m = 0.5, -1.0
    texture = gobo_of(lamp)
    assert texture.projection is LightProjection.PLANAR
    assert texture.width_m == 2.5
    assert texture.centre_m == (0.5, -1.0)
    assert texture.use.extension.name == "MIRROR"
    np.testing.assert_allclose(texture.offset, 0.75)
    np.testing.assert_allclose(texture.gain, 0.25 * np.eye(3))


@pytest.mark.parametrize("kind", ["SPOT", "POINT"])
def test_a_lamps_gobo_is_what_uv_coordinates_say_from_4_on(kind: str) -> None:
    lamp = stage(kind)
    lamp.data.tyndall.gobo_image = picture()
    lamp.data.tyndall.gobo_extension = "REPEAT"
    ours = tyndall_pixels(bpy.context.scene)
    assert ours.std() > 0.05 * ours.mean()
    if IS_4:
        read_through(stage(kind), PLACES["UV"])
        np.testing.assert_allclose(ours, tyndall_pixels(bpy.context.scene), rtol=1e-5)


def test_a_gobo_goes_before_an_image_of_the_nodes() -> None:
    lamp = stage("SPOT")
    read_through(lamp, PLACES["normal"])
    lamp.data.tyndall.gobo_image = picture("Other")
    assert gobo_of(lamp).use.image.name == "Other"
    assert read().reports == ('Light "Spot": its gobo takes the place of its nodes\' pattern',)


def test_a_gobo_without_pixels_is_left_out_with_a_report() -> None:
    lamp = stage("SUN")
    missing = bpy.data.images.new("Missing", 4, 4)
    missing.source, missing.filepath = "FILE", "//nowhere.png"
    lamp.data.tyndall.gobo_image = missing
    description = read()
    assert description.lights[0].texture is None
    (report,) = description.reports
    assert report.startswith('Light "Sun": its gobo, image "Missing", is left out: it is missing or has no pixels')


def test_a_gobo_is_keyed_and_outlives_its_image() -> None:
    lamp = stage("SUN")
    lamp.data.tyndall.gobo_image = picture()
    lamp.data.tyndall.gobo_size_m = 2.0
    lamp.data.keyframe_insert("tyndall.gobo_size_m", frame=1)
    lamp.data.tyndall.gobo_size_m = 4.0
    lamp.data.keyframe_insert("tyndall.gobo_size_m", frame=3)
    scene = bpy.context.scene
    scene.frame_set(2)
    assert gobo_of(lamp).width_m == pytest.approx(3.0)
    bpy.data.images.remove(lamp.data.tyndall.gobo_image)
    bpy.context.view_layer.update()
    assert lamp.data.tyndall.gobo_image is None
    assert read().lights[0].texture is None
