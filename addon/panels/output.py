# SPDX-License-Identifier: GPL-3.0-or-later
"""Output: how well final renders find the shafts, and what of them goes to the compositor, in the 3D view's sidebar.

The same settings stand in the Render and View Layer properties, where users of other engines look for them.
"""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import SidebarPanel, is_wide_region
from .light_shafts import draw_grids, draw_lens_steps, draw_light_samples, draw_methods
from .passes import draw_media_passes
from .presets import TYNDALL_PT_render_presets
from .statistics import SIDEBAR_CLASSES as STATISTICS_CLASSES


class TYNDALL_PT_sidebar_output(SidebarPanel, Panel):
    bl_label = "Output"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, _context: Context) -> None:
        TYNDALL_PT_render_presets.draw_panel_header(self.layout)

    def draw(self, context: Context) -> None:
        layout = self.layout
        column = layout.column(align=True)
        column.label(text="Passes for the compositor")
        draw_media_passes(column, context.view_layer)
        column = layout.column(align=True)
        column.operator("render.render", text="Render Image", icon="RENDER_STILL").use_viewport = True
        animation = column.operator("render.render", text="Render Animation", icon="RENDER_ANIMATION")
        animation.animation = animation.use_viewport = True


class TYNDALL_PT_sidebar_quality(SidebarPanel, Panel):
    bl_label = "Quality"
    bl_parent_id = "TYNDALL_PT_sidebar_output"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = is_wide_region(context)
        layout.use_property_decorate = False
        settings = context.scene.tyndall
        column = layout.column(align=True)
        column.prop(settings, "pixel_samples", text="Render Samples")
        column.prop(settings, "viewport_samples", text="Viewport")
        draw_methods(layout, settings.shafts, is_wide=is_wide_region(context))
        draw_light_samples(layout, settings.shafts)
        draw_grids(layout, settings.shafts, is_wide=is_wide_region(context))
        draw_lens_steps(layout, settings.shafts, context.scene.camera)


SIDEBAR_CLASSES = (TYNDALL_PT_sidebar_output, TYNDALL_PT_sidebar_quality, *STATISTICS_CLASSES)
