# SPDX-License-Identifier: GPL-3.0-or-later
"""Take the statistics of the last render along, for a bug report or a comparison."""

from __future__ import annotations

import json

from bpy.types import Context, Operator

from ..last_render import statistics_of


class TYNDALL_OT_copy_reports(Operator):
    """Copy all statistics and reports of this scene's last render to the clipboard, as JSON."""

    bl_idname = "tyndall.copy_reports"
    bl_label = "Copy Statistics"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if statistics_of(context.scene.name) is None:
            cls.poll_message_set("Render this scene with Tyndall first")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        statistics = statistics_of(context.scene.name) or {}
        context.window_manager.clipboard = json.dumps(statistics, indent=2)
        self.report({"INFO"}, f"Copied statistics with {len(statistics.get('reports', ()))} reports")
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_copy_reports,)
