# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object's shadow terminator is not where Blender puts it by default, as ours always is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from bpy.types import Object

    from .reports import Reports

NOTE = "its shadow terminator has Blender's usual offsets: 0.1 for geometry, 0 for shading"
#: Up to 3.x Cycles' own properties.
_IS_OBJECTS = "shadow_terminator_shading_offset" in bpy.types.Object.bl_rna.properties
_SHADING = "shadow_terminator_shading_offset" if _IS_OBJECTS else "shadow_terminator_offset"
_GEOMETRY = "shadow_terminator_geometry_offset"
_ROUNDING = 1e-6


def note_terminator(thing: Object, reports: Reports) -> None:
    """Of an evaluated object with a mesh."""
    holder = thing if _IS_OBJECTS else getattr(thing, "cycles", None)
    if holder is None:  # Cycles is switched off
        return
    if abs(getattr(holder, _GEOMETRY) - 0.1) > _ROUNDING or getattr(holder, _SHADING) > _ROUNDING:
        reports.add(f'Object "{thing.name}"', NOTE)
