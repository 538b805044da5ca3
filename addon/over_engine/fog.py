# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog that is left to the light shafts: the scene's engine must not draw it a second time.

A node group before the output's Volume hides the medium from camera rays only. In Cycles it still dims the light on its
way to surfaces, so that these are as bright as fog makes them; the light shafts bring the rest. Ours reads through it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..node_groups import add_socket, mark, marked_group, part_of
from ..shader_nodes import LEFT_TO_SHAFTS, plugged_in, shader_tree

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Context, Material, Node, NodeTree, World


def media_owners(context: Context) -> list[Material | World]:
    """Materials and world with a medium, of all that the scene's evaluation draws on."""
    used = {datablock.original for datablock in context.evaluated_depsgraph_get().ids}
    owners = [owner for owner in (*bpy.data.materials, *bpy.data.worlds) if owner in used]
    return [owner for owner in owners if plugged_in(owner, "Volume") is not None]


def doubled(context: Context) -> list[Material | World]:
    """Those whose medium the scene's engine and the light shafts would both draw."""
    return [owner for owner in media_owners(context) if not _is_left(owner)]


def leave_to_shafts(owner: Material | World) -> None:
    """Hide its medium from the camera of the scene's engine."""
    tree = owner.node_tree
    socket = tree.get_output_node("CYCLES").inputs["Volume"]
    source = socket.links[0].from_socket
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = _group()
    node.name = node.label = "Left to Light Shafts"
    node.location = socket.node.location.x - 20.0, socket.node.location.y - 180.0
    tree.links.new(source, node.inputs[0])
    tree.links.new(node.outputs[0], socket)
    mute()


def take_back_all() -> None:
    """Remove every such group of this file; its medium is linked as it was."""
    for tree, node in list(left_nodes()):
        if node.inputs[0].is_linked:
            for link in list(node.outputs[0].links):
                tree.links.new(node.inputs[0].links[0].from_socket, link.to_socket)
        tree.nodes.remove(node)


def mute() -> None:
    """Where no scene shows light shafts over its picture, fog is the engines' own."""
    is_shown = any(scene.tyndall.over_engine.is_enabled for scene in bpy.data.scenes)
    for _, node in left_nodes():
        if node.mute != (not is_shown):
            node.mute = not is_shown


def _is_left(owner: Material | World) -> bool:
    node = plugged_in(owner, "Volume")
    return node is not None and node.type == "GROUP" and part_of(node.node_tree) == LEFT_TO_SHAFTS and not node.mute


def left_nodes() -> Iterator[tuple[NodeTree, Node]]:
    for owner in (*bpy.data.materials, *bpy.data.worlds):
        tree = shader_tree(owner)
        for node in () if tree is None or owner.library is not None else tree.nodes:
            if node.type == "GROUP" and part_of(node.node_tree) == LEFT_TO_SHAFTS:
                yield tree, node


def _group() -> NodeTree:
    """This file's, made where there is none: nothing for camera rays, the medium for all others."""
    tree = marked_group(LEFT_TO_SHAFTS)
    if tree is not None:
        return tree
    tree = bpy.data.node_groups.new("Left to Light Shafts", "ShaderNodeTree")
    mark(tree, LEFT_TO_SHAFTS)
    add_socket(tree, "Volume", "NodeSocketShader")
    add_socket(tree, "Volume", "NodeSocketShader", is_output=True)
    given, result = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    ray, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMixShader")
    for column, node in enumerate((ray, given, mix, result)):
        node.location = (220.0 * (column - 1), 180.0 if node == ray else 0.0)
    tree.links.new(ray.outputs["Is Camera Ray"], mix.inputs[0])
    tree.links.new(given.outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], result.inputs[0])
    return tree
