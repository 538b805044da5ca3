# SPDX-License-Identifier: GPL-3.0-or-later
"""``scene.tyndall.over_engine``: light shafts over the picture of another engine.

Strength and mask are inputs of the node in the compositor: keyed there, and changed without a new render.
"""

from bpy.props import BoolProperty, PointerProperty, StringProperty
from bpy.types import Context, PropertyGroup, Scene

from .tagging import OVERRIDABLE, tag


def apply_switch(group: "TyndallOverEngine", context: Context) -> None:
    from ..over_engine import switch

    switch(group.id_data)
    tag(group, context)


class TyndallOverEngine(PropertyGroup):
    is_enabled: BoolProperty(
        name="Light Shafts over This Engine",
        description="F12 renders with the scene's engine and adds Tyndall's light shafts in the compositor. "
        "Off: the picture is the engine's own, bit for bit",
        options=set(),
        default=False,
        update=apply_switch,
        override=OVERRIDABLE,
    )
    view_layer: StringProperty(
        name="View Layer",
        description="Whose objects cast shafts and end view rays. Empty: what any of the rendered view layers shows",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    master: PointerProperty(
        name="Scene",
        description="Of a scene that renders light shafts for another one: that one, whose settings count",
        type=Scene,
        update=tag,
        override=OVERRIDABLE,
    )
    renders_shafts: BoolProperty(
        name="Renders Light Shafts",
        description="The scene was made to render the light shafts of another one",
        options={"HIDDEN"},
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    has_own_tree: BoolProperty(
        name="Made the Compositor's Nodes",
        description="There were none before: removing the light shafts takes them away, too",
        options={"HIDDEN"},
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
