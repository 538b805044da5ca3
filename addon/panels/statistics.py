# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: what the last render did, what it skipped and why, and what it had to replace."""

from __future__ import annotations

from bpy.types import Context, Panel

from ..last_render import statistics_of
from .base import PropertiesPanel, draw_text

#: Longer lists are cut here and copied whole: a scene of thousands of materials must not make the panel slow.
REPORTS_SHOWN = 12


def duration_text(seconds: float) -> str:
    """Three digits of a duration, in the unit that suits it."""
    if seconds < 1.0:
        return f"{seconds * 1e3:.3g} ms"
    minutes, rest = divmod(seconds, 60)
    return f"{int(minutes)} min {rest:.0f} s" if minutes else f"{seconds:.3g} s"


class TYNDALL_PT_statistics(PropertiesPanel, Panel):
    bl_label = "Last Render"
    bl_context = "render"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and statistics_of(context.scene.name) is not None

    def draw(self, context: Context) -> None:
        layout = self.layout
        statistics = statistics_of(context.scene.name) or {}
        grid = layout.column(align=True)
        for stage in statistics.get("stages", ()):
            row = grid.split(factor=0.7)
            row.label(text=stage["name"].capitalize())
            row.label(text=duration_text(stage["seconds"]))
        for skipped in statistics.get("skipped", ()):
            draw_text(layout, context, f"Skipped {skipped['what']}: {skipped['reason']}", icon="REMOVE")
        reports = statistics.get("reports", ())
        for report in reports[:REPORTS_SHOWN]:
            draw_text(layout, context, report, icon="ERROR")
        if len(reports) > REPORTS_SHOWN:
            layout.label(text=f"... and {len(reports) - REPORTS_SHOWN} more", icon="BLANK1")
        layout.operator("tyndall.copy_reports", icon="COPYDOWN")


class TYNDALL_PT_counts(PropertiesPanel, Panel):
    bl_label = "Counts"
    bl_context = "render"
    bl_parent_id = "TYNDALL_PT_statistics"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        grid = self.layout.column(align=True)
        for name, value in sorted((statistics_of(context.scene.name) or {}).get("counts", {}).items()):
            row = grid.split(factor=0.7)
            row.label(text=name.capitalize())
            row.label(text=f"{value:,.6g}" if value % 1 else f"{int(value):,}")


CLASSES = (TYNDALL_PT_statistics, TYNDALL_PT_counts)
