# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups of ours, in all versions of Blender: how they get sockets, and how they are known again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from bpy.types import Node, NodeTree

#: Custom property of nodes and node groups that the add-on made. Names are the artist's to change.
_PART = "tyndall_part"


def mark(owner: Node | NodeTree, part: str) -> None:
    """Say what ``owner`` is to us; copies, saving and appending take the mark along."""
    owner[_PART] = part


def part_of(owner: Node | NodeTree | None) -> str:
    """What it was marked as; empty for what is not ours."""
    return "" if owner is None else str(owner.get(_PART, ""))


def marked_group(part: str) -> NodeTree | None:
    """This file's own node group with a mark."""
    return next((tree for tree in bpy.data.node_groups if tree.library is None and part_of(tree) == part), None)


def add_socket(
    tree: NodeTree,
    name: str,
    kind: str,
    *,
    is_output: bool = False,
    default: object = None,
    limits: tuple[float, float] | None = None,
) -> None:
    """Append an input or output; ``kind`` as in ``NodeSocketFloat``."""
    if hasattr(tree, "interface"):  # Blender 4.0
        socket = tree.interface.new_socket(name, in_out="OUTPUT" if is_output else "INPUT", socket_type=kind)
    else:
        socket = (tree.outputs if is_output else tree.inputs).new(kind, name)
    if default is not None:
        socket.default_value = default
    if limits is not None:
        socket.min_value, socket.max_value = limits
