# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights whose nodes vary over them light surfaces, gloss and air as in Cycles; the others are as they were."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix

from support.agreement_scenes import Arrangement, build
from support.cycles_reference import agreement, pixels_on_edges
from support.cycles_reference import cycles_pixels as noisy_cycles
from support.cycles_reference import tyndall_pixels as noisy_ours
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import empty_scene, light, material, node, plane, read
from tyndall.linear_colours import linear_colours
from tyndall.scene_description import LightProjection, LightTexture

pytestmark = pytest.mark.dealt

IS_4 = bpy.app.version >= (4, 0, 0)
Tree, Socket = bpy.types.NodeTree, bpy.types.NodeSocket
Pattern = Callable[[Tree], Socket]


def picture(size: tuple[int, int] = (5, 4)) -> bpy.types.Image:
    """Bright and dark texels, each of its own colour."""
    made = bpy.data.images.new("Slide", *size, float_buffer=True)
    made.colorspace_settings.name = "Non-Color"
    values = np.random.default_rng(1).uniform(0.0, 1.0, (size[1], size[0], 4)).astype(np.float32) ** 2
    values[..., 3] = 1.0
    made.pixels.foreach_set(values.ravel())
    made.pack()
    return made


def output(tree: Tree, kind: str, name: str) -> Socket:
    return next(one for one in tree.nodes.new(kind).outputs if one.identifier == name)


def image(tree: Tree, place: Socket | None, **options: object) -> Socket:
    made = tree.nodes.new("ShaderNodeTexImage")
    made.image = picture()
    for name, value in options.items():
        setattr(made, name, value)
    if place is not None:
        tree.links.new(place, made.inputs["Vector"])
    return made.outputs["Color"]


def parametric(tree: Tree) -> Socket:
    return output(tree, "ShaderNodeNewGeometry", "Parametric")


def slide(tree: Tree) -> Socket:
    return image(tree, parametric(tree))


def turned_slide(tree: Tree) -> Socket:
    """Sharp texels, and nothing beside them."""
    mapping = node(tree.nodes.new, "ShaderNodeMapping", Scale=(1.4, 1.1, 1.0), Rotation=(0.0, 0.0, 0.4))
    tree.links.new(parametric(tree), mapping.inputs["Vector"])
    return image(tree, mapping.outputs[0], interpolation="Closest", extension="CLIP")


def slide_on_uv(tree: Tree) -> Socket:
    return image(tree, output(tree, "ShaderNodeTexCoord", "UV"))


def noise(tree: Tree) -> Socket:
    """At its own vector, which is where the light is in its object."""
    made = node(tree.nodes.new, "ShaderNodeTexNoise", Scale=2.0)
    return made.outputs["Color"]


def gradient_in_world(tree: Tree) -> Socket:
    made = tree.nodes.new("ShaderNodeTexGradient")
    tree.links.new(output(tree, "ShaderNodeNewGeometry", "Position"), made.inputs["Vector"])
    return made.outputs["Color"]


def two_halves(tree: Tree) -> Socket:
    """White where u < 0.5."""
    apart, less = tree.nodes.new("ShaderNodeSeparateXYZ"), tree.nodes.new("ShaderNodeMath")
    less.operation = "LESS_THAN"
    tree.links.new(parametric(tree), apart.inputs[0])
    tree.links.new(apart.outputs[0], less.inputs[0])
    return less.outputs[0]


def shows(lamp: bpy.types.Object, pattern: Pattern) -> None:
    data = lamp.data
    if not data.use_nodes:
        data.use_nodes = True
    emission = next(one for one in data.node_tree.nodes if one.type == "EMISSION")
    data.node_tree.links.new(pattern(data.node_tree), emission.inputs["Color"])


def stage(shape: str = "RECTANGLE", scale_x: float = 1.0, roughness: float | None = None) -> bpy.types.Object:
    """A floor under a light that is turned and scaled, so near that each of its parts lights a place of its own."""
    scene = empty_scene(32)
    scene.camera.data.ortho_scale = 2.0
    scene.camera.location.z = 20.0
    if roughness is None:
        floor = material("Lambert", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)).outputs[0])
    else:
        kind = "ShaderNodeBsdfAnisotropic" if IS_4 else "ShaderNodeBsdfGlossy"
        floor = material("Gloss", lambda new, _: node(new, kind, Roughness=roughness).outputs[0])
    plane(material=floor, half_side=10.0)
    lamp = light("AREA", (0, 0, 0), energy=20.0, shape=shape, size=1.2)
    if shape in {"RECTANGLE", "ELLIPSE"}:
        lamp.data.size_y = 1.6
    turn = Euler((0.2, 0.1, 0.5)).to_matrix().to_4x4()
    lamp.matrix_world = Matrix.Translation((0.1, -0.1, 0.3)) @ turn @ Matrix.Diagonal((scale_x, 0.8, 1.2, 1))
    return lamp


