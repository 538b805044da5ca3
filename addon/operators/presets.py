# SPDX-License-Identifier: GPL-3.0-or-later
"""Save and remove presets of the render settings."""

from __future__ import annotations

from typing import ClassVar

from bl_operators.presets import AddPresetBase
from bpy.types import Operator


class TYNDALL_OT_render_preset_add(AddPresetBase, Operator):
    """Save the sampling and light shaft settings as a preset, or remove one."""

    bl_idname = "tyndall.render_preset_add"
    bl_label = "Add Tyndall Preset"
    preset_menu = "TYNDALL_PT_render_presets"
    preset_subdir = "tyndall/render"
    preset_defines: ClassVar = ["settings = bpy.context.scene.tyndall"]
    preset_values: ClassVar = [
        "settings.pixel_samples",
        "settings.noise_threshold",
        "settings.viewport_samples",
        "settings.pixel_filter",
        "settings.filter_width_px",
        "settings.shafts.method",
        "settings.shafts.viewport_method",
        "settings.shafts.error_target",
        "settings.shafts.resolution",
        "settings.shafts.light_samples",
        "settings.shafts.world_samples",
        "settings.shafts.attenuates_light",
        "settings.shafts.adapts_strata",
        "settings.shafts.shares_strata",
    ]


CLASSES = (TYNDALL_OT_render_preset_add,)
