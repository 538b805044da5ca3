# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose nodes vary by any pattern light surfaces and air as in Cycles; others cost and are what they were."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from addon.sync.scene import SceneReader
from support.agreement_scenes import Arrangement, build
from support.cycles_reference import tyndall_pixels as shafts_of
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.lamp_scenes import (
    IS_4,
    PLACES,
    Link,
    New,
    Socket,
    assert_air_like_cycles,
    assert_like_cycles,
    assert_same_light,
    bands,
    mapped,
    mixed,
    output,
    picture,
    ramped,
    shows,
    stage,
    tree_of,
)
from support.small_scenes import node, read
from tyndall.linear_colours import linear_colours
from tyndall.scene_description import Light, LightProjection, LightTexture

pytestmark = pytest.mark.dealt

Make = Callable[[New, Link], Socket]
INCOMING, NORMAL, UV = PLACES["incoming"], PLACES["normal"], PLACES["UV"]


def pattern(kind: str, place: Make | None, name: str = "Color", **settings: object) -> Make:
    """A texture at a vector; numbers are its inputs, names its options."""

    def make(new: New, link: Link) -> Socket:
        inputs = {key: value for key, value in settings.items() if not isinstance(value, str)}
        made = node(new, kind, **inputs)
        for key, value in settings.items():
            if isinstance(value, str):
                setattr(made, key, value)
        if kind == "ShaderNodeTexImage":
            made.image = picture()
        if place is not None:
            link(place(new, link), made.inputs["Vector"])
        return next(one for one in made.outputs if one.name == name)

    return make


IMAGE = pattern("ShaderNodeTexImage", PLACES["thrown"])
PATTERNS: dict[str, Make] = {
    "noise by direction": pattern("ShaderNodeTexNoise", INCOMING, Scale=3.0),
    "noise by normal": pattern("ShaderNodeTexNoise", mapped(NORMAL, Rotation=(0.3, 0.2, 0.1)), Scale=2.0),
    "voronoi": pattern("ShaderNodeTexVoronoi", INCOMING, "Distance", Scale=4.0),
    "waves": pattern("ShaderNodeTexWave", NORMAL, Scale=0.7, Distortion=1.0),
    "magic": pattern("ShaderNodeTexMagic", output("ShaderNodeTexCoord", "Reflection"), Scale=2.0),
    "gradient": pattern("ShaderNodeTexGradient", INCOMING, gradient_type="RADIAL"),
    "bands": bands,
    "noise on UV": pattern("ShaderNodeTexNoise", UV, Scale=4.0),
    "noise of parametric": pattern("ShaderNodeTexNoise", PLACES["parametric"], Scale=4.0),
    "squared image": mixed(IMAGE, IMAGE),
    "ramp of an image": ramped(IMAGE),
    "two images": mixed(IMAGE, pattern("ShaderNodeTexImage", INCOMING), "ADD"),
    "image in a box": pattern("ShaderNodeTexImage", NORMAL, projection="BOX"),
    "image in a tube": pattern("ShaderNodeTexImage", NORMAL, projection="TUBE"),
}


def texture() -> LightTexture | None:
    (lamp,) = read().lights
    return lamp.texture


#: The others are asked of each version with all tests.
OFTEN = [
    ("noise by direction", "SPOT"),
    ("noise by normal", "POINT"),
    ("bands", "SPOT"),
    ("noise on UV", "POINT"),
    ("squared image", "SPOT"),
    ("gradient", "POINT"),
]
EACH = [(name, kind) for name in PATTERNS for kind in ("SPOT", "POINT")]


@pytest.mark.parametrize(
    ("name", "kind"), [*OFTEN, *(pytest.param(*one, marks=pytest.mark.long) for one in EACH if one not in OFTEN)]
)
def test_a_pattern_falls_where_cycles_throws_it(name: str, kind: str) -> None:
    if not IS_4 and name == "noise on UV":
        pytest.skip("Cycles 3.4 gives lamps no UV coordinates")
    shows(stage(kind), PATTERNS[name])
    assert read().reports == ()
    assert_like_cycles(4e-3)


