# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint the air: in the 3D view's sidebar, below its texture."""

from __future__ import annotations

from bpy.types import Context, Panel, UILayout

from ..air_painting import active_painting
from ..operators.paint_air import why_no_paint
from ..operators.painted_air import memory_text
from ..operators.volume_files import draw_buttons
from ..painted_air import edited_box, why_not_editable
from ..properties.air_brush import VALUED_MODES
from .base import SidebarPanel, draw_text, is_wide_region


class TYNDALL_PT_paint_air(SidebarPanel, Panel):
    bl_label = "Paint the Air"
    bl_parent_id = "TYNDALL_PT_heterogeneity"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.prop(context.scene.tyndall.heterogeneity, "painted", text="")
        box = edited_box(context)
        if box is None:
            layout.operator("tyndall.add_painted_box", icon="CUBE")
            return
        if (reason := why_not_editable(box)) is not None:
            draw_text(layout, context, reason, icon="ERROR")
            return
        if active_painting() is not None:
            draw_text(layout, context, "Painting. Esc in the view ends it", icon="INFO")
        layout.operator("tyndall.paint_air", icon="BRUSH_DATA")
        draw_brush(layout, context)


def draw_brush(layout: UILayout, context: Context) -> None:
    """Draw the brush's settings: in the sidebar, and in the tool's."""
    brush = context.scene.tyndall.air_brush
    is_wide = is_wide_region(context)
    column = layout.column()
    column.use_property_split = is_wide
    choice = column.row(align=True) if is_wide else column.column(align=True)
    choice.prop(brush, "volume", expand=True)
    column.prop(brush, "mode", text="Brush" if is_wide else "")
    column = layout.column(align=True)
    column.use_property_split = is_wide
    if brush.mode in VALUED_MODES:
        column.prop(brush, brush.volume.lower())
    for name, pressure in (
        ("radius_m", "pressure_sizes"),
        ("depth", ""),
        ("opacity", "pressure_fades"),
        ("hardness", ""),
    ):
        row = column.row(align=True)
        row.prop(brush, name)
        if pressure:
            row.prop(brush, pressure, text="", icon="STYLUS_PRESSURE")
    layout.prop(brush, "shows_paint")


class TYNDALL_PT_painted_volumes(SidebarPanel, Panel):
    bl_label = "Painted Volumes"
    bl_parent_id = "TYNDALL_PT_paint_air"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and edited_box(context) is not None

    def draw(self, context: Context) -> None:
        layout = self.layout
        settings = edited_box(context).tyndall.painted_air
        column = layout.column()
        column.active = why_no_paint(context) is None
        column.prop(settings, "resolution")
        draw_text(column, context, memory_text(settings.resolution))
        for name in ("intensity", "amount", "level"):
            volume = getattr(settings, name)
            count = len(volume.tiles)
            column.label(
                text=f"{settings.bl_rna.properties[name].name}: {f'{count} tiles' if count else 'not painted'}",
                icon="CHECKMARK" if count else "BLANK1",
            )
        row = layout.row(align=True)
        row.operator("tyndall.painted_air_fill")
        row.operator("tyndall.painted_air_clear")
        row = layout.row(align=True)
        row.operator("tyndall.painted_air_flip")
        row.operator("tyndall.painted_air_resample")
        layout.operator("tyndall.painted_air_bake")
        draw_buttons(layout)


CLASSES = (TYNDALL_PT_paint_air, TYNDALL_PT_painted_volumes)
