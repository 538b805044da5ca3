# SPDX-License-Identifier: GPL-3.0-or-later
"""``space.shading.tyndall``: what a rendered viewport shows."""

from bpy.props import EnumProperty
from bpy.types import Context, PropertyGroup

from ..viewport_passes import VIEWPORT_PASSES


def draw_anew(_group: "TyndallViewportShading", context: Context) -> None:
    """Nothing of the scene has changed, so that Blender tells no engine."""
    if context.area is not None:
        context.area.tag_redraw()


class TyndallViewportShading(PropertyGroup):
    render_pass: EnumProperty(
        name="Render Pass",
        description="What the viewport shows. Passes of light by what sends it keep nothing from picture to picture",
        items=[(each.identifier, each.name, each.description) for each in VIEWPORT_PASSES],
        default="COMBINED",
        update=draw_anew,
    )