SOFT = {"shadow_soft_size": 0.6}


def _blocks(pixels: np.ndarray) -> np.ndarray:
    return pixels.reshape(8, 6, 8, 6, 3).mean(axis=(1, 3))


@pytest.mark.parametrize(
    ("name", "kind", "is_ball"),
    [
        pytest.param("noise by direction", "SPOT", False, marks=pytest.mark.long),
        pytest.param("noise by normal", "POINT", True, marks=pytest.mark.costly),
        pytest.param("noise by direction", "POINT", True, marks=pytest.mark.long),
        pytest.param("noise by normal", "POINT", False, marks=pytest.mark.long),
    ],
)
def test_soft_lamps_have_the_pattern_of_their_balls_or_of_where_they_shine(
    name: str,
    kind: str,
    is_ball: bool,  # noqa: FBT001
) -> None:
    if is_ball and bpy.app.version < (4, 2, 0):
        pytest.skip("before 4.2 there is no choice")
    lamp = stage(kind, **SOFT)
    if bpy.app.version >= (4, 2, 0):
        lamp.data.use_soft_falloff = not is_ball
    shows(lamp, PATTERNS[name])
    shown = texture()
    assert shown is not None
    assert (shown.follows_normal and is_ball) == (is_ball and name == "noise by normal")
    scene = bpy.context.scene
    theirs = [_blocks(cycles_pixels(scene, 128, seed=seed)) for seed in (1, 2)]
    ours = _blocks(tyndall_pixels(scene, 64))
    level, noise = np.mean(theirs), 0.5 * np.std(theirs[0] - theirs[1])
    error = np.abs(ours - np.mean(theirs, axis=0)) / level
    print(f"{error.mean():.5f} beside noise {noise / level:.5f}")
    assert np.std(theirs[0]) > 0.05 * level
    assert error.mean() < 2.0 * noise / level + 1e-3
    np.testing.assert_allclose(ours.mean(), level, rtol=2e-3)


def _lamp() -> bpy.types.Object:
    return next(thing for thing in bpy.context.scene.objects if thing.type == "LIGHT")


@pytest.mark.costly
@pytest.mark.parametrize(
    ("kind", "name"), [("spot", "noise by normal"), pytest.param("point", "bands", marks=pytest.mark.long)]
)
def test_a_pattern_colours_the_fog(kind: str, name: str) -> None:
    def make() -> None:
        build(Arrangement(light=kind))
        shows(_lamp(), PATTERNS[name])

    assert_air_like_cycles(f"nodes {kind} {name}", make, make, methods=("EXACT", "EPIPOLAR"))


@pytest.mark.parametrize("kind", ["spot", pytest.param("point", marks=pytest.mark.long)])
def test_shadow_maps_and_rows_show_the_same_pattern(kind: str) -> None:
    build(Arrangement(light=kind))
    shows(_lamp(), PATTERNS["noise by direction"])
    exact, rows, maps = shafts_of(bpy.context.scene, ("EXACT", "EPIPOLAR", "SHADOW_MAP"))
    level = exact.mean()
    for other, bound in ((rows, 5e-3), (maps, 1e-2)):
        error = np.abs(other - exact) / level
        print(f"{error.mean():.5f}")
        assert error.mean() < bound
        np.testing.assert_allclose(other.mean(axis=(0, 1)), exact.mean(axis=(0, 1)), rtol=bound)


# --- what is drawn, and when -----------------------------------------------------------------------------------------
def hemisphere(new: New, link: Link) -> Socket:
    """White where it shines downwards along its own axis."""
    apart, less = new("ShaderNodeSeparateXYZ"), new("ShaderNodeMath")
    less.operation = "LESS_THAN"
    less.inputs[1].default_value = 0.0
    link(NORMAL(new, link), apart.inputs[0])
    link(apart.outputs[2], less.inputs[0])
    return less.outputs[0]


