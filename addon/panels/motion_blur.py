# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: motion blur. Blender has no panel of it for every engine; these are laid out like Cycles'."""

from __future__ import annotations

from bpy.types import Context, Panel

from ..shutter_position import position_settings
from .base import PropertiesPanel

_CURVES = (
    ("SMOOTH", "SMOOTHCURVE"),
    ("ROUND", "SPHERECURVE"),
    ("ROOT", "ROOTCURVE"),
    ("SHARP", "SHARPCURVE"),
    ("LINE", "LINCURVE"),
    ("MAX", "NOCURVE"),
)


class TYNDALL_PT_motion_blur(PropertiesPanel, Panel):
    bl_label = "Motion Blur"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        scene = context.scene
        layout.active = scene.render.use_motion_blur
        column = layout.column()
        owner = position_settings(scene)
        if owner is None:
            column.label(text="Centered on the frame: Cycles, which keeps the position, is off", icon="INFO")
        else:
            column.prop(owner, "motion_blur_position", text="Position")
        column.prop(scene.render, "motion_blur_shutter")
        column.prop(scene.tyndall, "motion_steps")
        settings = scene.tyndall
        if settings.motion_steps > settings.pixel_samples:
            column.label(text=f"{settings.pixel_samples} steps: as many as samples", icon="INFO")


class TYNDALL_PT_motion_blur_curve(PropertiesPanel, Panel):
    bl_label = "Shutter Curve"
    bl_context = "render"
    bl_parent_id = "TYNDALL_PT_motion_blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        render = context.scene.render
        layout.active = render.use_motion_blur
        layout.template_curve_mapping(render, "motion_blur_shutter_curve")
        row = layout.row(align=True)
        for shape, icon in _CURVES:
            row.operator("render.shutter_curve_preset", icon=icon, text="").shape = shape


CLASSES = (TYNDALL_PT_motion_blur, TYNDALL_PT_motion_blur_curve)
