# SPDX-License-Identifier: GPL-3.0-or-later
"""Animate: all that moves in the shafts over time in one list, in the 3D view's sidebar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.types import Context, Panel

from ..keyed_shafts import animated_properties
from .base import SidebarPanel, draw_text, is_wide_region

if TYPE_CHECKING:
    from bpy.types import UILayout

    from ..keyed_shafts import AnimatedProperty

#: More are in the Dope Sheet: a sidebar of a hundred fields helps nobody.
_PROPERTIES_SHOWN = 20
#: Of a narrow sidebar, beside a value.
_LETTERS_IN_FIELD = 14


def draw_time(layout: UILayout, context: Context) -> None:
    """Draw the present frame between the ways to the keys beside it."""
    row = layout.row(align=True)
    row.operator("tyndall.jump_to_key", text="", icon="PREV_KEYFRAME").direction = "PREVIOUS"
    row.prop(context.scene, "frame_current", text="Frame")
    row.operator("tyndall.jump_to_key", text="", icon="NEXT_KEYFRAME").direction = "NEXT"
    row.prop(context.tool_settings, "use_keyframe_insert_auto", text="", icon="REC")


def draw_animated(layout: UILayout, found: AnimatedProperty, frame: float, *, is_wide: bool) -> None:
    """Draw a property's value, in Blender's colours of what is keyed, and its key at this frame."""
    column = layout.column(align=True)
    row = column.row(align=True)
    if found.is_driven:
        row.label(text="", icon="DRIVER")
    else:
        icon = "KEYFRAME_HLT" if found.keys_at(frame) else "KEYFRAME"
        row.operator("tyndall.toggle_key", text="", icon=icon, emboss=False).identifier = found.identifier
    if found.is_array or (not is_wide and len(found.label) > _LETTERS_IN_FIELD):
        row.label(text=found.label)
        # Side by side in a narrow sidebar, numbers lose their units.
        values = column.row(align=True) if is_wide else column
        values.prop(found.holder, found.name, text="")
    else:
        row.prop(found.holder, found.name, text=found.label)


class TYNDALL_PT_sidebar_animate(SidebarPanel, Panel):
    bl_label = "Animate"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        draw_time(layout, context)
        column = layout.column(align=True)
        column.operator("tyndall.transfer_state_key", text="Key Colours", icon="COLOR")
        column.operator("tyndall.key_wind", icon="FORCE_WIND")
        column.operator("tyndall.loop_wind", icon="FILE_REFRESH")
        column.operator("tyndall.loop_holes", icon="MOD_NOISE")
        animated = animated_properties(context.scene)
        if not animated:
            draw_text(layout, context, "Nothing of the shafts is keyed: press I over any number, here or elsewhere")
        for found in animated[:_PROPERTIES_SHOWN]:
            draw_animated(layout, found, context.scene.frame_current, is_wide=is_wide_region(context))
        if len(animated) > _PROPERTIES_SHOWN:
            draw_text(layout, context, f"... and {len(animated) - _PROPERTIES_SHOWN} more, in the Dope Sheet")


SIDEBAR_CLASSES = (TYNDALL_PT_sidebar_animate,)