def test_its_strength_is_that_of_the_mean_over_all_directions() -> None:
    plain = np.array(read_of(stage("POINT")).strength)
    lamp = stage("POINT")
    lamp.matrix_world = lamp.matrix_world.normalized()
    shows(lamp, hemisphere)
    half = read_of(lamp)
    np.testing.assert_allclose(half.strength, 0.5 * plain, rtol=5e-3)  # half a row of texels
    assert half.texture is not None
    assert half.texture.projection is LightProjection.DIRECTIONS
    pixels = linear_colours(half.texture.use.image)
    weights = np.cos((np.linspace(0.0, 1.0, len(pixels)) - 0.5) * np.pi)
    mean = (pixels * weights[:, None, None]).sum(axis=(0, 1)) / (weights.sum() * pixels.shape[1])
    np.testing.assert_allclose(mean @ half.texture.gain, 1.0, rtol=1e-4)


def read_of(lamp: bpy.types.Object) -> Light:
    return next(one for one in read().lights if one.name == lamp.name)


@pytest.mark.parametrize(
    ("make", "is_own"), [(PATTERNS["noise by normal"], True), (PATTERNS["noise by direction"], False)]
)
@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
def test_what_turns_with_a_lamp_is_drawn_once(kind: str, make: Make, is_own: bool) -> None:  # noqa: FBT001
    """And what does not, where the lamp has no cone, neither."""
    lamp, reader = stage(kind), SceneReader()
    shows(lamp, make)
    first = read(reader).lights[0].texture
    lamp.matrix_world = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.7, 4, "Y") @ lamp.matrix_world
    bpy.context.view_layer.update()
    second = read(reader).lights[0].texture
    assert first is not None
    assert second is not None
    assert (first.use.image is second.use.image) == (is_own or kind == "POINT")
    assert (first.axes_from_world == second.axes_from_world).all() == (not is_own and kind == "POINT")


def test_strengths_and_tints_change_no_picture() -> None:
    lamp, reader = stage("SPOT"), SceneReader()
    emission = next(one for one in tree_of(lamp).nodes if one.type == "EMISSION")
    tint = tree_of(lamp).nodes.new("ShaderNodeMixRGB")
    tint.blend_type, tint.inputs["Fac"].default_value = "MULTIPLY", 1.0
    shows(lamp, PATTERNS["noise by normal"])
    tree_of(lamp).links.new(emission.inputs["Color"].links[0].from_socket, tint.inputs["Color1"])
    tree_of(lamp).links.new(tint.outputs[0], emission.inputs["Color"])
    (before,) = read(reader).lights
    start = np.array(tint.inputs["Color2"].default_value[:3])
    tint.inputs["Color2"].default_value, emission.inputs["Strength"].default_value = (0.5, 0.25, 1.0, 1.0), 3.0
    (after,) = read(reader).lights
    assert before.texture is not None
    assert after.texture is not None
    assert before.texture.use.image is after.texture.use.image
    white = np.array(tint.inputs["Color2"].default_value[:3]) * 3.0
    np.testing.assert_allclose(np.array(after.strength) / before.strength, white / start, rtol=1e-5)
    assert_like_cycles(4e-3)


def test_a_lamp_that_shines_alike_everywhere_has_no_picture() -> None:
    plain = np.array(read_of(stage("SPOT")).strength)
    lamp = stage("SPOT")
    shows(lamp, pattern("ShaderNodeTexNoise", output("ShaderNodeTexCoord", "Object")))  # its middle
    assert texture() is None
    assert read().reports == ()
    assert_same_light()
    lamp = stage("SPOT")
    shows(lamp, lambda new, _: node(new, "ShaderNodeBlackbody", Temperature=3000.0).outputs[0])
    assert texture() is None
    assert (np.array(read_of(lamp).strength) != plain).any()


@pytest.mark.parametrize("name", ["noise by direction", "noise by normal", "squared image"])
def test_a_sun_has_one_colour_wherever_it_shines(name: str) -> None:
    lamp = stage("SUN")
    shows(lamp, PATTERNS[name])
    assert texture() is None
    said = 'Light "Sun": its nodes see no position on a sun: an image shows one place, its gobo all'
    assert read().reports == ((said,) if "image" in name else ())
    assert_same_light()


