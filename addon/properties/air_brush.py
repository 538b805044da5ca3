# SPDX-License-Identifier: GPL-3.0-or-later
"""``scene.tyndall.air_brush``: the brush that paints the air.

Without ``update``, unlike all that a picture depends on: a brush that grows shall not have the scene read again.
"""

from bpy.props import BoolProperty, EnumProperty, FloatProperty
from bpy.types import PropertyGroup

from .tagging import OVERRIDABLE

VOLUMES = (
    (
        "INTENSITY",
        "Intensity",
        "How bright the shafts are: 0 takes them away, 1 leaves them as they are, 2 doubles them",
        "LIGHT_SUN",
        0,
    ),
    (
        "AMOUNT",
        "Amount",
        "How much texture there is: -1 makes the air even, 1 gives it all there is",
        "FORCE_TEXTURE",
        1,
    ),
    ("LEVEL", "Softness", "How fine the texture is: above 0 softer, below 0 grainier", "MOD_SMOOTH", 2),
)
MODES = (
    ("PAINT", "Paint", "Goes towards the value", 0),
    ("ADD", "Add", "Adds the value to what is there", 1),
    ("MULTIPLY", "Multiply", "Multiplies what is there by the value", 2),
    ("ERASE", "Erase", "Goes back to what is not painted. Holding Ctrl does it with every brush", 3),
    ("SMOOTH", "Smooth", "Blurs what is painted. Holding Shift does it with every brush", 4),
)
#: Of MODES, those that bring a value.
VALUED_MODES = frozenset({"PAINT", "ADD", "MULTIPLY"})


class TyndallAirBrush(PropertyGroup):
    volume: EnumProperty(
        name="Volume",
        description="What is painted",
        items=VOLUMES,
        default="INTENSITY",
        options=set(),
        override=OVERRIDABLE,
    )
    mode: EnumProperty(
        name="Brush",
        description="What a stroke does",
        items=MODES,
        default="PAINT",
        options=set(),
        override=OVERRIDABLE,
    )
    amount: FloatProperty(
        name="Value",
        description="Painted into the amount of texture: 1 is all of it, 0 leaves the scene's amount, -1 is even air",
        min=-1.0,
        max=1.0,
        default=-1.0,
        options=set(),
        override=OVERRIDABLE,
    )
    level: FloatProperty(
        name="Value",
        description="Painted into the softness of the texture: 2 is softer, 0 leaves the scene's, -2 is grainier",
        min=-8.0,
        max=8.0,
        soft_min=-4.0,
        soft_max=4.0,
        default=2.0,
        step=10,
        options=set(),
        override=OVERRIDABLE,
    )
    intensity: FloatProperty(
        name="Value",
        description="Painted into the intensity: 0 takes the shafts away, 1 leaves them as they are, 2 doubles them",
        min=0.0,
        max=1000.0,
        soft_max=4.0,
        default=0.0,
        step=5,
        options=set(),
        override=OVERRIDABLE,
    )
    radius_m: FloatProperty(
        name="Size",
        description="Radius across the view. F in the view, or [ and ]",
        subtype="DISTANCE",
        unit="LENGTH",
        min=1e-4,
        max=1e6,
        soft_min=0.01,
        soft_max=100.0,
        default=0.5,
        precision=3,
        options=set(),
        override=OVERRIDABLE,
    )
    depth: FloatProperty(
        name="Depth",
        description="Radius along the view, relative to the size: 1 is a ball, 0.2 a disc, 10 goes deep. "
        "Alt F in the view",
        min=0.01,
        max=1000.0,
        soft_min=0.1,
        soft_max=10.0,
        default=1.0,
        step=10,
        options=set(),
        override=OVERRIDABLE,
    )
    opacity: FloatProperty(
        name="Opacity",
        description="How much of its value a stroke brings, however often it crosses itself. Shift F in the view",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=0.5,
        options=set(),
        override=OVERRIDABLE,
    )
    hardness: FloatProperty(
        name="Hardness",
        description="Share of the size that has the full opacity; from there it falls off. 1 has a sharp rim. "
        "Ctrl F in the view",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=0.25,
        options=set(),
        override=OVERRIDABLE,
    )
    pressure_sizes: BoolProperty(
        name="Pressure Changes Size",
        description="A light touch of the pen paints with a smaller brush",
        default=False,
        options=set(),
        override=OVERRIDABLE,
    )
    pressure_fades: BoolProperty(
        name="Pressure Changes Opacity",
        description="A light touch of the pen paints with less opacity",
        default=True,
        options=set(),
        override=OVERRIDABLE,
    )
    shows_paint: BoolProperty(
        name="Show Paint",
        description="While painting, show what the volume holds: strong where the plane cuts it, faint before and "
        "behind. Warm is above what is not painted, cool below",
        default=True,
        options=set(),
        override=OVERRIDABLE,
    )


CLASSES = (TyndallAirBrush,)
