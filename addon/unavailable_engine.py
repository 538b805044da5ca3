# SPDX-License-Identifier: GPL-3.0-or-later
"""What answers for TYNDALL where the native core does not load: files keep their engine, and a render says why not."""

from __future__ import annotations

from bpy.types import Context, Depsgraph, RenderEngine
from bpy.utils import register_class, unregister_class

from .availability import why_not


class TyndallUnavailableEngine(RenderEngine):
    bl_idname = "TYNDALL"
    bl_label = "Tyndall"
    bl_use_shading_nodes_custom = False

    def render(self, _depsgraph: Depsgraph) -> None:
        # Without a delivered frame Blender crashes when the output is OpenEXR; without both calls it reports success.
        self.end_result(self.begin_result(0, 0, self.resolution_x, self.resolution_y))
        self.report({"ERROR"}, f"Tyndall cannot render: {why_not()}")
        self.error_set(f"Tyndall cannot render: {why_not()}")

    def view_update(self, _context: Context, _depsgraph: Depsgraph) -> None:
        """Blender calls it on every change; there is nothing to prepare."""

    def view_draw(self, _context: Context, _depsgraph: Depsgraph) -> None:
        self.update_stats("Tyndall cannot render", f"{why_not()}")


def register() -> None:
    register_class(TyndallUnavailableEngine)


def unregister() -> None:
    unregister_class(TyndallUnavailableEngine)
