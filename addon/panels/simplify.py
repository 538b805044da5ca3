# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: Blender's simplification, which the scene's evaluation does for every engine.

Blender's own panel would stand above all of ours: panels stand in the order in which they were registered.
"""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel


class TYNDALL_PT_simplify(PropertiesPanel, Panel):
    bl_label = "Simplify"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        render = context.scene.render
        layout.active = render.use_simplify
        column = layout.column(align=True)
        column.prop(render, "simplify_subdivision", text="Subdivision")
        column.prop(render, "simplify_subdivision_render", text="In Renders")
        column = layout.column(align=True)
        column.prop(render, "simplify_child_particles", text="Child Hairs")
        column.prop(render, "simplify_child_particles_render", text="In Renders")


CLASSES = (TYNDALL_PT_simplify,)
