# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: film, threads and memory."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel


class TYNDALL_PT_film(PropertiesPanel, Panel):
    bl_label = "Film"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        if (of_cycles := getattr(context.scene, "cycles", None)) is not None:
            layout.prop(of_cycles, "film_exposure")
        layout.prop(context.scene.render, "film_transparent", text="Transparent")


class TYNDALL_PT_performance(PropertiesPanel, Panel):
    bl_label = "Performance"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.tyndall
        layout.prop(settings, "thread_count")
        if settings.thread_count == 0:
            layout.label(text="All threads of this machine", icon="INFO")
        layout.prop(settings, "texture_budget_mib")
        if settings.texture_budget_mib == 0:
            layout.label(text="Up to half of this machine's memory", icon="INFO")


CLASSES = (TYNDALL_PT_film, TYNDALL_PT_performance)
