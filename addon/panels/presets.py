# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets' pop-overs: those that we ship, then the user's own."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_ui.utils import PresetPanel
from bpy.types import Context, Panel

SHIPPED_PRESETS = Path(__file__).parents[1] / "presets"


def shipped_presets(panel: type[ShippedPresetPanel]) -> list[Path]:
    """In the order in which the pop-over shows them."""
    return sorted((SHIPPED_PRESETS / Path(panel.preset_subdir).name).glob("*.py"))


class ShippedPresetPanel(PresetPanel):
    """Of ``preset_subdir`` "tyndall/x", those that we ship lie in addon/presets/x."""

    preset_subdir: str
    preset_add_operator: str
    preset_operator = "tyndall.preset_apply"  # Blender's own cannot be undone

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.emboss = "PULLDOWN_MENU"
        layout.operator_context = "EXEC_DEFAULT"
        column = layout.column(align=True)
        for preset in shipped_presets(type(self)):
            name = bpy.path.display_name(preset.name)
            column.operator(self.preset_operator, text=name).filepath = str(preset)
        layout.separator()
        # Without a path to search, path_menu complains instead of offering to add a first preset.
        self.path_menu(
            bpy.utils.preset_paths(self.preset_subdir) or [str(SHIPPED_PRESETS)],
            self.preset_operator,
            filter_ext=lambda extension: extension == ".py",
            add_operator=self.preset_add_operator,
        )


class TYNDALL_PT_render_presets(ShippedPresetPanel, Panel):
    bl_label = "Tyndall Presets"
    preset_subdir = "tyndall/render"
    preset_add_operator = "tyndall.render_preset_add"


class TYNDALL_PT_air_presets(ShippedPresetPanel, Panel):
    bl_label = "Air Presets"
    preset_subdir = "tyndall/air"
    preset_add_operator = "tyndall.air_preset_add"


CLASSES = (TYNDALL_PT_render_presets, TYNDALL_PT_air_presets)
