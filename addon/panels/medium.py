# SPDX-License-Identifier: GPL-3.0-or-later
"""Medium: the haze that shafts need, all of the file's in one place, in the 3D view's sidebar."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bpy.types import Context, Panel, World

from ..scene_media import fills_grids, media_materials, own_value
from ..shader_nodes import plugged_in
from .base import SidebarPanel, draw_text
from .world import draw_unbounded_medium

if TYPE_CHECKING:
    from bpy.types import Material, Node, UILayout

#: More are named in the Material properties: dozens of sliders would hide what comes below.
_MEDIA_SHOWN = 6
#: Shaders whose density alone says how far one can see, as long as they are about white.
_PLAIN_HAZE = frozenset({"ShaderNodeVolumeScatter", "ShaderNodeVolumePrincipled"})


def draw_medium(layout: UILayout, context: Context, owner: Material | World) -> None:
    """Draw what the node of a medium itself says, to be changed in place."""
    column = layout.column(align=True)
    row = column.row(align=True)
    if isinstance(owner, World):
        row.label(text=owner.name, icon="WORLD")
    else:
        row.prop(owner, "name", text="", icon="MATERIAL")
        row.operator("tyndall.select_medium", text="", icon="RESTRICT_SELECT_OFF").material_name = owner.name
    node = plugged_in(owner, "Volume")
    shown = [name for name in ("Density", "Anisotropy") if own_value(node, name) is not None]
    for name in shown:
        column.prop(node.inputs[name], "default_value", text=name)
    if not shown:
        draw_text(column, context, f"By its nodes: {node.bl_label}", icon="NODETREE")
    if isinstance(owner, World) or not fills_grids(owner):
        draw_reach(column, context, node)


def draw_reach(layout: UILayout, context: Context, node: Node) -> None:
    """Say what a density means: a number per metre tells nobody how thick the fog looks."""
    density = own_value(node, "Density") if node.bl_idname in _PLAIN_HAZE else None
    if density is not None and density.default_value > 0.0:
        draw_text(layout, context, f"Half the light is left after {math.log(2.0) / density.default_value:.3g} m")


class TYNDALL_PT_sidebar_medium(SidebarPanel, Panel):
    bl_label = "Medium"

    def draw(self, context: Context) -> None:
        layout = self.layout
        materials = media_materials()
        has_world_medium = plugged_in(context.scene.world, "Volume") is not None
        if has_world_medium:
            draw_unbounded_medium(layout, context, context.scene.world)
            draw_medium(layout, context, context.scene.world)
        else:
            if not materials:
                draw_text(layout, context, "Shafts show in haze: fill the scene with some", icon="INFO")
            layout.operator("tyndall.add_fog_box", icon="MOD_FLUIDSIM")
        for material in materials[:_MEDIA_SHOWN]:
            draw_medium(layout, context, material)
        if len(materials) > _MEDIA_SHOWN:
            layout.label(text=f"... and {len(materials) - _MEDIA_SHOWN} more materials", icon="BLANK1")
        if materials or has_world_medium:
            layout.prop(context.scene.tyndall.shafts, "attenuates_light")


SIDEBAR_CLASSES = (TYNDALL_PT_sidebar_medium,)
