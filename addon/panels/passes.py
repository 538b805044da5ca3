# SPDX-License-Identifier: GPL-3.0-or-later
"""View layer properties: passes."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel


class TYNDALL_PT_passes(PropertiesPanel, Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        view_layer = context.view_layer
        column = layout.column(heading="Include", align=True)
        column.prop(view_layer, "use_pass_combined")
        column.prop(view_layer, "use_pass_z", text="Depth")
        column.prop(view_layer, "use_pass_position")
        column.prop(view_layer, "use_pass_normal")
        column = layout.column(heading="Light", align=True)
        column.prop(view_layer, "use_pass_diffuse_color", text="Diffuse Color")
        column.prop(view_layer, "use_pass_emit", text="Emission")
        column.prop(view_layer, "use_pass_shadow")
        column = layout.column(heading="Media", align=True)
        column.prop(view_layer.tyndall, "use_pass_shafts")
        column.prop(view_layer.tyndall, "use_pass_shafts_visibility")
        column.prop(view_layer.tyndall, "use_pass_transmittance")


CLASSES = (TYNDALL_PT_passes,)
