# SPDX-License-Identifier: GPL-3.0-or-later
"""``light.tyndall``: what Blender's own lights have no property for."""

from bpy.props import BoolProperty
from bpy.types import PropertyGroup

from .tagging import OVERRIDABLE, tag


class TyndallLightSettings(PropertyGroup):
    scatters_in_media: BoolProperty(
        name="Scatter in Media",
        description="Media scatter this light: it draws shafts. Off, it lights surfaces only, and costs no shafts",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
