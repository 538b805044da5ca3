# SPDX-License-Identifier: GPL-3.0-or-later
"""``light.tyndall.light_map_fit``: what was painted over which cameras, and how a light's map is fitted to it."""

from bpy.props import BoolProperty, CollectionProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import Image, Object, PropertyGroup

from .list_items import NamedItem
from .tagging import EXTENSIBLE, OVERRIDABLE, tag, tag_pointer


def is_camera(_settings: PropertyGroup, thing: Object) -> bool:
    return thing.type == "CAMERA"


class TyndallFitView(NamedItem, PropertyGroup):
    UNNAMED = "View"

    is_enabled: BoolProperty(
        name="Enabled",
        description="The fit listens to these strokes",
        default=True,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    camera: PointerProperty(
        name="Camera",
        description="What the strokes are painted over",
        type=Object,
        poll=is_camera,
        update=tag_pointer,
        override=OVERRIDABLE,
    )
    strokes: PointerProperty(
        name="Strokes",
        description="Desired colours of the shafts, over the camera's frame: white is the light's own colour, alpha is "
        "how much a pixel matters. Transparent where nothing is painted",
        type=Image,
        update=tag_pointer,
        override=OVERRIDABLE,
    )


class TyndallLightMapFit(PropertyGroup):
    views: CollectionProperty(
        name="Views",
        description="Strokes, and the cameras that they are painted over",
        type=TyndallFitView,
        override=EXTENSIBLE,
    )
    active_view: IntProperty(
        name="Active View",
        description="Index of the view whose settings are shown",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    resolution: IntProperty(
        name="Resolution",
        description="Texels along a side of the fitted map. Time and memory grow with it",
        subtype="PIXEL",
        min=16,
        max=4096,
        default=512,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    steps: IntProperty(
        name="Steps",
        description="Of the solver, at most: it ends earlier where nothing more is to be gained",
        min=1,
        max=10000,
        soft_max=256,
        default=32,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    regularisation: FloatProperty(
        name="Keep",
        description="How much the map stays what it is where strokes say otherwise. 0: they alone count; what none of "
        "them sees stays in any case",
        min=0.0,
        max=1e6,
        soft_max=1.0,
        default=1e-3,
        precision=5,
        step=0.1,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    residuals: StringProperty(
        name="Residuals",
        description="Of the last fit's first map and each of its steps: how far the strokes' pixels are from what was "
        "painted, as a share of what a white map gives",
        options={"HIDDEN"},
        update=tag,
        override=OVERRIDABLE,
    )


CLASSES = (TyndallFitView, TyndallLightMapFit)
