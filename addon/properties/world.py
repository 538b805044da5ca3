# SPDX-License-Identifier: GPL-3.0-or-later
"""``world.tyndall``: the sun object that stands for the dominant light of the world's image."""

from bpy.props import BoolProperty, FloatProperty, PointerProperty
from bpy.types import Object, PropertyGroup

from .tagging import OVERRIDABLE, tag, tag_pointer


def is_sun(_settings: PropertyGroup, thing: Object) -> bool:
    return thing.type == "LIGHT" and thing.data.type == "SUN"


class TyndallWorldSettings(PropertyGroup):
    takes_sun: BoolProperty(
        name="Sun from Image",
        description="The sun object gives the light of the image's brightest place, and the image gives the rest: in "
        "sum a surface that faces it receives what it did. The camera still sees the whole image",
        default=False,
        update=tag,
        override=OVERRIDABLE,
    )
    sun: PointerProperty(
        name="Sun",
        description="The object that stands for the image's sun; its edits, gobo and shafts are those of any sun",
        type=Object,
        poll=is_sun,
        update=tag_pointer,
        override=OVERRIDABLE,
    )
    sun_threshold: FloatProperty(
        name="Threshold",
        description="What of the image is the sun: texels brighter than this share of the way from the image's mean to "
        "its brightest, around that one. Less takes more of a glow; then update the sun",
        subtype="FACTOR",
        min=0.01,
        max=0.99,
        default=0.5,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
