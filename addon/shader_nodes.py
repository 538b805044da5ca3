# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader node trees as all versions of Blender have them."""

from __future__ import annotations

import bpy
from bpy.types import Material, Node, NodeTree, Object, ShaderNodeTree, World

#: Mark of the group that hides a medium from the camera of another engine; ours sees through it.
LEFT_TO_SHAFTS = "LEFT_TO_SHAFTS"

ALWAYS_HAS_NODES = bpy.app.version >= (5, 0, 0)  # there, even reading use_nodes warns that it goes away


def shader_tree(owner: Material | World | None) -> ShaderNodeTree | None:
    """Nodes of a material or a world; None where it does without."""
    return owner.node_tree if owner and (ALWAYS_HAS_NODES or owner.use_nodes) else None


def nodes_within(tree: NodeTree | None) -> list[Node]:
    """Those of a tree and of all groups in it, of each group once."""
    nodes: list[Node] = []
    met: set[int] = set()
    waiting = [tree]
    while waiting:
        one = waiting.pop()
        if one is None or one.as_pointer() in met:
            continue
        met.add(one.as_pointer())
        nodes += one.nodes
        waiting += [node.node_tree for node in one.nodes if node.type == "GROUP"]
    return nodes


def use_nodes(owner: Material | World) -> ShaderNodeTree:
    """Switch nodes on where there is a choice."""
    if not ALWAYS_HAS_NODES:
        owner.use_nodes = True
    return owner.node_tree


def plugged_in(owner: Material | World | None, socket_name: str) -> Node | None:
    """Find the node that feeds ``Surface`` or ``Volume`` of the output that Cycles, and so we, render."""
    tree = shader_tree(owner)
    output = tree.get_output_node("CYCLES") if tree else None
    links = output.inputs[socket_name].links if output else ()
    return links[0].from_node if links else None


def is_fed_by_nodes(node: Node) -> bool:
    """Whether any of its values may vary."""
    return any(socket.is_linked for socket in node.inputs)


def is_medium_only(owner: Object) -> bool:
    """Whether all of an object's materials are media without a surface."""
    materials = [slot.material for slot in owner.material_slots]
    return bool(materials) and all(
        plugged_in(material, "Volume") and not plugged_in(material, "Surface") for material in materials
    )