def texture() -> LightTexture | None:
    (lamp,) = read().lights
    return lamp.texture


def blocks(pixels: np.ndarray, size: int = 4) -> np.ndarray:
    height, width = pixels.shape[0] // size, pixels.shape[1] // size
    return pixels.reshape(height, size, width, size, 3).mean(axis=(1, 3))


def assert_like_cycles(samples: int = 128) -> None:
    """Block by block, by the noise of both; it is several times the mean where blocks lie close under the light."""
    scene = bpy.context.scene
    theirs = [blocks(cycles_pixels(scene, samples, seed=seed)) for seed in (1, 2)]
    ours = [blocks(tyndall_pixels(scene, samples))]
    scene.tyndall.seed = 1
    ours.append(blocks(tyndall_pixels(scene, samples)))
    level = float(np.mean(theirs))
    noise_of_means = math.hypot(*(0.5 * float(np.std(a - b)) for a, b in (theirs, ours))) / level
    error = np.abs(np.mean(ours, axis=0) - np.mean(theirs, axis=0)) / level
    print(f"{error.mean():.5f} beside noise {noise_of_means:.5f}, at most {error.max():.5f}")
    assert np.std(theirs[0]) > 0.2 * level  # the pattern is seen
    assert error.mean() < 1.5 * noise_of_means + 5e-4
    assert error.max() < 12.0 * noise_of_means + 3e-3
    np.testing.assert_allclose(np.mean(ours, axis=(0, 1, 2)), np.mean(theirs, axis=(0, 1, 2)), rtol=4e-3)


@pytest.mark.parametrize(
    ("shape", "scale_x", "pattern"),
    [
        ("RECTANGLE", 1.0, slide),
        ("ELLIPSE", -1.0, turned_slide),
        ("DISK", 1.0, noise),
        pytest.param("RECTANGLE", -1.0, gradient_in_world, marks=pytest.mark.long),
        pytest.param("SQUARE", 1.0, slide_on_uv, marks=pytest.mark.long),
    ],
)
def test_each_part_of_the_light_lights_the_floor_below_it(shape: str, scale_x: float, pattern: Pattern) -> None:
    if pattern is slide_on_uv and not IS_4:
        pytest.skip("Cycles 3.4 gives lights no UV coordinates")
    if pattern is noise and not IS_4:
        pytest.skip("Cycles 3.4 has been seen to crash where a light's shader asks for generated coordinates")
    shows(stage(shape, scale_x), pattern)
    assert read().reports == ()
    assert_like_cycles()


def test_gloss_mirrors_the_picture() -> None:
    shows(stage(roughness=0.15), slide)
    assert_like_cycles()


def test_a_light_of_a_white_and_a_black_half_is_one_of_half_the_size() -> None:
    lamp = stage()
    shows(lamp, two_halves)
    halves = tyndall_pixels(bpy.context.scene, 256)
    lamp = stage()
    lamp.data.size *= 0.5
    lamp.data.energy *= 0.5
    lamp.matrix_world = lamp.matrix_world @ Matrix.Translation((-0.3, 0, 0))
    half = tyndall_pixels(bpy.context.scene, 256)
    error = np.abs(blocks(halves) - blocks(half)) / half.mean()
    assert error.mean() < 4e-3
    assert abs(halves.mean() / half.mean() - 1.0) < 1e-3


def test_lights_that_are_drawn_from_a_tree_show_their_pictures() -> None:
    """More than 32 of them, in one place, are one."""
    lamp = stage()
    shows(lamp, slide)
    one = tyndall_pixels(bpy.context.scene, 128)
    lamp.data.energy /= 36.0
    for _ in range(35):
        other = lamp.copy()
        bpy.context.scene.collection.objects.link(other)
    many = tyndall_pixels(bpy.context.scene, 128)
    assert np.abs(blocks(many) - blocks(one)).mean() < 0.01 * one.mean()
    np.testing.assert_allclose(many.mean(axis=(0, 1)), one.mean(axis=(0, 1)), rtol=2e-3)


