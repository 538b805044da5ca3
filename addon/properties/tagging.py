# SPDX-License-Identifier: GPL-3.0-or-later
"""What every property of ours carries."""

from __future__ import annotations

from bpy.types import Context, PropertyGroup

#: Values changed on a library override survive a reload.
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
#: So do items that were added to a collection of one.
EXTENSIBLE = {"LIBRARY_OVERRIDABLE", "USE_INSERTION"}

_KEEPS_POINTERS = "tyndall_keeps_pointers"


def tag(_group: PropertyGroup, _context: Context) -> None:
    """Do nothing: a property with an ``update`` tags its owner when Python sets it, too; one without tags nothing."""


def tag_pointer(group: PropertyGroup, context: Context) -> None:
    """Of a property that points to a datablock, on an owner whose own settings never do: a light.

    Blender 5.0 looks for pointers to a deleted datablock only where it expects them, or where there are custom
    properties: without one, a light's pointer to a deleted object would dangle, and crash what reads it.
    """
    owner = group.id_data
    if not owner.get(_KEEPS_POINTERS):
        owner[_KEEPS_POINTERS] = True
    tag(group, context)
