# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint how a light's shafts should look, and fit its light map: in the 3D view's sidebar."""

from __future__ import annotations

from bpy.types import Context, Panel, UILayout, UIList

from ..edited_light import edited_light
from ..fitted_maps import residuals_of
from ..operators.light_map_fit import views_of, why_no_fit
from ..properties.light_map_fit import TyndallFitView, TyndallLightMapFit
from ..residual_plot import plot_of
from .base import SidebarPanel, draw_text, is_wide_region

#: Of the plot, in rows of the interface.
_PLOT_SCALE = 5.0


class TYNDALL_UL_fit_views(UIList):
    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        data: TyndallLightMapFit,
        item: TyndallFitView,
        icon: int,
        active_data: object,
        active_property: str,
    ) -> None:
        row = layout.row(align=True)
        row.active = item.is_enabled
        row.prop(item, "name", text="", emboss=False, icon="OUTLINER_OB_CAMERA" if item.camera else "ERROR")
        row.prop(item, "is_enabled", text="", icon="HIDE_OFF" if item.is_enabled else "HIDE_ON", emboss=False)


class TYNDALL_PT_light_map_fit(SidebarPanel, Panel):
    bl_label = "Paint the Shafts"
    bl_parent_id = "TYNDALL_PT_sidebar_colour"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        light = edited_light(context)
        if (reason := why_no_fit(light)) is not None:
            draw_text(layout, context, reason, icon="INFO")
            return
        settings = light.tyndall.light_map_fit
        row = layout.row()
        row.template_list("TYNDALL_UL_fit_views", "", settings, "views", settings, "active_view", rows=3)
        column = row.column(align=True)
        column.operator("tyndall.fit_view_add", text="", icon="ADD")
        column.operator("tyndall.fit_view_remove", text="", icon="REMOVE")
        column = layout.column()
        column.use_property_split = is_wide_region(context)
        if (view := views_of(light).active) is not None:
            column.prop(view, "camera", text="Camera" if is_wide_region(context) else "")
            column.prop(view, "strokes", text="Strokes" if is_wide_region(context) else "")
        layout.operator("tyndall.paint_strokes", icon="BRUSH_DATA")
        column = layout.column(align=True)
        column.use_property_split = is_wide_region(context)
        column.prop(settings, "resolution")
        column.prop(settings, "steps")
        column.prop(settings, "regularisation")
        row = layout.row(align=True)
        row.operator("tyndall.fit_light_map", text="Fit", icon=f"LIGHT_{light.type}")
        row.operator("tyndall.continue_light_map", icon="PLAY")
        draw_residuals(layout, context, residuals_of(light))


def draw_residuals(layout: UILayout, context: Context, residuals: list[float]) -> None:
    if not residuals:
        return
    layout.template_icon(plot_of(residuals), scale=_PLOT_SCALE)
    steps = len(residuals) - 1
    draw_text(layout, context, f"Error {residuals[0]:.1%} before, {residuals[-1]:.1%} after {steps} steps")


SIDEBAR_CLASSES = (TYNDALL_UL_fit_views, TYNDALL_PT_light_map_fit)
