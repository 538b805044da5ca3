# SPDX-License-Identifier: GPL-3.0-or-later
"""The brush for the air in the 3D view's toolbar: the first press in the view begins to paint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.types import WorkSpaceTool

from .properties.air_brush import VALUED_MODES

if TYPE_CHECKING:
    from bpy.types import Context, UILayout

NAME = "tyndall.paint_air_tool"


class TyndallPaintAirTool(WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = NAME
    bl_label = "Paint the Air"
    bl_description = "Paint where light shafts are brighter, dimmer, more or less textured"
    bl_icon = "brush.sculpt.paint"
    bl_keymap = (
        (
            "tyndall.paint_air",
            {"type": "LEFTMOUSE", "value": "PRESS", "any": True},
            {"properties": [("begins_stroke", True)]},
        ),
    )

    def draw_settings(context: Context, layout: UILayout, _tool: object) -> None:  # noqa: N805  how Blender calls it
        if context.scene.tyndall.heterogeneity.painted is None:
            layout.operator("tyndall.add_painted_box", icon="CUBE")
        brush = context.scene.tyndall.air_brush
        layout.prop(brush, "volume", text="")
        layout.prop(brush, "mode", text="")
        if brush.mode in VALUED_MODES:
            layout.prop(brush, brush.volume.lower())
        for name in ("radius_m", "depth", "opacity", "hardness"):
            layout.prop(brush, name)


def register() -> None:
    # While a background Blender 3.4 starts, there are no keymaps, to which a tool adds its own: nor is there a toolbar.
    if bpy.context.window_manager.keyconfigs.default is not None:
        bpy.utils.register_tool(TyndallPaintAirTool, after={"builtin.measure"}, separator=True)


def unregister() -> None:
    if hasattr(TyndallPaintAirTool, "_bl_tool"):  # Blender's, of a tool that is registered
        bpy.utils.unregister_tool(TyndallPaintAirTool)
