# SPDX-License-Identifier: GPL-3.0-or-later
"""What is no surface's shader and glows: a colour that a group passes on in a shader's place, a world's Background."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from addon.node_groups import add_socket
from support.engine_pictures import FloatArray, cycles_pixels, tyndall_pixels
from support.patch_nodes import Link, New
from support.small_scenes import empty_scene, light, material, node, plane

_COLOUR = (0.1, 0.4, 0.7)


def _passed_on(new: New, link: Link) -> bpy.types.NodeSocket:
    """Of a group that mixes half a black shader with a colour of its own."""
    tree = bpy.data.node_groups.new("Given", "ShaderNodeTree")
    add_socket(tree, "Colour", "NodeSocketColor")
    add_socket(tree, "Shader", "NodeSocketShader", is_output=True)
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(tree.nodes.new("NodeGroupInput").outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes.new("NodeGroupOutput").inputs[0])
    group = new("ShaderNodeGroup")
    group.node_tree = tree
    group.inputs[0].default_value = (*_COLOUR, 1.0)
    return group.outputs[0]


def _both(scene: bpy.types.Scene, samples: int = 1) -> tuple[FloatArray, FloatArray]:
    return tyndall_pixels(scene, samples), cycles_pixels(scene, samples=16 * samples, seed=1)


def test_a_world() -> None:
    scene = empty_scene()
    tree = scene.world.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_WORLD")
    tree.links.new(_passed_on(tree.nodes.new, tree.links.new), output.inputs["Surface"])
    ours, cycles = _both(scene)
    assert cycles[0, 0] == pytest.approx(np.array(_COLOUR) / 2.0, rel=1e-5)
    np.testing.assert_allclose(ours, cycles, rtol=1e-5)


def test_a_surface() -> None:
    scene = empty_scene()
    plane(0.0, material("Given", _passed_on))
    ours, cycles = _both(scene)
    assert cycles[0, 0] == pytest.approx(np.array(_COLOUR) / 2.0, rel=1e-5)
    np.testing.assert_allclose(ours, cycles, rtol=1e-5)


def test_the_background_of_a_world_on_a_surface_glows() -> None:
    scene = empty_scene()
    plane(
        0.0, material("Background", lambda new, _: node(new, "ShaderNodeBackground", Color=(*_COLOUR, 1.0)).outputs[0])
    )
    ours, cycles = _both(scene)
    assert cycles[0, 0] == pytest.approx(_COLOUR, rel=1e-5)
    np.testing.assert_allclose(ours, cycles, rtol=1e-5)


def test_a_light() -> None:
    scene = empty_scene()
    plane(0.0)
    lamp = light("SUN", (0.0, 0.0, 3.0), energy=2.0, angle=0.0)
    lamp.data.use_nodes = True
    tree = lamp.data.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_LIGHT")
    tree.links.new(_passed_on(tree.nodes.new, tree.links.new), output.inputs["Surface"])
    ours, cycles = _both(scene)
    assert cycles[0, 0].min() > 0.0
    np.testing.assert_allclose(ours, cycles, rtol=1e-4)


def test_a_shader_in_place_of_a_colour_is_no_link() -> None:
    """Blender marks such a link as wrong, and Cycles takes the colour that the node has itself."""

    def wrongly_linked(new: New, link: Link) -> bpy.types.NodeSocket:
        glow = node(new, "ShaderNodeEmission", Color=(*_COLOUR, 1.0), Strength=0.5)
        for name in ("Color", "Strength"):
            link(new("ShaderNodeBsdfDiffuse").outputs[0], glow.inputs[name])
        return glow.outputs[0]

    scene = empty_scene()
    plane(0.0, material("Wrongly linked", wrongly_linked))
    ours, cycles = _both(scene)
    assert cycles[0, 0] == pytest.approx(np.array(_COLOUR) / 2.0, rel=1e-5)
    np.testing.assert_allclose(ours, cycles, rtol=1e-5)
