# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport's shading menu: which pass it shows."""

from __future__ import annotations

from bpy.types import Context, Panel, SpaceView3D

from .base import ENGINE


class TYNDALL_PT_viewport_render_pass(Panel):
    bl_label = "Render Pass"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_parent_id = "VIEW3D_PT_shading"

    @classmethod
    def poll(cls, context: Context) -> bool:
        space = context.space_data
        return context.engine == ENGINE and isinstance(space, SpaceView3D) and space.shading.type == "RENDERED"

    def draw(self, context: Context) -> None:
        self.layout.prop(context.space_data.shading.tyndall, "render_pass", text="")


CLASSES = (TYNDALL_PT_viewport_render_pass,)
