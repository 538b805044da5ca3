# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render did, what it skipped and why, and what it had to replace."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from bpy.types import Context, Panel

from ..amounts import duration_text
from ..last_render import statistics_of
from .base import PropertiesPanel, SidebarPanel, draw_text, draw_value

#: Longer lists are cut here and copied whole: a scene of thousands of materials must not make the panel slow.
REPORTS_SHOWN = 12


def summed_stages(stages: Iterable[Mapping[str, Any]]) -> list[tuple[str, float]]:
    """Names and seconds; stages that each light or frame part goes through come as one, with their number."""
    seconds: dict[str, list[float]] = {}
    for stage in stages:
        seconds.setdefault(stage["name"], []).append(stage["seconds"])
    return [(f"{name} ({len(all_s)})" if len(all_s) > 1 else name, sum(all_s)) for name, all_s in seconds.items()]


def grouped_reports(reports: Iterable[str]) -> list[str]:
    """Reports that differ by the name of their culprit alone, as one that names the first."""
    names: dict[tuple[str, str], list[str]] = {}
    for report in reports:
        kind, *rest = re.split(r'("[^"]*")', report, maxsplit=1)
        name, note = rest or ("", "")
        names.setdefault((kind, note), []).append(name)
    return [
        f"{kind}{named[0]}" + (f" and {len(named) - 1} more" if len(named) > 1 else "") + note
        for (kind, note), named in names.items()
    ]


class _Statistics:
    bl_label = "Last Render"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and statistics_of(context.scene.name) is not None

    def draw(self, context: Context) -> None:
        layout = self.layout
        statistics = statistics_of(context.scene.name) or {}
        grid = layout.column(align=True)
        for name, seconds in summed_stages(statistics.get("stages", ())):
            draw_value(grid, context, name, duration_text(seconds))
        for skipped in statistics.get("skipped", ()):
            draw_text(layout, context, f"Skipped {skipped['what']}: {skipped['reason']}", icon="REMOVE")
        reports = grouped_reports(statistics.get("reports", ()))
        for report in reports[:REPORTS_SHOWN]:
            draw_text(layout, context, report, icon="ERROR")
        if len(reports) > REPORTS_SHOWN:
            layout.label(text=f"... and {len(reports) - REPORTS_SHOWN} more", icon="BLANK1")
        layout.operator("tyndall.copy_reports", icon="COPYDOWN")


class TYNDALL_PT_statistics(_Statistics, PropertiesPanel, Panel):
    bl_context = "render"


class TYNDALL_PT_counts(PropertiesPanel, Panel):
    bl_label = "Counts"
    bl_context = "render"
    bl_parent_id = "TYNDALL_PT_statistics"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        grid = self.layout.column(align=True)
        for name, value in sorted((statistics_of(context.scene.name) or {}).get("counts", {}).items()):
            draw_value(grid, context, name, f"{value:,.6g}" if value % 1 else f"{int(value):,}")


class TYNDALL_PT_sidebar_statistics(_Statistics, SidebarPanel, Panel):
    bl_parent_id = "TYNDALL_PT_sidebar_output"
    bl_options = {"DEFAULT_CLOSED"}


CLASSES = (TYNDALL_PT_statistics, TYNDALL_PT_counts)
SIDEBAR_CLASSES = (TYNDALL_PT_sidebar_statistics,)
