# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture before a light: in its own properties, and in the sidebar beside what else shapes its shafts."""

from __future__ import annotations

from bpy.types import Context, Light, Panel, UILayout

from ..edited_light import edited_light
from .base import SidebarPanel, draw_text
from .light import LightPanel


def draw_gobo(layout: UILayout, context: Context, light: Light) -> None:
    settings = light.tyndall
    layout.template_ID(settings, "gobo_image", new="image.new", open="image.open")
    if settings.gobo_image is None:
        draw_text(layout, context, "An image here colours the light, in the air and on surfaces", icon="INFO")
        return
    column = layout.column()
    if light.type == "SUN":
        column.prop(settings, "gobo_size_m", text="Width")
        column.prop(settings, "gobo_offset_m", text="Offset")
    if light.type != "POINT":
        # Beside a label of its own, the field of a narrow sidebar would cut both.
        column.prop(settings, "gobo_extension", text="Extension" if layout.use_property_split else "")
    column.prop(settings, "gobo_strength", text="Strength")


class TYNDALL_PT_gobo(LightPanel, Panel):
    bl_label = "Gobo"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        self.layout.use_property_split = True
        draw_gobo(self.layout, context, context.light)


class TYNDALL_PT_sidebar_gobo(SidebarPanel, Panel):
    bl_label = "Gobo"
    bl_parent_id = "TYNDALL_PT_sidebar_colour"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and edited_light(context) is not None

    def draw(self, context: Context) -> None:
        draw_gobo(self.layout, context, edited_light(context))


CLASSES = (TYNDALL_PT_gobo,)
SIDEBAR_CLASSES = (TYNDALL_PT_sidebar_gobo,)
