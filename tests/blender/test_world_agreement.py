# SPDX-License-Identifier: GPL-3.0-or-later
"""The world behind the scene and its light are those of Cycles: colours, images, and how nodes turn them."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.sky_scenes import WorldTree, errors, under
from support.small_scenes import Node, empty_scene, material, node, plane

Turn = Callable[[bpy.types.NodeTree], bpy.types.NodeSocket | None]
Pattern = WorldTree


def panorama() -> bpy.types.Image:
    """32 x 16 floats that differ everywhere, smoothly: no two directions look alike."""
    image = bpy.data.images.new("Panorama", 32, 16, float_buffer=True)
    u, v = np.meshgrid((np.arange(32) + 0.5) / 32, (np.arange(16) + 0.5) / 16)
    pixels = np.stack(
        [0.5 + 0.4 * np.sin(2 * np.pi * u), 0.5 + 0.4 * np.cos(2 * np.pi * u), v, np.ones_like(u)], axis=-1
    )
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.update()
    return image


def mapping(**properties: object) -> Turn:
    def turn(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        created: Node = tree.nodes.new("ShaderNodeMapping")
        created.vector_type = properties.get("vector_type", "POINT")
        created.inputs["Rotation"].default_value = properties.get("Rotation", (0, 0, 0))
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], created.inputs["Vector"])
        return created.outputs[0]

    return turn


def own_mapping(tree: bpy.types.NodeTree) -> None:
    """What files of 2.7 turn panoramas by, without a vector."""
    placed = next(one for one in tree.nodes if one.type == "TEX_ENVIRONMENT").texture_mapping
    placed.vector_type, placed.rotation = "TEXTURE", (0.4, -0.7, 1.0)


def under_panorama(turn: Turn, strength: float = 1.0) -> bpy.types.Scene:
    scene = empty_scene(size_px=24)
    tree = scene.world.node_tree
    texture, background = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes["Background"]
    texture.image = panorama()
    background.inputs["Strength"].default_value = strength
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    vector = turn(tree)
    if vector is not None:
        tree.links.new(vector, texture.inputs["Vector"])
    scene.camera.data.type = "PERSP"
    return scene


TURNS: dict[str, Turn] = {
    "as it is": lambda _tree: None,
    "turned": mapping(Rotation=(0.0, 0.0, 1.0)),
    "tumbled": mapping(Rotation=(0.4, -0.7, 1.0)),
    "tumbled back": mapping(vector_type="TEXTURE", Rotation=(0.4, -0.7, 1.0)),
    "by its own mapping": own_mapping,
}


@pytest.mark.dealt
@pytest.mark.parametrize("name", TURNS)
@pytest.mark.parametrize("camera_rotation", [(1.5, 0.0, 0.3), (1.0, 0.2, 2.5)])
def test_every_direction_of_an_image_is_seen_where_cycles_sees_it(
    name: str, camera_rotation: tuple[float, float, float]
) -> None:
    scene = under_panorama(TURNS[name], strength=1.5)
    scene.camera.rotation_euler = camera_rotation
    assert tyndall_pixels(scene) == pytest.approx(cycles_pixels(scene, 1, seed=1), abs=2e-3)


@pytest.mark.dealt
def test_an_image_lights_a_plane_as_in_cycles() -> None:
    """Both sample it; 4,096 rays of ours leave 0.7 %."""
    scene = under_panorama(TURNS["tumbled"])
    grey = material("Grey", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs[0])
    plane(material=grey)
    scene.render.resolution_x = scene.render.resolution_y = 64
    pictures = tyndall_pixels(scene), cycles_pixels(scene, 32, seed=1)
    ours, cycles = (picture.mean(axis=(0, 1)) for picture in pictures)
    assert ours == pytest.approx(cycles, rel=0.03)


def gradient(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """From the height of the direction, through a ramp."""
    separate, ramp = tree.nodes.new("ShaderNodeSeparateXYZ"), tree.nodes.new("ShaderNodeValToRGB")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], separate.inputs[0])
    ramp.color_ramp.elements[0].color = (0.8, 0.3, 0.1, 1.0)
    ramp.color_ramp.elements[1].color = (0.05, 0.2, 0.9, 1.0)
    tree.links.new(separate.outputs["Z"], ramp.inputs[0])
    return ramp.outputs[0]


def noise(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    created = tree.nodes.new("ShaderNodeTexNoise")
    created.inputs["Scale"].default_value = 2.0
    return created.outputs["Color"]


def image(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    created = tree.nodes.new("ShaderNodeTexEnvironment")
    created.image = panorama()
    return created.outputs[0]


def encoded_image(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """16 x 8 bytes, of which half are dark: between two, light is far from the mean of both."""
    created = tree.nodes.new("ShaderNodeTexEnvironment")
    created.image = bpy.data.images.new("Encoded", 16, 8)
    pixels = np.random.default_rng(2).choice([0.2, 1.0], (8, 16, 4)).astype(np.float32)
    created.image.pixels.foreach_set(pixels.ravel())
    created.image.update()
    return created.outputs[0]


def mixed(blend: str, first: Pattern, second: Pattern, share: float = 0.5) -> Pattern:
    def build(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        mix = tree.nodes.new("ShaderNodeMixRGB")
        mix.blend_type = blend
        mix.inputs["Fac"].default_value = share
        tree.links.new(first(tree), mix.inputs["Color1"])
        tree.links.new(second(tree), mix.inputs["Color2"])
        return mix.outputs[0]

    return build


def for_cameras(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """A pattern that cameras see, while an image lights."""
    mix = tree.nodes.new("ShaderNodeMixRGB")
    tree.links.new(tree.nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"], mix.inputs["Fac"])
    tree.links.new(image(tree), mix.inputs["Color1"])
    tree.links.new(gradient(tree), mix.inputs["Color2"])
    return mix.outputs[0]


PATTERNS: dict[str, Pattern] = {
    "gradient": gradient,
    "noise": noise,
    "image of bytes": encoded_image,
    "image plus its noise": mixed("ADD", image, noise, 1.0),
    "image and gradient": mixed("MIX", image, gradient),
    "for cameras": for_cameras,
    "constant for cameras": mixed("MIX", gradient, lambda tree: tree.nodes.new("ShaderNodeRGB").outputs[0]),
}


@pytest.mark.dealt
@pytest.mark.parametrize("name", PATTERNS)
def test_a_world_of_nodes_is_seen_as_in_cycles(name: str) -> None:
    """Each direction by itself: sharp, whatever the size of the image that lights."""
    scene = under(PATTERNS[name], has_things=False)
    assert tyndall_pixels(scene) == pytest.approx(cycles_pixels(scene, 1, seed=1), abs=2e-3)


@pytest.mark.dealt
@pytest.mark.parametrize("name", PATTERNS)
def test_a_world_of_nodes_lights_as_in_cycles(name: str) -> None:
    scene = under(PATTERNS[name], size_px=32)
    mean, median = errors(tyndall_pixels(scene, 64), cycles_pixels(scene, 256, seed=1))
    print(f"mean {mean:.4f}, median block {median:.4f}")
    assert mean <= 0.01
    assert median <= 0.01
    assert not last_render.statistics_of("Scene")["reports"]


@pytest.mark.dealt
@pytest.mark.parametrize("name", ["even", "gradient"])
@pytest.mark.parametrize("hidden_from", ["camera", "diffuse glossy scatter"])
def test_a_world_is_black_to_rays_that_do_not_see_it(hidden_from: str, name: str) -> None:
    """A world hides by the switches of its ray visibility, in front of things and around them."""
    scene = under(PATTERNS["gradient"], size_px=32)
    if name == "even":
        tree = scene.world.node_tree
        tree.links.remove(tree.nodes["Background"].inputs["Color"].links[0])
        tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.6, 0.9, 1)
    for ray in hidden_from.split():
        setattr(scene.world.cycles_visibility, ray, False)
    theirs = cycles_pixels(scene, 256, seed=1)
    mean, median = errors(tyndall_pixels(scene, 64), theirs)
    assert theirs.mean() > 0.01
    assert mean <= 0.01
    assert median <= 0.01
    assert not last_render.statistics_of("Scene")["reports"]


@pytest.mark.dealt
@pytest.mark.parametrize("world", ["even", "image"])
def test_normals_that_lean_over_find_no_light_below_the_surface(world: str) -> None:
    """A sheet whose own normals lean by 53 degrees: a fifth of what they see of an even world lies below the sheet.

    Of an image, what Cycles counts from there depends on how it shares samples out; in 3.4 some of all worlds.
    """
    scene = under_panorama(TURNS["as it is"]) if world == "image" else empty_scene(size_px=24)
    if world == "even":
        background = scene.world.node_tree.nodes["Background"]
        background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (1, 1, 1, 1), 1.0
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 1.8
    sheet = plane(material=material("Diffuse", surface=lambda new, _: new("ShaderNodeBsdfDiffuse").outputs[0])).data
    if bpy.app.version < (4, 1, 0):
        sheet.use_auto_smooth = True
    sheet.normals_split_custom_set([(0.8, 0.0, 0.6)] * len(sheet.loops))
    ours, cycles = tyndall_pixels(scene, 256), cycles_pixels(scene, samples=256, seed=1)
    assert cycles.mean() > 0.1
    bound = 0.07 if world == "image" else 5e-3 if bpy.app.version >= (4, 0, 0) else 0.04
    assert ours.mean(axis=(0, 1)) == pytest.approx(cycles.mean(axis=(0, 1)), rel=bound)
