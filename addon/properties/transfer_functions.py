# SPDX-License-Identifier: GPL-3.0-or-later
"""``node_tree.tyndall``: a transfer function, one shader node tree each; and a scene's list of them.

A tree, because it alone has all of it: a name, users and a fake one, copies, append, assets, keys, and colour ramps.
"""

from __future__ import annotations

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
)
from bpy.types import Image, PropertyGroup, ShaderNodeTree

from .list_items import OrderedItem
from .tagging import EXTENSIBLE, OVERRIDABLE, tag, tag_pointer
from .transfer_layers import TyndallTransferLayer

AXES = (
    (
        "AVERAGE_VISIBILITY",
        "Average Visibility",
        "Lit share of the view's way through media: 0 is all shadow, 1 is as much light as there is",
        0,
    ),
    ("DEPTH", "Depth", "Of the first surface: 0 is near, 1 is far, and the sky", 1),
    ("MEAN_LIT_POSITION", "Mean Lit Position", "How far away the lit air is, on average: 0 where none is lit", 2),
    ("LIGHT_ANGLE", "Angle to Light", "0 looks into the light, 1 away from it", 3),
    ("OPTICAL_DEPTH", "Optical Depth", "How much media hide of what is behind them: 0 is clear, 1 is a wall", 4),
    ("HEIGHT", "Height", "Of the first surface, along the world's Z: 0 is low, 1 is high, and the sky", 5),
    ("MASK", "Mask", "Brightness of an image over the camera's frame", 6),
)
AXIS_NAMES = {identifier: label for identifier, label, _description, _number in AXES}
#: Those that are measured in metres.
RANGED_AXES = frozenset({"DEPTH", "MEAN_LIT_POSITION", "HEIGHT"})
USES = (
    ("REPLACE", "Replace", "Shafts take the function's colour, as bright as Strength says, whatever they were", 0),
    ("MULTIPLY", "Multiply", "The physical shafts times the function's colour: white changes nothing", 1),
    ("TINT", "Tint", "The physical shafts' brightness in the function's colour", 2),
)


class ParameterAxis:
    """What both axes have; which of them a new function measures differs."""

    fits_range: BoolProperty(
        name="Fit Range to Frame",
        description="0 and 1 are the least and the most that the frame shows, so that one function works in scenes of "
        "any size. Off: they are fixed, and hold still as the camera moves",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
    low_m: FloatProperty(
        name="From",
        description="What is 0",
        subtype="DISTANCE",
        unit="LENGTH",
        min=-1e6,
        max=1e6,
        default=0.0,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    high_m: FloatProperty(
        name="To",
        description="What is 1",
        subtype="DISTANCE",
        unit="LENGTH",
        min=-1e6,
        max=1e6,
        default=100.0,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    full_visibility: FloatProperty(
        name="Full At",
        description="The average visibility that is 1: a hall whose air is lit for a fifth of the way needs no more",
        subtype="FACTOR",
        min=0.001,
        max=1.0,
        default=1.0,
        precision=3,
        update=tag,
        override=OVERRIDABLE,
    )
    mask: PointerProperty(
        name="Mask",
        description="Over the camera's frame: black is 0, white is 1",
        type=Image,
        update=tag_pointer,
        override=OVERRIDABLE,
    )


def _measured(default: str) -> object:
    return EnumProperty(
        name="Measures",
        description="Which parameter of the view's ray this axis of the function is",
        items=AXES,
        default=default,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )


class TyndallTransferAxisX(ParameterAxis, PropertyGroup):
    axis: _measured("AVERAGE_VISIBILITY")


class TyndallTransferAxisY(ParameterAxis, PropertyGroup):
    axis: _measured("DEPTH")


class TyndallTransferFunction(PropertyGroup):
    is_transfer_function: BoolProperty(
        name="Transfer Function",
        description="This node group holds layers of colour for light shafts, and no shader",
        default=False,
        options=set(),
        update=tag,
    )
    x: PointerProperty(name="X Axis", type=TyndallTransferAxisX, update=tag, override=OVERRIDABLE)
    y: PointerProperty(name="Y Axis", type=TyndallTransferAxisY, update=tag, override=OVERRIDABLE)
    use: EnumProperty(
        name="Use",
        description="What the function's colour does with the physical shafts. Where it is transparent: nothing",
        items=USES,
        default="MULTIPLY",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    strength: FloatProperty(
        name="Strength",
        description="Of white, where it replaces the shafts: as bright as an Emission shader of this strength",
        min=0.0,
        max=1e6,
        soft_max=10.0,
        default=1.0,
        update=tag,
        override=OVERRIDABLE,
    )
    layers: CollectionProperty(
        name="Layers",
        description="Of colour, on each other; without one, shafts stay what they are",
        type=TyndallTransferLayer,
        override=EXTENSIBLE,
    )
    active_layer: IntProperty(
        name="Active Layer",
        description="Index of the layer whose settings are shown",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )


def is_transfer_function(_state: PropertyGroup, tree: ShaderNodeTree) -> bool:
    return bool(tree.tyndall.is_transfer_function)


class TyndallTransferState(OrderedItem, PropertyGroup):
    """An entry of a scene's list, between two of which the scene's state goes over from one function to the next."""

    UNNAMED = "State"

    function: PointerProperty(
        name="Transfer Function",
        description="What recolours the shafts in this state. None: they stay physical",
        type=ShaderNodeTree,
        poll=is_transfer_function,
        update=tag_pointer,
        override=OVERRIDABLE,
    )


#: In the order of registration: a group before the group that holds it.
CLASSES = (TyndallTransferAxisX, TyndallTransferAxisY, TyndallTransferFunction, TyndallTransferState)