@pytest.mark.parametrize("name", ["Random", "Color", "Object Index"])
@pytest.mark.parametrize("kind", ["POINT", "AREA"])
def test_lamps_of_one_tree_may_differ_by_what_their_objects_are(kind: str, name: str) -> None:
    """As in Cycles; what is read alone, in a viewport, is the same."""
    lamp = stage(kind, 8, **({"size": 0.5} if kind == "AREA" else {}))
    shows(lamp, output("ShaderNodeObjectInfo", name))
    other = lamp.copy()
    other.name, other.location.x, other.color, other.pass_index = "Other", 2.0, (0.2, 0.9, 0.4, 1.0), 2
    bpy.context.scene.collection.objects.link(other)
    lights = {one.name: np.array(one.strength) for one in read().lights}
    assert len(lights) == 2
    assert (lights["Other"] != lights[lamp.name]).any() or not (IS_4 or name == "Random")
    if kind == "POINT":
        theirs, ours = cycles_pixels(bpy.context.scene, 512, seed=1), tyndall_pixels(bpy.context.scene)
        np.testing.assert_allclose(ours.mean(axis=(0, 1)), theirs.mean(axis=(0, 1)), rtol=5e-3)
        reader = SceneReader()
        read(reader, is_live=True)
        other.data.energy *= 2.0
        bpy.context.view_layer.update()
        again = {one.name: np.array(one.strength) for one in read(reader, is_live=True).lights}
        np.testing.assert_allclose(again["Other"], 2.0 * lights["Other"], rtol=1e-6)


def test_lamps_that_are_drawn_from_a_tree_show_their_patterns() -> None:
    """More than 32 of them, in one place, are one."""
    lamp = stage("SPOT")
    shows(lamp, PATTERNS["noise by normal"])
    one = tyndall_pixels(bpy.context.scene, 64)
    lamp.data.energy /= 36.0
    for _ in range(35):
        bpy.context.scene.collection.objects.link(lamp.copy())
    many = tyndall_pixels(bpy.context.scene, 64)
    np.testing.assert_allclose(_blocks(many), _blocks(one), rtol=0.02)


@pytest.mark.parametrize(
    ("kind", "output_name", "says"),
    [
        ("ShaderNodeLightPath", "Ray Length", "Light Path Ray Length is read as 0: all rays see a lamp alike"),
        ("ShaderNodeAttribute", "Color", "Attribute Color is read as 0 in a lamp"),
    ],
)
def test_what_is_not_known_of_a_lamp_is_named(kind: str, output_name: str, says: str) -> None:
    shows(stage("POINT"), mixed(PATTERNS["noise by normal"], output(kind, output_name), "ADD"))
    assert read().reports == (f'Light "Point": {says}',)
    assert texture() is not None


@pytest.mark.parametrize("kind", ["SUN", "POINT", "SPOT", "AREA"])
def test_nodes_without_an_output_send_no_light(kind: str) -> None:
    """As in Cycles. Seen to fail where such a light passes for one without nodes."""
    lamp = stage(kind, size_px=16, **({"size": 1.0} if kind == "AREA" else {}))
    lamp.data.use_nodes = True
    scene = bpy.context.scene
    assert min(tyndall_pixels(scene, 1).max(), cycles_pixels(scene, 1, seed=1).max()) > 0.01
    tree = lamp.data.node_tree
    tree.nodes.remove(next(one for one in tree.nodes if one.bl_idname == "ShaderNodeOutputLight"))
    assert max(tyndall_pixels(scene, 1).max(), cycles_pixels(scene, 1, seed=1).max()) == 0.0


def test_a_gobo_goes_before_a_pattern() -> None:
    plain = read_of(stage("SPOT")).strength
    lamp = stage("SPOT")
    shows(lamp, PATTERNS["noise by normal"])
    lamp.data.tyndall.gobo_image = picture("Other")
    shown = read_of(lamp)
    assert shown.texture is not None
    assert shown.texture.use.image.name == "Other"
    assert shown.strength == plain
    assert read().reports == ('Light "Spot": its gobo takes the place of its nodes\' pattern',)
