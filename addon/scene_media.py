# SPDX-License-Identifier: GPL-3.0-or-later
"""Which materials are media, and what their nodes say of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .shader_nodes import plugged_in

if TYPE_CHECKING:
    from bpy.types import Material, Node, NodeSocket, Object, Scene


def media_materials() -> list[Material]:
    """Materials in use whose volume is plugged in, by name. A file has few; its objects may be 100,000."""
    return [material for material in bpy.data.materials if material.users and plugged_in(material, "Volume")]


def objects_of(scene: Scene, material: Material) -> list[Object]:
    """Those of the scene that have this material in a slot."""
    return [thing for thing in scene.objects if any(slot.material == material for slot in thing.material_slots)]


def fills_grids(material: Material) -> bool:
    """Whether a Volume has it: what its nodes say is multiplied with a grid there."""
    return any(material in volume.materials.values() for volume in bpy.data.volumes)


def own_value(node: Node, name: str) -> NodeSocket | None:
    """A node's input that it has, and no link overrules."""
    socket = node.inputs.get(name)
    return None if socket is None or socket.is_linked else socket
