# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blender volume that shows baked air: a mark on its data tells that it is no medium of ours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from bpy.types import ID, Material, Object

_MARK = "tyndall_baked_air"


def is_baked_air(data: ID | None) -> bool:
    """Whether it is the data of a volume that shows what the texture of the air renders already."""
    return isinstance(data, bpy.types.Volume) and data.get(_MARK) is not None


def baked_volume(box: Object) -> Object | None:
    """The one that shows the box's air."""
    return next((child for child in box.children if is_baked_air(child.data)), None)


def new_baked_volume(box: Object, material: Material) -> Object:
    """Add one that goes wherever the box goes."""
    volume = bpy.data.volumes.new("Baked Air")
    volume[_MARK] = True
    volume.materials.append(material)
    thing = bpy.data.objects.new("Baked Air", volume)
    thing.parent = box
    (box.users_collection or (bpy.context.scene.collection,))[0].objects.link(thing)
    return thing
