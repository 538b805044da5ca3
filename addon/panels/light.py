# SPDX-License-Identifier: GPL-3.0-or-later
"""Light properties: Blender's own, and whether media scatter it."""

from __future__ import annotations

import bpy
from bpy.types import Context, Light, Panel, UILayout

from ..edited_light import is_shaft_light
from .base import PropertiesPanel, draw_text


def draw_optional(layout: UILayout, light: Light, *names: str) -> None:
    """Properties that only some versions of Blender have: temperature, exposure and normalize came with 4.5."""
    for name in names:
        if name in light.bl_rna.properties:
            layout.prop(light, name)


def draw_edited_light(layout: UILayout, context: Context) -> None:
    """Say which light the sidebar's tools work on; while the active object is none, let one be chosen."""
    if is_shaft_light(context.object):
        layout.label(text=context.object.name, icon=f"LIGHT_{context.object.data.type}")
    else:
        layout.prop(context.scene.tyndall, "edited_light", text="")


class LightPanel(PropertiesPanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.light is not None


class TYNDALL_PT_light(LightPanel, Panel):
    bl_label = "Light"

    def draw(self, context: Context) -> None:
        layout = self.layout
        light = context.light
        layout.row().prop(light, "type", expand=True)
        layout.use_property_split = True
        column = layout.column()
        draw_optional(column, light, "use_temperature")
        if getattr(light, "use_temperature", False):
            column.prop(light, "temperature")
        column.prop(light, "color")
        column.prop(light, "energy")
        draw_optional(column, light, "exposure", "normalize")
        column = layout.column()
        if light.type == "SUN":
            column.prop(light, "angle")
        elif light.type == "AREA":
            column.prop(light, "shape")
            is_even = light.shape in {"SQUARE", "DISK"}
            sizes = column.column(align=True)
            sizes.prop(light, "size", text="Size" if is_even else "Size X")
            if not is_even:
                sizes.prop(light, "size_y", text="Y")
        else:
            column.prop(light, "shadow_soft_size", text="Radius")
            draw_optional(column, light, "use_soft_falloff")
        column = layout.column(heading="Effect")
        # The switch that Cycles reads in this version, as the sync does.
        if bpy.app.version >= (4, 2, 0):
            column.prop(light, "use_shadow", text="Cast Shadow")
        elif hasattr(light, "cycles"):
            column.prop(light.cycles, "cast_shadow", text="Cast Shadow")
        column.prop(light.tyndall, "scatters_in_media")


class TYNDALL_PT_beam_shape(LightPanel, Panel):
    bl_label = "Beam Shape"
    bl_parent_id = "TYNDALL_PT_light"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.light.type in {"SPOT", "AREA"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        light = context.light
        if light.type == "AREA":
            layout.prop(light, "spread")
            return
        layout.prop(light, "spot_size", text="Spot Size")
        layout.prop(light, "spot_blend", text="Blend", slider=True)
        layout.prop(light, "show_cone")


class TYNDALL_PT_light_nodes(LightPanel, Panel):
    bl_label = "Nodes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.light, "use_nodes", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        light = context.light
        output = light.node_tree.get_output_node("CYCLES") if light.use_nodes and light.node_tree else None
        if output:
            layout.template_node_view(light.node_tree, output, output.inputs["Surface"])
        else:
            draw_text(layout, context, "Emission nodes would multiply power and colour", icon="INFO")


CLASSES = (TYNDALL_PT_light, TYNDALL_PT_beam_shape, TYNDALL_PT_light_nodes)
