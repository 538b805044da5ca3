# SPDX-License-Identifier: GPL-3.0-or-later
"""What every property of ours carries."""

from __future__ import annotations

from bpy.types import Context, PropertyGroup

#: Values changed on a library override survive a reload.
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}


def tag(_group: PropertyGroup, _context: Context) -> None:
    """Do nothing: a property with an ``update`` tags its owner when Python sets it, too; one without tags nothing."""