def test_the_air_is_lit_in_the_pictures_colours() -> None:
    build(Arrangement("area", "camera inside", "perspective", "grid"))
    lamp = next(thing for thing in bpy.context.scene.objects if thing.type == "LIGHT")
    shows(lamp, two_halves)
    scene = bpy.context.scene
    theirs = tuple(noisy_cycles(scene, 64, seed=seed) for seed in (1, 2))
    (ours,) = noisy_ours(scene, ("EPIPOLAR",), surface_samples=64)
    (again,) = noisy_ours(scene, ("EPIPOLAR",), surface_samples=64, seed=1)
    verdict = agreement((ours, again), theirs, pixels_on_edges(scene), 64)
    assert verdict.holds, verdict


# --- what costs nothing ----------------------------------------------------------------------------------------------
def test_a_light_that_shines_alike_all_over_has_no_picture() -> None:
    lamp = stage()
    plain = np.array(read().lights[0].strength)
    shows(lamp, lambda tree: output(tree, "ShaderNodeRGB", "Color"))
    rgb = next(one for one in lamp.data.node_tree.nodes if one.type == "RGB")
    rgb.outputs[0].default_value = (0.25, 0.5, 1.0, 1.0)
    assert texture() is None
    np.testing.assert_array_equal(read().lights[0].strength, plain * (0.25, 0.5, 1.0))
    lamp = stage()
    shows(lamp, lambda tree: output(tree, "ShaderNodeNewGeometry", "Normal"))
    assert texture() is None
    normal = -np.array(lamp.matrix_world.to_3x3().col[2].normalized())
    np.testing.assert_allclose(read().lights[0].strength, plain * normal, rtol=1e-5)  # below 0, too


@pytest.mark.parametrize("shape", ["RECTANGLE", "ELLIPSE"])
def test_its_strength_is_that_of_the_mean_of_its_picture(shape: str) -> None:
    lamp = stage(shape)
    plain = np.array(read().lights[0].strength)
    shows(lamp, two_halves)
    np.testing.assert_allclose(read().lights[0].strength, 0.5 * plain, rtol=1e-3)
    shown = texture()
    assert shown is not None
    assert shown.projection is LightProjection.EMITTER
    mean = linear_colours(shown.use.image).mean(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(mean @ shown.gain, 1.0, rtol=1e-4)


# --- our own property ------------------------------------------------------------------------------------------------
def test_a_gobo_lies_on_the_light() -> None:
    lamp = stage()
    shows(lamp, slide)
    by_nodes = tyndall_pixels(bpy.context.scene)
    lamp = stage()
    lamp.data.tyndall.gobo_image, lamp.data.tyndall.gobo_extension = picture(), "REPEAT"
    np.testing.assert_allclose(tyndall_pixels(bpy.context.scene), by_nodes, rtol=1e-5)
    lamp.data.tyndall.gobo_strength = 0.0
    assert texture() is None
    shows(lamp, two_halves)
    assert read().reports == ('Light "Area": its gobo takes the place of its nodes\' pattern',)


# --- bad input -------------------------------------------------------------------------------------------------------
def test_a_missing_image_is_magenta_as_in_cycles() -> None:
    lamp = stage()
    shows(lamp, slide)
    next(one for one in lamp.data.node_tree.nodes if one.type == "TEX_IMAGE").image = None
    description = read()
    assert description.reports == ('Light "Area": an image node without an image is magenta',)
    red, green, blue = description.lights[0].strength
    assert red == blue > green == 0.0


@pytest.mark.parametrize(
    ("kind", "name", "says"),
    [
        ("ShaderNodeNewGeometry", "Incoming", "Geometry Incoming is read as seen from straight before the light"),
        ("ShaderNodeLayerWeight", "Facing", "Layer Weight Facing is read as seen from straight before the light"),
        ("ShaderNodeLightPath", "Ray Length", "Light Path Ray Length is read as 0: all rays see an area light alike"),
        ("ShaderNodeAttribute", "Color", "Attribute Color is read as 0 in an area light"),
    ],
)
def test_what_changes_with_more_than_the_place_is_told(kind: str, name: str, says: str) -> None:
    lamp = stage()
    shows(lamp, lambda tree: output(tree, kind, name))
    assert read().reports == (f'Light "Area": {says}',)
    assert texture() is None


def test_cameras_do_not_count_as_rays_that_see_it() -> None:
    lamp = stage()
    shows(lamp, lambda tree: output(tree, "ShaderNodeLightPath", "Is Camera Ray"))
    assert read().reports == ()
    assert read().lights[0].strength == (0.0, 0.0, 0.0)
