# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group that lays the light of the air over a picture.

    image x T' + light x m x strength,   T' = 1 + (transmittance - 1) m,   m = mask x coverage
    alpha' = 1 - (1 - alpha) mean(T')

Exact where a pixel sees one depth. Where it mixes surfaces of radiance L, it has mean(L) mean(T) in place of mean(L T):
the error is their covariance, at most a quarter of L's range times T's. Coverage is 1 where the light shafts were
rendered: without them, or outside a border, the picture stays as it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..node_groups import add_socket, mark, marked_group

if TYPE_CHECKING:
    from bpy.types import Node, NodeSocket, NodeTree

#: Mark of the group.
COMPOSE_GROUP = "COMPOSE_GROUP"
#: Of our inputs: the output of a Render Layers node that feeds each. Alpha is written by the engine.
INPUTS_OF_PASSES = {"Air Light": "Image", "Transmittance": "Transmittance", "Coverage": "Alpha"}
_HAS_SHADER_NODES = bpy.app.version >= (5, 0, 0)
_MATH = "ShaderNodeMath" if _HAS_SHADER_NODES else "CompositorNodeMath"


def compose_group() -> NodeTree:
    """This file's, made where there is none."""
    tree = marked_group(COMPOSE_GROUP)
    if tree is not None:
        return tree
    tree = bpy.data.node_groups.new("Light Shafts over Picture", "CompositorNodeTree")
    mark(tree, COMPOSE_GROUP)
    add_socket(tree, "Image", "NodeSocketColor", default=(0.0, 0.0, 0.0, 1.0))
    add_socket(tree, "Air Light", "NodeSocketColor", default=(0.0, 0.0, 0.0, 1.0))
    add_socket(tree, "Transmittance", "NodeSocketColor", default=(1.0, 1.0, 1.0, 1.0))
    add_socket(tree, "Coverage", "NodeSocketFloat", default=0.0, limits=(0.0, 1.0))
    add_socket(tree, "Strength", "NodeSocketFloat", default=1.0, limits=(0.0, 100.0))
    add_socket(tree, "Mask", "NodeSocketFloat", default=1.0, limits=(0.0, 1.0))
    for name in ("Image", "Air Light", "Transmittance"):
        add_socket(tree, name, "NodeSocketColor", is_output=True)
    _Builder(tree).build()
    return tree


class _Builder:
    def __init__(self, tree: NodeTree) -> None:
        self._tree = tree
        self._column = 0

    def build(self) -> None:
        given, result = self._node("NodeGroupInput").outputs, self._node("NodeGroupOutput")
        share = self._math("MULTIPLY", given["Mask"], given["Coverage"])
        lets_through = self._mix("MIX", share, (1.0, 1.0, 1.0, 1.0), given["Transmittance"])
        amount = self._math("MULTIPLY", share, given["Strength"])
        light = self._mix("MULTIPLY", 1.0, given["Air Light"], amount)
        dimmed = self._mix("MULTIPLY", 1.0, given["Image"], lets_through)
        lit = self._mix("ADD", 1.0, dimmed, light)
        red, green, blue, _ = self._separate(lets_through)
        sum_of_channels = self._math("ADD", self._math("ADD", red, green), blue)
        mean = self._math("DIVIDE", sum_of_channels, 3.0)
        *_, alpha = self._separate(given["Image"])
        sky = self._math("MULTIPLY", self._math("SUBTRACT", 1.0, alpha), mean)
        combined = self._node("CompositorNodeCombineColor")
        for socket, value in zip(
            combined.inputs, (*self._separate(lit)[:3], self._math("SUBTRACT", 1.0, sky)), strict=True
        ):
            self._tree.links.new(value, socket)
        result.location.x = 200.0 * (self._column + 1)
        for name, output in (
            ("Image", combined.outputs[0]),
            ("Air Light", light),
            ("Transmittance", lets_through),
        ):
            self._tree.links.new(output, result.inputs[name])

    def _node(self, kind: str) -> Node:
        node = self._tree.nodes.new(kind)
        node.location = (200.0 * self._column, -160.0 * (self._column % 3))
        self._column += 1
        return node

    def _give(self, socket: NodeSocket, value: object) -> None:
        if isinstance(value, bpy.types.NodeSocket):
            self._tree.links.new(value, socket)
        else:
            socket.default_value = value

    def _math(self, operation: str, a: object, b: object) -> NodeSocket:
        node = self._node(_MATH)
        node.operation = operation
        self._give(node.inputs[0], a)
        self._give(node.inputs[1], b)
        return node.outputs[0]

    def _mix(self, blend_type: str, factor: object, a: object, b: object) -> NodeSocket:
        if _HAS_SHADER_NODES:
            node = self._node("ShaderNodeMix")
            node.data_type, node.clamp_factor = "RGBA", False
            inputs, output = [node.inputs[index] for index in (0, 6, 7)], node.outputs[2]
        else:
            node = self._node("CompositorNodeMixRGB")
            inputs, output = list(node.inputs), node.outputs[0]
        node.blend_type = blend_type
        for socket, value in zip(inputs, (factor, a, b), strict=True):
            self._give(socket, value)
        return output

    def _separate(self, colour: NodeSocket) -> list[NodeSocket]:
        node = self._node("CompositorNodeSeparateColor")
        self._tree.links.new(colour, node.inputs[0])
        return list(node.outputs)
