# SPDX-License-Identifier: GPL-3.0-or-later
"""Why nothing renders, and what to do, in the first place where an artist looks."""

from __future__ import annotations

from bpy.types import Context, Panel

from ..availability import why_not
from .base import PropertiesPanel, draw_text


class TYNDALL_PT_unavailable(PropertiesPanel, Panel):
    bl_label = "Tyndall Cannot Render"
    bl_context = "render"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and why_not() is not None

    def draw(self, context: Context) -> None:
        draw_text(self.layout, context, why_not() or "", icon="ERROR")


CLASSES = (TYNDALL_PT_unavailable,)
