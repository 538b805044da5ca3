# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells datablocks apart, whether they are evaluated ones or originals.

A final render reads its scene while the window goes on: an object that is deleted there lives on as the evaluated one
of the render, whose ``original`` is gone. To ask for that crashes Blender: what tells objects and their collections is
asked of evaluated ones.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bpy.types import ID, Depsgraph

Name = tuple[str, str | None]  #: Of an object or a material, and the library that it is from.


def name_of(thing: ID) -> Name:
    """Of an object or a material, evaluated or not, as ``bpy.data.objects`` and ``bpy.data.materials`` take it."""
    return thing.name, thing.library.filepath if thing.library else None


def address_of(thing: ID, depsgraph: Depsgraph) -> int:
    """Of an evaluated datablock, the same in each read of a depsgraph.

    That of its original, which an undo leaves where it is; for a render, which sees no undo, its own.
    """
    return (thing if depsgraph.mode == "RENDER" else thing.original).as_pointer()
