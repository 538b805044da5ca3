# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees that are too long, circular or full of what is no number: read as far as they make sense, and named."""

from __future__ import annotations

import math

import bpy
import pytest

from addon.sync.images import ImageReader
from addon.sync.materials import MaterialReader
from addon.sync.reports import Reports
from support.agreement_shapes import diffuse
from tyndall.scene_description import Material


def _surface(material: bpy.types.Material) -> tuple[bpy.types.NodeTree, bpy.types.Node, bpy.types.Node]:
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    return tree, shader, next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")


def _read(material: bpy.types.Material) -> tuple[Material, str]:
    reports = Reports()
    reader = MaterialReader(reports, ImageReader(), is_voxels=True)
    return reader.materials[reader.index(material)], "\n".join(reports.lines())


def test_a_chain_longer_than_pythons_stack_has_its_value() -> None:
    """Of 400 nodes that add 1 each."""
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = _surface(material)
    source = tree.nodes.new("ShaderNodeValue").outputs[0]
    source.default_value = 0.25
    for _index in range(400):
        node = tree.nodes.new("ShaderNodeMath")
        node.inputs[1].default_value = 1.0
        tree.links.new(source, node.inputs[0])
        source = node.outputs[0]
    tree.links.new(source, shader.inputs["Color"])
    read, notes = _read(material)
    assert read.diffuse == pytest.approx((400.25,) * 3)
    assert notes == ""


def test_shaders_that_are_mixed_in_a_circle_are_named_and_what_is_outside_is_drawn() -> None:
    """Half of the surface is diffuse; the other half is the circle, of which half is diffuse, and so on."""
    material = diffuse((0.5, 0.5, 0.5))
    material.name = "Circle"
    tree, shader, output = _surface(material)
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(shader.outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    read, notes = _read(material)
    if all(link.is_valid for link in tree.links):
        assert read.diffuse == pytest.approx((0.5,) * 3)
        assert notes.startswith('Material "Circle": its shaders are mixed in a circle')
    else:  # 3.4 shows the link that closes it in red, and Cycles does not follow that
        assert bpy.app.version < (4, 0, 0)
        assert read.diffuse == pytest.approx((0.25,) * 3)


def test_more_ways_than_can_be_counted_end_with_a_note() -> None:
    """Forty mixes of the one before with itself."""
    material = diffuse((0.5, 0.5, 0.5))
    material.name = "Diamonds"
    tree, shader, output = _surface(material)
    source = shader.outputs[0]
    for _index in range(40):
        mix = tree.nodes.new("ShaderNodeMixShader")
        for socket in mix.inputs[1:3]:
            tree.links.new(source, socket)
        source = mix.outputs[0]
    tree.links.new(source, output.inputs["Surface"])
    assert 'Material "Diamonds"' in _read(material)[1]


def test_an_output_whose_surface_a_script_disabled_shows_nothing() -> None:
    """Seen to fail where the socket is looked up by its name."""
    material = diffuse((0.5, 0.5, 0.5))
    _surface(material)[2].inputs["Surface"].enabled = False
    read, notes = _read(material)
    assert (read.diffuse, read.transparent, notes) == ((0.0,) * 3, (0.0,) * 3, "")


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_named_and_does_not_reach_the_core(number: float) -> None:
    """Blender itself keeps infinite ones as the largest that are finite."""
    material = diffuse((0.5, 0.25, 0.5))
    material.name = "Mad"
    tree, shader, _output = _surface(material)
    value = tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = number
    times = tree.nodes.new("ShaderNodeMath")
    times.operation = "MULTIPLY"
    tree.links.new(value.outputs[0], times.inputs[0])
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], times.inputs[1])
    tree.links.new(times.outputs[0], shader.inputs["Color"])
    read, notes = _read(material)
    is_kept = not math.isfinite(value.outputs[0].default_value)
    assert ('Material "Mad": Value has a value that is not finite' in notes) == is_kept
    assert all(math.isfinite(channel) for op in read.program for channel in op.value)
