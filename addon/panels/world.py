# SPDX-License-Identifier: GPL-3.0-or-later
"""World properties: its light and its medium."""

from __future__ import annotations

import math

from bpy.types import Context, Panel, UILayout, World

from ..shader_nodes import is_fed_by_nodes, plugged_in
from .base import PropertiesPanel, draw_node_socket, draw_text, draw_value, draw_without_output


class WorldPanel(PropertiesPanel):
    bl_context = "world"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.world is not None


def draw_unbounded_medium(layout: UILayout, context: Context, world: World) -> None:
    """Say what the world's medium does to the light, and offer the remedy."""
    medium = plugged_in(world, "Volume")
    if medium is not None and is_fed_by_nodes(medium):
        draw_text(
            layout,
            context,
            "What nodes vary of this medium fills a box around what is drawn, lamps and the camera; "
            "a report says how large.",
            icon="INFO",
        )
        return
    draw_text(
        layout,
        context,
        "This medium has no bounds: light from a sun or from the world is lost in it before it arrives. "
        "A fog box around the scene lets it in.",
        icon="INFO",
    )
    layout.operator("tyndall.add_fog_box", text="Turn into a Fog Box").replaces_world_medium = True


class TYNDALL_PT_world_preview(WorldPanel, Panel):
    bl_label = "Preview"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        self.layout.template_preview(context.world)


class TYNDALL_PT_world_surface(WorldPanel, Panel):
    bl_label = "Surface"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        world = context.world
        if not draw_node_socket(layout, world, "Surface"):
            draw_without_output(layout, world, "color")


class TYNDALL_PT_world_sun(WorldPanel, Panel):
    bl_label = "Sun from Image"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.world.tyndall, "takes_sun", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        settings = context.world.tyndall
        sun = settings.sun
        layout.operator(
            "tyndall.sun_from_world", text="Make Sun from Image" if sun is None else "Update Sun", icon="LIGHT_SUN"
        )
        column = layout.column()
        column.active = settings.takes_sun
        column.prop(settings, "sun")
        column.prop(settings, "sun_threshold")
        if sun is None:
            draw_text(
                layout,
                context,
                "The brightest light of the world's image becomes a sun object, with shafts that can be edited; the "
                "image gives the rest",
                icon="INFO",
            )
        else:
            height = math.degrees(math.asin(max(-1.0, min(1.0, sun.matrix_world.to_3x3().col[2].normalized().z))))
            draw_value(layout, context, "Height", f"{height:.1f}°")
            draw_value(layout, context, "Width", f"{math.degrees(sun.data.angle):.2g}°")
            draw_value(layout, context, "Strength", f"{sun.data.energy:.3g} W/m²")


class TYNDALL_PT_world_ray_visibility(WorldPanel, Panel):
    bl_label = "Ray Visibility"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and hasattr(context.world, "cycles_visibility")  # where its add-on is on

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        column = layout.column()
        for switch in ("camera", "diffuse", "glossy", "transmission"):
            column.prop(context.world.cycles_visibility, switch)
        column.prop(context.world.cycles_visibility, "scatter", text="Media")


class TYNDALL_PT_world_volume(WorldPanel, Panel):
    bl_label = "Volume"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        if plugged_in(context.world, "Volume"):
            draw_unbounded_medium(layout, context, context.world)
        if not draw_node_socket(layout, context.world, "Volume"):
            draw_without_output(layout, context.world)


CLASSES = (
    TYNDALL_PT_world_preview,
    TYNDALL_PT_world_surface,
    TYNDALL_PT_world_sun,
    TYNDALL_PT_world_volume,
    TYNDALL_PT_world_ray_visibility,
)
