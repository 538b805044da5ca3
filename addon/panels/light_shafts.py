# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: light shafts."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel


class TYNDALL_PT_light_shafts(PropertiesPanel, Panel):
    bl_label = "Light Shafts"
    bl_context = "render"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        shafts = context.scene.tyndall.shafts
        column = layout.column(align=True)
        column.prop(shafts, "method")
        column.prop(shafts, "viewport_method")
        column = layout.column(align=True)
        target = column.column(align=True)
        target.active = shafts.resolution == 0 and shafts.method != "EXACT"
        target.prop(shafts, "error_target")
        resolution = column.column(align=True)
        resolution.active = shafts.method != "EXACT"
        resolution.prop(shafts, "resolution")
        column = layout.column(align=True)
        column.prop(shafts, "light_samples")
        column.prop(shafts, "world_samples")
        column.prop(shafts, "adapts_strata")
        sharing = column.column(align=True)
        sharing.active = shafts.method != "EXACT"
        sharing.prop(shafts, "shares_strata")
        column = layout.column(align=True)
        column.prop(shafts, "grid_method")
        steps = column.column(align=True)
        steps.active = shafts.grid_method == "MARCH"
        steps.prop(shafts, "grid_error_target")
        layout.prop(shafts, "attenuates_light")
        layout.operator("tyndall.add_fog_box", icon="MOD_FLUIDSIM")


CLASSES = (TYNDALL_PT_light_shafts,)
