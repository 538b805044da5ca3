# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: samples, pixel filter, and how finely voxels are seen."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel
from .presets import TYNDALL_PT_render_presets


class TYNDALL_PT_sampling(PropertiesPanel, Panel):
    bl_label = "Sampling"
    bl_context = "render"

    def draw_header_preset(self, _context: Context) -> None:
        TYNDALL_PT_render_presets.draw_panel_header(self.layout)

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.tyndall
        column = layout.column(align=True)
        column.prop(settings, "pixel_samples", text="Render Samples")
        column.prop(settings, "noise_threshold")
        column.prop(settings, "viewport_samples", text="Viewport")
        column.prop(settings, "shows_viewport_work", text="Timings in Viewport")
        row = layout.row(align=True)
        row.prop(settings, "seed")
        row.use_property_decorate = True


class TYNDALL_PT_pixel_filter(PropertiesPanel, Panel):
    bl_label = "Pixel Filter"
    bl_context = "render"
    bl_parent_id = "TYNDALL_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.tyndall
        layout.prop(settings, "pixel_filter")
        layout.prop(settings, "filter_width_px")


class TYNDALL_PT_voxel_sampling(PropertiesPanel, Panel):
    bl_label = "Voxels"
    bl_context = "render"
    bl_parent_id = "TYNDALL_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(context.scene.tyndall, "voxel_detail_px")


CLASSES = (TYNDALL_PT_sampling, TYNDALL_PT_pixel_filter, TYNDALL_PT_voxel_sampling)
