# SPDX-License-Identifier: GPL-3.0-or-later
"""``light.tyndall``: what Blender's own lights have no property for."""

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
)
from bpy.types import Image, PropertyGroup

from .light_map_fit import TyndallLightMapFit
from .occluder_edits import TyndallOccluderEdit
from .tagging import EXTENSIBLE, OVERRIDABLE, tag, tag_pointer

GOBO_EXTENSIONS = (
    ("CLIP", "Clip", "The image once; no light beside it", 0),
    ("REPEAT", "Repeat", "Tiles of the image, without end", 1),
    ("EXTEND", "Extend", "The image's border goes on beside it", 2),
    ("MIRROR", "Mirror", "Tiles, every other one mirrored", 3),
)


class TyndallLightSettings(PropertyGroup):
    scatters_in_media: BoolProperty(
        name="Scatter in Media",
        description="Media scatter this light: it draws shafts. Off, it lights surfaces only, and costs no shafts",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
    occluder_edits: CollectionProperty(
        name="Occluder Edits",
        description="What is done to the occluders before this light: the air sees it, surfaces where an edit says so",
        type=TyndallOccluderEdit,
        override=EXTENSIBLE,
    )
    active_occluder_edit: IntProperty(
        name="Active Occluder Edit",
        description="Index of the edit whose settings are shown",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    gobo_image: PointerProperty(
        name="Gobo",
        description="Image that colours the light, in the air and on surfaces. A spot throws it over its cone, a point "
        "light all around, and an area light shows it on itself",
        type=Image,
        update=tag_pointer,
        override=OVERRIDABLE,
    )
    gobo_size_m: FloatProperty(
        name="Gobo Width",
        description="Width of the image across a sun's light; its middle is on the line through the sun's object",
        subtype="DISTANCE",
        unit="LENGTH",
        min=1e-3,
        max=1e6,
        soft_min=0.1,
        soft_max=1000.0,
        default=10.0,
        update=tag,
        override=OVERRIDABLE,
    )
    gobo_offset_m: FloatVectorProperty(
        name="Gobo Offset",
        description="Where the middle of the image is, along the sun's own X and Y",
        subtype="XYZ",
        unit="LENGTH",
        size=2,
        update=tag,
        override=OVERRIDABLE,
    )
    gobo_extension: EnumProperty(
        name="Gobo Extension",
        description="What lies beside the image",
        items=GOBO_EXTENSIONS,
        default="CLIP",
        update=tag,
        override=OVERRIDABLE,
    )
    gobo_strength: FloatProperty(
        name="Gobo Strength",
        description="How much of the light the image colours: at 0 it stays white",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        default=1.0,
        update=tag,
        override=OVERRIDABLE,
    )
    light_map_fit: PointerProperty(
        name="Light Map Fit",
        description="What is painted over cameras, and how a map is fitted to it",
        type=TyndallLightMapFit,
        update=tag,
        override=OVERRIDABLE,
    )
