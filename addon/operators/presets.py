# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply, save and remove presets: of the render settings, and of the texture of the air."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import bpy
from bl_operators.presets import AddPresetBase
from bpy.props import StringProperty
from bpy.types import Context, Operator


class TYNDALL_OT_preset_apply(Operator):
    """Set what this preset sets; the rest stays as it is."""

    bl_idname = "tyndall.preset_apply"
    bl_label = "Apply Preset"
    bl_options = {"UNDO"}

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})

    def execute(self, context: Context) -> set[str]:
        try:
            bpy.utils.execfile(self.filepath)
        except Exception as error:  # noqa: BLE001  whatever somebody wrote into their file
            self.report({"ERROR"}, f'The preset "{bpy.path.display_name(Path(self.filepath).name)}" fails: {error}')
        context.scene.update_tag()
        return {"FINISHED"}


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
        "settings.voxel_detail_px",
        "settings.shafts.method",
        "settings.shafts.viewport_method",
        "settings.shafts.error_target",
        "settings.shafts.resolution",
        "settings.shafts.light_samples",
        "settings.shafts.world_samples",
        "settings.shafts.attenuates_light",
        "settings.shafts.adapts_strata",
        "settings.shafts.lens_steps",
        "settings.shafts.shares_strata",
        "settings.shafts.grid_method",
        "settings.shafts.grid_error_target",
    ]


class TYNDALL_OT_air_preset_add(AddPresetBase, Operator):
    """Save the texture of the air as a preset, or remove one: its noise and its wind, not what is painted."""

    bl_idname = "tyndall.air_preset_add"
    bl_label = "Add Air Preset"
    preset_menu = "TYNDALL_PT_air_presets"
    preset_subdir = "tyndall/air"
    preset_defines: ClassVar = ["air = bpy.context.scene.tyndall.heterogeneity"]
    preset_values: ClassVar = [
        "air.is_enabled",
        "air.amount",
        "air.intensity",
        "air.level",
        "air.scale_m",
        "air.octaves",
        "air.persistence",
        "air.contrast",
        "air.wind_m_per_s",
    ]


CLASSES = (TYNDALL_OT_preset_apply, TYNDALL_OT_render_preset_add, TYNDALL_OT_air_preset_add)
