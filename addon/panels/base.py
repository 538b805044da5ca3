# SPDX-License-Identifier: GPL-3.0-or-later
"""What our panels share: where they appear, and how they show shader nodes and long text."""

from __future__ import annotations

import textwrap

from bpy.types import Context, Material, UILayout, World

from ..shader_nodes import shader_tree

ENGINE = "TYNDALL"

#: Width of a letter of the interface's font at a scale of 1, in pixels: an average over English text.
_LETTER_WIDTH_PX = 6.5
#: Regions from this width on, at a scale of 1, have room for labels beside fields.
_SPLIT_WIDTH_PX = 300
#: Of a table's width.
_NAME_SHARE = 0.7


class PropertiesPanel:
    """A panel of the Properties editor that shows while Tyndall is the scene's render engine."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.engine in cls.COMPAT_ENGINES


class SidebarPanel:
    """A panel of the tab for light shafts in the 3D view's sidebar; there, too, where they go over another engine."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Light Shafts"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.engine in PropertiesPanel.COMPAT_ENGINES or context.scene.tyndall.over_engine.is_enabled


def is_wide_region(context: Context) -> bool:
    """Whether there is room for labels beside fields: in a narrow sidebar both would be cut."""
    return bool(context.region.width >= _SPLIT_WIDTH_PX * context.preferences.system.ui_scale)


def draw_node_socket(layout: UILayout, owner: Material | World, socket_name: str) -> bool:
    """Show what is plugged into a socket of the owner's output node, to be edited in place. False without a socket."""
    tree = shader_tree(owner)
    output = tree.get_output_node("CYCLES") if tree else None
    socket = output.inputs.get(socket_name) if output else None
    if socket is None:
        return False
    layout.template_node_view(tree, output, socket)
    return True


def draw_without_output(layout: UILayout, owner: Material | World, color_name: str = "") -> None:
    """Show what there is instead of a socket: the way to nodes, and the colour that stands in for them."""
    if shader_tree(owner):
        layout.label(text="No output node", icon="ERROR")
        return
    layout.prop(owner, "use_nodes", icon="NODETREE")
    if color_name:
        layout.prop(owner, color_name)


def _wrapped(text: str, width_px: float) -> list[str]:
    """Lines of a text, at the interface's scale of 1: a label does not wrap, but cuts its middle out."""
    return textwrap.wrap(text, max(20, int(width_px / _LETTER_WIDTH_PX)))


def _width_px(context: Context) -> float:
    return float(context.region.width / context.preferences.system.ui_scale)


def draw_text(layout: UILayout, context: Context, text: str, icon: str = "NONE") -> None:
    """Wrap a sentence to the region's width."""
    draw_lines(layout, text, _width_px(context), icon)


def draw_lines(layout: UILayout, text: str, width_px: float, icon: str = "NONE") -> None:
    """Wrap a sentence to a width, at the interface's scale of 1."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for index, line in enumerate(_wrapped(text, width_px - 60)):
        column.label(text=line, icon=icon if index == 0 else ("NONE" if icon == "NONE" else "BLANK1"))


def draw_value(layout: UILayout, context: Context, name: str, value: str) -> None:
    """Write a row of a table; a long name takes several lines."""
    *above, last = _wrapped(name[:1].upper() + name[1:], _NAME_SHARE * (_width_px(context) - 20))
    for line in above:
        layout.label(text=line)
    row = layout.split(factor=_NAME_SHARE)
    row.label(text=last)
    row.label(text=value)
