# SPDX-License-Identifier: GPL-3.0-or-later
"""AOV Output nodes, in the tree and in its groups: what a material puts into passes of its own, as in Cycles."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .node_graph import Socket
from .program import BLACK

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from bpy.types import Node, NodeTree

    from tyndall.scene_description import Material

    from .program import Value
    from .value_nodes import ValueReader


def read_aovs(
    values: ValueReader, tree: NodeTree, is_colour: Mapping[str, bool], material_name: str
) -> tuple[tuple[str, Material], ...]:
    """By name, programs of what the nodes are given, see Material.aovs; several nodes of one name add up."""
    sums: dict[str, Value] = {}
    for node, groups in _output_nodes(tree, ()):
        name = node.aov_name if hasattr(node, "aov_name") else node.name  # the node's own, before 4.0
        if name not in is_colour:
            continue
        wanted = "Color" if is_colour[name] else "Value"
        at = Socket(next(socket for socket in node.inputs if socket.identifier == wanted), groups)
        value = values.colour(at) if is_colour[name] else values.number(at)
        sums[name] = values.program.add(sums.get(name, BLACK), value)
    return tuple((name, values.program.material(material_name, (BLACK, BLACK, value))) for name, value in sums.items())


def _output_nodes(tree: NodeTree, groups: tuple[Node, ...]) -> Iterator[tuple[Node, tuple[Node, ...]]]:
    """And the group nodes around each, outermost first."""
    for node in tree.nodes:
        if node.mute:
            continue
        if node.type == "OUTPUT_AOV":
            yield node, groups
        elif node.type == "GROUP" and node.node_tree is not None:
            yield from _output_nodes(node.node_tree, (*groups, node))
