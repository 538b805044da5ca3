# SPDX-License-Identifier: GPL-3.0-or-later
"""``light.tyndall``: what Blender's own lights have no property for."""

from bpy.props import BoolProperty, CollectionProperty, IntProperty
from bpy.types import PropertyGroup

from .occluder_edits import TyndallOccluderEdit
from .tagging import EXTENSIBLE, OVERRIDABLE, tag


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
        description="What is done to the occluders before this light, for the air only: surfaces keep their shadows",
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
