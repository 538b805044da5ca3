# SPDX-License-Identifier: GPL-3.0-or-later
"""The world behind the scene and its light are those of Cycles: colours, images, and how nodes turn them."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Node, empty_scene, material, node, plane

Turn = Callable[[bpy.types.NodeTree], bpy.types.NodeSocket | None]


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
}


@pytest.mark.parametrize("name", TURNS)
@pytest.mark.parametrize("camera_rotation", [(1.5, 0.0, 0.3), (1.0, 0.2, 2.5)])
def test_every_direction_of_an_image_is_seen_where_cycles_sees_it(
    name: str, camera_rotation: tuple[float, float, float]
) -> None:
    scene = under_panorama(TURNS[name], strength=1.5)
    scene.camera.rotation_euler = camera_rotation
    assert tyndall_pixels(scene) == pytest.approx(cycles_pixels(scene, 1, seed=1), abs=2e-3)


def test_an_image_lights_a_plane_as_in_cycles() -> None:
    """Both sample it; 4,096 rays of ours leave 0.7 %."""
    scene = under_panorama(TURNS["tumbled"])
    grey = material("Grey", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs[0])
    plane(material=grey)
    scene.render.resolution_x = scene.render.resolution_y = 64
    pictures = tyndall_pixels(scene), cycles_pixels(scene, 32, seed=1)
    ours, cycles = (picture.mean(axis=(0, 1)) for picture in pictures)
    assert ours == pytest.approx(cycles, rel=0.03)


def test_arithmetic_that_is_not_a_factor_is_named() -> None:
    """An image plus a constant is no product of the two."""
    scene = under_panorama(TURNS["as it is"])
    tree = scene.world.node_tree
    mix = tree.nodes.new("ShaderNodeMixRGB")
    mix.blend_type = "ADD"
    background = tree.nodes["Background"]
    tree.links.new(background.inputs["Color"].links[0].from_socket, mix.inputs["Color1"])
    tree.links.new(mix.outputs[0], background.inputs["Color"])
    tyndall_pixels(scene)
    assert any('"World"' in line for line in last_render.statistics_of("Scene")["reports"])


def test_a_sky_texture_is_even_and_says_that_its_sun_is_missing() -> None:
    scene = empty_scene()
    tree = scene.world.node_tree
    tree.links.new(tree.nodes.new("ShaderNodeTexSky").outputs[0], tree.nodes["Background"].inputs["Color"])
    sky = tyndall_pixels(scene)
    assert sky.std(axis=(0, 1)) == pytest.approx(0.0, abs=1e-6)
    assert any("sun" in line.lower() for line in last_render.statistics_of("Scene")["reports"])
