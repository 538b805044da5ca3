# SPDX-License-Identifier: GPL-3.0-or-later
"""Object properties: which rays see an object, and what a light lights."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel

SEEN_TYPES = frozenset({"MESH", "CURVE", "SURFACE", "META", "FONT", "EMPTY", "LIGHT"})


class TYNDALL_PT_ray_visibility(PropertiesPanel, Panel):
    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.object is not None and context.object.type in SEEN_TYPES

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        column, is_light = layout.column(), context.object.type == "LIGHT"
        if not is_light:
            column.prop(context.object, "visible_camera", text="Camera", toggle=False)
        column.prop(context.object, "visible_diffuse", text="Diffuse", toggle=False)
        column.prop(context.object, "visible_glossy", text="Glossy", toggle=False)
        column.prop(context.object, "visible_transmission", text="Transmission", toggle=False)
        column.prop(context.object, "visible_volume_scatter", text="Media", toggle=False)
        if not is_light:
            column.prop(context.object, "visible_shadow", text="Shadow", toggle=False)


CLASSES = (TYNDALL_PT_ray_visibility,)
