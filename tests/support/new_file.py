# SPDX-License-Identifier: GPL-3.0-or-later
"""A new file for each test."""

from __future__ import annotations

import bpy


def new_file(*, is_empty: bool = False) -> bpy.types.Scene:
    """Blender's factory scene, or one with nothing in it.

    The preferences, which no test changes, stay: with them Blender reads all its own add-ons again, which takes as long
    as many a test.
    """
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=is_empty)
    return bpy.context.scene
