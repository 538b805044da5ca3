# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets' pop-over: those that we ship, then the user's own."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_ui.utils import PresetPanel
from bpy.types import Context, Panel

SHIPPED_PRESETS = Path(__file__).parents[1] / "presets" / "render"


class TYNDALL_PT_render_presets(PresetPanel, Panel):
    bl_label = "Tyndall Presets"
    preset_subdir = "tyndall/render"
    preset_operator = "script.execute_preset"
    preset_add_operator = "tyndall.render_preset_add"

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.emboss = "PULLDOWN_MENU"
        layout.operator_context = "EXEC_DEFAULT"
        column = layout.column(align=True)
        for preset in sorted(SHIPPED_PRESETS.glob("*.py")):
            properties = column.operator(self.preset_operator, text=bpy.path.display_name(preset.name))
            properties.filepath = str(preset)
            properties.menu_idname = type(self).__name__
        layout.separator()
        # Without a path to search, path_menu complains instead of offering to add a first preset.
        self.path_menu(
            bpy.utils.preset_paths(self.preset_subdir) or [str(SHIPPED_PRESETS.parent)],
            self.preset_operator,
            filter_ext=lambda extension: extension == ".py",
            add_operator=self.preset_add_operator,
        )


CLASSES = (TYNDALL_PT_render_presets,)
