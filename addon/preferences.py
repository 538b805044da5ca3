# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's entry in the preferences: says whether it can render."""

from __future__ import annotations

from bpy.types import AddonPreferences, Context
from bpy.utils import register_class, unregister_class

from .availability import why_not
from .panels.base import draw_text


class TyndallPreferences(AddonPreferences):
    bl_idname = __package__

    def draw(self, context: Context) -> None:
        reason = why_not()
        if reason:
            draw_text(self.layout, context, f"Tyndall cannot render: {reason}", icon="ERROR")
        else:
            self.layout.label(text="Ready: choose Tyndall as render engine in the Render properties", icon="CHECKMARK")


def register() -> None:
    register_class(TyndallPreferences)


def unregister() -> None:
    unregister_class(TyndallPreferences)
