# SPDX-License-Identifier: GPL-3.0-or-later
"""Object properties: which rays see an object."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel

GEOMETRY_TYPES = frozenset({"MESH", "CURVE", "SURFACE", "META", "FONT", "EMPTY"})


class TYNDALL_PT_ray_visibility(PropertiesPanel, Panel):
    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.object is not None and context.object.type in GEOMETRY_TYPES

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        column = layout.column()
        column.prop(context.object, "visible_camera", text="Camera", toggle=False)
        column.prop(context.object, "visible_shadow", text="Shadow", toggle=False)


CLASSES = (TYNDALL_PT_ray_visibility,)
