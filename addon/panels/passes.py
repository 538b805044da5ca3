# SPDX-License-Identifier: GPL-3.0-or-later
"""View layer properties: passes."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from bpy.types import Context, Panel

from .. import denoising
from ..light_passes import LIGHT_PASSES
from .base import PropertiesPanel, draw_text

if TYPE_CHECKING:
    from bpy.types import UILayout, ViewLayer


def draw_media_passes(column: UILayout, view_layer: ViewLayer) -> None:
    """Draw the switches of the passes that only media have."""
    column.prop(view_layer.tyndall, "use_pass_shafts")
    column.prop(view_layer.tyndall, "use_pass_shafts_visibility")
    column.prop(view_layer.tyndall, "use_pass_transmittance")


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
        column.prop(view_layer, "use_pass_mist")
        row = column.row()
        row.active = not context.scene.render.use_motion_blur
        row.prop(view_layer, "use_pass_vector")
        column.prop(view_layer, "use_pass_uv")
        column.prop(view_layer.tyndall, "use_pass_sample_count")
        column.prop(view_layer.tyndall, "use_pass_denoising_data")
        column = layout.column(heading="Indexes", align=True)
        column.prop(view_layer, "use_pass_object_index")
        column.prop(view_layer, "use_pass_material_index")
        layout.column().prop(view_layer, "pass_alpha_threshold")
        for kind, passes in groupby(LIGHT_PASSES, lambda each: each.kind):
            column = layout.column(heading=kind, align=True)
            for each in passes:
                column.prop(view_layer, each.switch, text=each.part)
        column = layout.column(heading="Light", align=True)
        column.prop(view_layer, "use_pass_emit", text="Emission")
        column.prop(view_layer, "use_pass_environment")
        column.prop(view_layer, "use_pass_shadow")
        column.prop(view_layer, "use_pass_ambient_occlusion", text="Ambient Occlusion")
        column.prop(view_layer.tyndall, "use_pass_shadow_catcher")
        column = layout.column(heading="Media", align=True)
        if hasattr(view_layer, "cycles"):
            column.prop(view_layer.cycles, "use_pass_volume_direct")
        draw_media_passes(column, view_layer)
        column = layout.column(heading="Cryptomatte", align=True)
        column.prop(view_layer, "use_pass_cryptomatte_object", text="Object")
        column.prop(view_layer, "use_pass_cryptomatte_material", text="Material")
        column.prop(view_layer, "use_pass_cryptomatte_asset", text="Asset")
        column = layout.column()
        kinds = ("object", "material", "asset")
        column.active = any(getattr(view_layer, f"use_pass_cryptomatte_{kind}") for kind in kinds)
        column.prop(view_layer, "pass_cryptomatte_depth", text="Levels")


class TYNDALL_PT_passes_denoising(PropertiesPanel, Panel):
    bl_label = "Denoise"
    bl_context = "view_layer"
    bl_parent_id = "TYNDALL_PT_passes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        reason = denoising.why_not(context.scene)
        if reason is not None:
            draw_text(layout, context, reason, icon="INFO")
        layout.operator("tyndall.denoising_set_up", icon="NODE_COMPOSITING")
        if denoising.nodes_of(context.scene):
            layout.operator("tyndall.denoising_remove", icon="X")


class TYNDALL_PT_passes_aov(PropertiesPanel, Panel):
    bl_label = "Shader AOV"
    bl_context = "view_layer"
    bl_parent_id = "TYNDALL_PT_passes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        view_layer = context.view_layer
        row = self.layout.row()
        row.template_list("VIEWLAYER_UL_aov", "aovs", view_layer, "aovs", view_layer, "active_aov_index", rows=3)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_aov", icon="ADD", text="")
        column.operator("scene.view_layer_remove_aov", icon="REMOVE", text="")
        aov = view_layer.active_aov
        if aov is not None and not aov.is_valid:
            self.layout.label(text="Conflicts with another render pass with the same name", icon="ERROR")


CLASSES = (TYNDALL_PT_passes, TYNDALL_PT_passes_denoising, TYNDALL_PT_passes_aov)
