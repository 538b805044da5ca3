# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour: what holds the ways to colour shafts together, and whose they are, in the 3D view's sidebar."""

from __future__ import annotations

from bpy.types import Context, Panel

from . import gobo, light_map_fit, transfer_functions
from .base import SidebarPanel
from .light import draw_edited_light


class TYNDALL_PT_sidebar_colour(SidebarPanel, Panel):
    bl_label = "Colour the Shafts"

    def draw(self, context: Context) -> None:
        draw_edited_light(self.layout, context)


SIDEBAR_CLASSES = (
    TYNDALL_PT_sidebar_colour,
    *transfer_functions.SIDEBAR_CLASSES,
    *gobo.SIDEBAR_CLASSES,
    *light_map_fit.SIDEBAR_CLASSES,
)
