# SPDX-License-Identifier: GPL-3.0-or-later
"""``object.tyndall.painted_air``: what is painted into the air inside the cube of an Empty."""

from bpy.props import CollectionProperty, IntProperty, IntVectorProperty, PointerProperty, StringProperty
from bpy.types import PropertyGroup

from ..painted_air import note_other_tiles
from .tagging import EXTENSIBLE, OVERRIDABLE, tag

#: Voxels along a side; a volume of 512^3 takes 512 MiB.
MOST_VOXELS = 512


class TyndallAirTile(PropertyGroup):
    index: IntProperty(
        name="Index",
        description="Which tile of the volume this is; x runs fastest",
        min=0,
        options={"HIDDEN"},
        update=note_other_tiles,
        override=OVERRIDABLE,
    )
    halves: StringProperty(
        name="Halves",
        description="Its voxels: half floats, compressed",
        subtype="BYTE_STRING",
        options={"HIDDEN"},
        update=note_other_tiles,
        override=OVERRIDABLE,
    )


class TyndallAirVolume(PropertyGroup):
    tiles: CollectionProperty(
        name="Tiles",
        description="Those of 16 x 16 x 16 voxels in which anything is painted",
        type=TyndallAirTile,
        override=EXTENSIBLE,
    )
    revision: StringProperty(
        name="Revision",
        description="Another one whenever the tiles change",
        options={"HIDDEN"},
        update=tag,
        override=OVERRIDABLE,
    )


class TyndallPaintedAir(PropertyGroup):
    resolution: IntVectorProperty(
        name="Resolution",
        description="Voxels along the sides of the box. What is painted is seen at the new resolution at once, and "
        "kept at it with the next stroke; until then, going back loses nothing",
        subtype="XYZ",
        size=3,
        min=1,
        max=MOST_VOXELS,
        soft_min=16,
        soft_max=256,
        default=(64, 64, 64),
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    kept_resolution: IntVectorProperty(
        name="Kept Resolution",
        description="That of the tiles; 0 before the first stroke",
        size=3,
        min=0,
        max=MOST_VOXELS,
        options={"HIDDEN"},
        update=tag,
        override=OVERRIDABLE,
    )
    amount: PointerProperty(
        name="Amount",
        description="Added to the amount of texture: 0 leaves it, -1 makes the air even, 1 is all noise",
        type=TyndallAirVolume,
        update=tag,
        override=OVERRIDABLE,
    )
    level: PointerProperty(
        name="Softness",
        description="Added to the softness of the texture: 0 leaves it, larger is smoother, smaller grainier",
        type=TyndallAirVolume,
        update=tag,
        override=OVERRIDABLE,
    )
    intensity: PointerProperty(
        name="Intensity",
        description="The shafts are multiplied by it: 1 leaves them, 0 takes them away",
        type=TyndallAirVolume,
        update=tag,
        override=OVERRIDABLE,
    )


class TyndallObjectSettings(PropertyGroup):
    painted_air: PointerProperty(
        name="Painted Air",
        description="What is painted into the air inside this Empty's cube",
        type=TyndallPaintedAir,
        update=tag,
        override=OVERRIDABLE,
    )


CLASSES = (TyndallAirTile, TyndallAirVolume, TyndallPaintedAir, TyndallObjectSettings)
