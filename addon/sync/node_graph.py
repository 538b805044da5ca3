# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader node trees as one flat graph: links followed through groups, reroutes and muted nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

from ..node_groups import part_of
from ..shader_nodes import LEFT_TO_SHAFTS

if TYPE_CHECKING:
    from bpy.types import Node, NodeSocket, NodeTree

#: Types of nodes that Cycles does not know: their links are as if they were not there.
LEFT_OUT = {"SHADERTORGB", "SQUEEZE"}
#: Blender hands Cycles trees without groups and reroutes: what such a node feeds through them is not linked, either,
#: nor what a reroute without a source feeds.
_LINKS_SKIP_GROUPS = bpy.app.version >= (5, 0, 0)
_MAX_STEPS = 1000  #: Links followed in a row; a loop ends here, and counts as unconnected.


@dataclass(frozen=True)
class Socket:
    """A socket and the group nodes that one entered to reach its tree, outermost first."""

    socket: NodeSocket
    groups: tuple[Node, ...] = ()

    @property
    def node(self) -> Node:
        return self.socket.node

    def input(self, name: str) -> Socket | None:
        """An input of this socket's node by identifier, which no language changes; None in a version without it."""
        for socket in self.node.inputs:
            if socket.identifier == name and not socket.is_unavailable:
                return Socket(socket, self.groups)
        return None

    def inputs(self) -> list[Socket]:
        return [Socket(socket, self.groups) for socket in self.node.inputs if not socket.is_unavailable]

    def is_connected(self) -> bool:
        return self.source().socket.is_output

    def is_bare_shader(self) -> bool:
        """Whether no shader feeds a source: black. A colour that a group is given in its place glows, as in Cycles."""
        return not self.socket.is_output and self.socket.type == "SHADER"

    def source(self) -> Socket:
        """What feeds this input: an output of a node that computes, or the input whose own value counts."""
        return self.path()[-1]

    def path(self) -> list[Socket]:
        """From here to the source, over borders of groups, reroutes and muted nodes: each may be of another type."""
        return self.traced()[0]

    def traced(self) -> tuple[list[Socket], Node | None]:
        """The path, and the node that would feed it, had Cycles not left it out."""
        path = [self]
        for _ in range(_MAX_STEPS):
            following = _step(path[-1])
            if following is None:
                is_loose = _LINKS_SKIP_GROUPS and path[-1].node.type == "REROUTE"
                return [self] if is_loose else path[: _ends_at(path)], None
            if following.socket.is_output and following.node.type in LEFT_OUT and not following.node.mute:
                return [self] if _LINKS_SKIP_GROUPS else path, following.node
            path.append(following)
        return [self], None


def _ends_at(path: list[Socket]) -> int:
    """Where a way ends at a muted node which lets nothing pass, the last input on it counts."""
    end = len(path)
    if path[-1].socket.is_output and path[-1].node.mute:
        while end > 1 and path[end - 1].socket.is_output:
            end -= 1
    return end


def output_input(tree: NodeTree | None, name: str) -> Socket | None:
    """The input of the tree's active output for Cycles; None without one, or where a script disabled the socket."""
    output = tree and tree.get_output_node("CYCLES")
    socket = output and output.inputs.get(name)
    return Socket(socket) if socket and socket.enabled else None


def _step(at: Socket) -> Socket | None:
    """One link, group border, reroute or muted node further up; None where something computes or has a value."""
    if not at.socket.is_output:
        # As Cycles, past links that Blender calls invalid: of a shader to a colour, or in a circle.
        links = [link for link in at.socket.links if link.is_valid and not link.is_muted]
        return Socket(links[0].from_socket, at.groups) if links else None
    node = at.node
    if node.mute:
        return _through_muted(at)
    if node.type == "REROUTE" or _is_left_to_us(node):
        return Socket(node.inputs[0], at.groups)
    if node.type == "GROUP" and node.node_tree:
        return _into_group(at)
    if node.type == "GROUP_INPUT" and at.groups:
        *outer, group = at.groups
        inputs = [socket for socket in group.inputs if socket.identifier == at.socket.identifier]
        return Socket(inputs[0], tuple(outer)) if inputs else None
    return None


def _is_left_to_us(node: Node) -> bool:
    """Whether it hides a medium from another engine's camera."""
    return bool(node.type == "GROUP" and part_of(node.node_tree) == LEFT_TO_SHAFTS)


def _through_muted(at: Socket) -> Socket | None:
    for link in at.node.internal_links:
        if link.to_socket == at.socket:
            return Socket(link.from_socket, at.groups)
    return None


def _into_group(at: Socket) -> Socket | None:
    outputs = [node for node in at.node.node_tree.nodes if isinstance(node, bpy.types.NodeGroupOutput)]
    active = [node for node in outputs if node.is_active_output] or outputs
    for socket in active[0].inputs if active else ():
        if socket.identifier == at.socket.identifier:
            return Socket(socket, (*at.groups, at.node))
    return None
