# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air: in the 3D view's sidebar, and in the Render properties below the light shafts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.types import Context, Panel

from .base import PropertiesPanel, SidebarPanel, is_wide_region
from .presets import TYNDALL_PT_air_presets

if TYPE_CHECKING:
    from bpy.types import UILayout

    from ..properties.heterogeneity import TyndallHeterogeneity


def _settings(layout: UILayout, context: Context) -> TyndallHeterogeneity:
    """Those of the scene; prepares the layout for them."""
    settings: TyndallHeterogeneity = context.scene.tyndall.heterogeneity
    layout.use_property_split = is_wide_region(context)
    layout.active = settings.is_enabled
    return settings


class _Texture:
    bl_label = "Texture the Air"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.tyndall.heterogeneity, "is_enabled", text="")

    def draw_header_preset(self, _context: Context) -> None:
        TYNDALL_PT_air_presets.draw_panel_header(self.layout)

    def draw(self, context: Context) -> None:
        layout = self.layout
        settings = _settings(layout, context)
        column = layout.column(align=True)
        column.prop(settings, "amount")
        column.prop(settings, "intensity")
        column = layout.column(align=True)
        column.prop(settings, "scale_m")
        column.prop(settings, "contrast")
        column.prop(settings, "level")
        column = layout.column(align=True)
        column.prop(settings, "octaves")
        persistence = column.column(align=True)
        persistence.active = settings.octaves > 1
        persistence.prop(settings, "persistence")
        column.prop(settings, "seed")


class _Wind:
    bl_label = "Wind"

    def draw(self, context: Context) -> None:
        layout = self.layout
        settings = _settings(layout, context)
        column = layout.column()
        column.prop(settings, "wind_m_per_s", text="Wind")
        column.operator("tyndall.loop_wind", icon="FILE_REFRESH")
        layout.column().prop(settings, "offset_m", text="Offset")


class _Accuracy:
    bl_label = "Accuracy"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        settings = _settings(layout, context)
        is_wide = is_wide_region(context)
        column = layout.column(align=True)
        if not is_wide:
            column.label(text="Seen Along")
        column.prop(settings, "weighting", text="Seen Along" if is_wide else "")
        layout.prop(settings, "step_count")
        column = layout.column(align=True)
        for name, label in (("upsampling", "Resolution"), ("viewport_upsampling", "Viewport")):
            row = column if is_wide else column.row()
            if not is_wide:
                row.label(text=label)
            row.prop(settings, name, text=label if is_wide else "")


class _RenderTab(PropertiesPanel):
    bl_context = "render"


class TYNDALL_PT_render_heterogeneity(_Texture, _RenderTab, Panel):
    bl_parent_id = "TYNDALL_PT_light_shafts"


class TYNDALL_PT_render_heterogeneity_wind(_Wind, _RenderTab, Panel):
    bl_parent_id = "TYNDALL_PT_render_heterogeneity"


class TYNDALL_PT_render_heterogeneity_accuracy(_Accuracy, _RenderTab, Panel):
    bl_parent_id = "TYNDALL_PT_render_heterogeneity"


class TYNDALL_PT_heterogeneity(_Texture, SidebarPanel, Panel):
    pass


class TYNDALL_PT_heterogeneity_wind(_Wind, SidebarPanel, Panel):
    bl_parent_id = "TYNDALL_PT_heterogeneity"
    bl_order = 1  # after what else belongs to the texture: what is painted


class TYNDALL_PT_heterogeneity_accuracy(_Accuracy, SidebarPanel, Panel):
    bl_parent_id = "TYNDALL_PT_heterogeneity"
    bl_order = 2


CLASSES = (
    TYNDALL_PT_render_heterogeneity,
    TYNDALL_PT_render_heterogeneity_wind,
    TYNDALL_PT_render_heterogeneity_accuracy,
)
SIDEBAR_CLASSES = (
    TYNDALL_PT_heterogeneity,
    TYNDALL_PT_heterogeneity_wind,
    TYNDALL_PT_heterogeneity_accuracy,
)
