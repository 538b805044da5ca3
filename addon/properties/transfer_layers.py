# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of a transfer function, and the constraints of those that diffuse colours."""

from __future__ import annotations

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Context, Image, Object, PropertyGroup

from ..function_trees import keep_ramp
from .list_items import NamedItem, SwitchedItem
from .tagging import EXTENSIBLE, OVERRIDABLE, tag, tag_pointer

KINDS = (
    ("SOLID", "Solid", "One colour everywhere", "SNAP_FACE", 0),
    ("GRADIENT", "Gradient", "A colour ramp between two places, or around one", "COLOR", 1),
    (
        "DIFFUSION",
        "Diffusion",
        (
            "Colours set at single places spread smoothly over all of the function: one makes a solid, two make a "
            "gradient, more make a painting. Pick places on the picture itself"
        ),
        "POINTCLOUD_DATA",
        2,
    ),
    ("IMAGE", "Image", "A picture laid over the function: paint it in the Image Editor", "IMAGE_DATA", 3),
)
KIND_ICONS = {identifier: icon for identifier, _label, _description, icon, _number in KINDS}
KIND_NAMES = {identifier: label for identifier, label, _description, _icon, _number in KINDS}
#: Names and order as in Blender's Mix node.
BLEND_MODES = (
    ("MIX", "Mix", "The layer covers what is below it, as far as it is opaque", 0),
    ("DARKEN", "Darken", "The darker of both, per channel", 1),
    ("MULTIPLY", "Multiply", "The product of both: white leaves what is below", 2),
    ("BURN", "Color Burn", "Darkens what is below, its shadows most", 3),
    ("LIGHTEN", "Lighten", "The lighter of both, per channel", 4),
    ("SCREEN", "Screen", "Lightens as two projectors do: black leaves what is below", 5),
    ("DODGE", "Color Dodge", "Lightens what is below, its lights most", 6),
    ("ADD", "Add", "The sum of both", 7),
    ("OVERLAY", "Overlay", "Multiplies the dark and screens the light parts of what is below", 8),
    ("SOFT_LIGHT", "Soft Light", "A gentler Overlay", 9),
    ("LINEAR_LIGHT", "Linear Light", "Adds twice the colour, less one", 10),
    ("DIFFERENCE", "Difference", "How far both are apart, per channel", 11),
    ("EXCLUSION", "Exclusion", "As Difference, with less contrast", 12),
    ("SUBTRACT", "Subtract", "Takes the colour off what is below", 13),
    ("DIVIDE", "Divide", "Divides what is below by the colour", 14),
    ("HUE", "Hue", "The layer's hue on what is below", 15),
    ("SATURATION", "Saturation", "The layer's saturation on what is below", 16),
    ("COLOR", "Color", "The layer's hue and saturation on what is below", 17),
    ("VALUE", "Value", "The layer's brightness on what is below", 18),
)
SHAPES = (
    ("LINEAR", "Linear", "The ramp goes from Start to End", "IPO_LINEAR", 0),
    ("RADIAL", "Radial", "The ramp goes from its middle, Start, to a circle through End", "PROP_CON", 1),
)


def make_ramp(layer: TyndallTransferLayer, context: Context) -> None:
    """What the ``update`` of a layer's kind does."""
    keep_ramp(layer)
    tag(layer, context)


class TyndallTransferConstraint(NamedItem, PropertyGroup):
    UNNAMED = "Colour"

    position: FloatVectorProperty(
        name="Position",
        description="Along the function's X and Y axis. Of a constraint that follows a surface: where that was when it "
        "was picked",
        size=2,
        min=0.0,
        max=1.0,
        default=(0.5, 0.5),
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    colour: FloatVectorProperty(
        name="Colour",
        description="What the function is at this place; alpha 0 leaves what is below",
        subtype="COLOR",
        size=4,
        min=0.0,
        max=1e4,
        soft_max=1.0,
        default=(1.0, 1.0, 1.0, 1.0),
        update=tag,
        override=OVERRIDABLE,
    )
    is_tracked: BoolProperty(
        name="Follow Surface",
        description="The constraint goes where the picked point of the surface goes, as objects and camera move",
        default=False,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    tracked_object: PointerProperty(
        name="Object",
        description="What the constraint follows: its surface where that was picked, or else its place",
        type=Object,
        update=tag_pointer,
        override=OVERRIDABLE,
    )
    triangle_index: IntProperty(
        name="Triangle",
        description="Of the tracked object's evaluated mesh",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    triangle_count: IntProperty(
        name="Triangles",
        description="Of that mesh when the point was picked; with another count the point is looked for by its place. "
        "0: it is fixed in the object's space",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    triangle_weights: FloatVectorProperty(
        name="Weights",
        description="Of the triangle's corners, with a sum of 1",
        size=3,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    local_point: FloatVectorProperty(
        name="Point",
        description="In the tracked object's space, when it was picked",
        subtype="XYZ",
        size=3,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )


class TyndallTransferLayer(SwitchedItem, PropertyGroup):
    UNNAMED = "Layer"

    kind: EnumProperty(
        name="Kind",
        description="Where the layer's colours come from",
        items=KINDS,
        default="SOLID",
        options=set(),
        update=make_ramp,
        override=OVERRIDABLE,
    )
    blend_mode: EnumProperty(
        name="Blend",
        description="How the layer meets what lies below it",
        items=BLEND_MODES,
        default="MIX",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    opacity: FloatProperty(
        name="Opacity",
        description="How much of the layer there is",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=1.0,
        update=tag,
        override=OVERRIDABLE,
    )
    colour: FloatVectorProperty(
        name="Colour",
        description="Of all of the layer; alpha 0 leaves what is below",
        subtype="COLOR",
        size=4,
        min=0.0,
        max=1e4,
        soft_max=1.0,
        default=(1.0, 1.0, 1.0, 1.0),
        update=tag,
        override=OVERRIDABLE,
    )
    shape: EnumProperty(
        name="Shape",
        description="How the ramp spreads",
        items=SHAPES,
        default="LINEAR",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    start: FloatVectorProperty(
        name="Start",
        description="Where the ramp begins, along the function's X and Y axis; of a radial one: its middle",
        size=2,
        min=-10.0,
        max=10.0,
        soft_min=0.0,
        soft_max=1.0,
        default=(0.0, 0.5),
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    end: FloatVectorProperty(
        name="End",
        description="Where the ramp ends, along the function's X and Y axis; of a radial one: a place on its rim",
        size=2,
        min=-10.0,
        max=10.0,
        soft_min=0.0,
        soft_max=1.0,
        default=(1.0, 0.5),
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    ramp_node: StringProperty(
        name="Ramp",
        description="Name of the node that holds the ramp: node, not layer, so that it can be keyed, copied and saved",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    constraints: CollectionProperty(
        name="Constraints",
        description="Places of the function that have a colour",
        type=TyndallTransferConstraint,
        override=EXTENSIBLE,
    )
    active_constraint: IntProperty(
        name="Active Constraint",
        description="Index of the constraint whose settings are shown",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    smoothness: FloatProperty(
        name="Smoothness",
        description="Over what length colours pass into each other smoothly, in sides of the function. "
        "0 has peaks at single constraints, as a tent has at its poles",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=0.25,
        update=tag,
        override=OVERRIDABLE,
    )
    image: PointerProperty(
        name="Image",
        description="Laid over the function: left to right along X, bottom to top along Y",
        type=Image,
        update=tag_pointer,
        override=OVERRIDABLE,
    )


#: In the order of registration: a group before the group that holds it.
CLASSES = (TyndallTransferConstraint, TyndallTransferLayer)
