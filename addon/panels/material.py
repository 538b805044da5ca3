# SPDX-License-Identifier: GPL-3.0-or-later
"""Material properties: the surface's shader and the medium inside."""

from __future__ import annotations

from bpy.types import Context, Panel

from .base import PropertiesPanel, draw_node_socket, draw_without_output


class MaterialPanel(PropertiesPanel):
    bl_context = "material"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.material is not None and not context.material.grease_pencil


class TYNDALL_PT_material_surface(MaterialPanel, Panel):
    bl_label = "Surface"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        material = context.material
        if not draw_node_socket(layout, material, "Surface"):
            draw_without_output(layout, material, "diffuse_color")


class TYNDALL_PT_material_volume(MaterialPanel, Panel):
    bl_label = "Volume"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        if not draw_node_socket(layout, context.material, "Volume"):
            draw_without_output(layout, context.material)


CLASSES = (TYNDALL_PT_material_surface, TYNDALL_PT_material_volume)
