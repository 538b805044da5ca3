# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: what surfaces see of the world and of one another."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel


class TYNDALL_PT_indirect(PropertiesPanel, Panel):
    bl_label = "Indirect Light"
    bl_context = "render"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.tyndall.indirect
        has_pass = context.view_layer.use_pass_ambient_occlusion
        column = layout.column(align=True)
        column.prop(settings, "has_ambient_occlusion")
        row = column.row()
        row.active = settings.has_ambient_occlusion
        row.prop(settings, "ambient_distance_m")
        row = column.row()
        row.active = has_pass
        row.prop(settings, "ambient_samples")
        column = layout.column(align=True)
        column.prop(settings, "has_bounce")
        row = column.row()
        row.active = settings.has_bounce
        row.prop(settings, "bounce_samples")
        column = layout.column(align=True)
        column.prop(settings, "has_mirrors")
        mirrors = column.column(align=True)
        mirrors.active = settings.has_mirrors
        mirrors.prop(settings, "mirror_depth")
        mirrors.prop(settings, "mirror_roughness")
        mirrors.prop(settings, "has_refraction")
        row = mirrors.row()
        row.active = settings.has_refraction
        row.prop(settings, "refraction_depth")


CLASSES = (TYNDALL_PT_indirect,)
