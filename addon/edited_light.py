# SPDX-License-Identifier: GPL-3.0-or-later
"""Which light the tools for shafts work on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.types import Light, Object, PropertyGroup

if TYPE_CHECKING:
    from bpy.types import Context


def is_shaft_light(thing: Object | None) -> bool:
    """Whether it is a light that we draw."""
    return thing is not None and thing.type == "LIGHT"


def is_light_of_scene(settings: PropertyGroup, thing: Object) -> bool:
    """What a scene's settings can point to."""
    return is_shaft_light(thing) and settings.id_data.objects.get(thing.name) == thing


def why_not_editable(light: Light | None) -> str | None:
    """What a button says that works on the edited light; None: it may."""
    if light is None:
        return "Make a light active, or choose one in the sidebar"
    return None


def object_of(context: Context, light: Light) -> Object | None:
    """The active object, if it has this light; else the scene's first that has it."""
    active = context.object
    if active is not None and active.data == light:
        return active
    return next((thing for thing in context.scene.objects if thing.data == light), None)


def edited_light(context: Context) -> Light | None:
    """That of the Properties editor; in other editors the active object's, or else the one chosen for the scene."""
    light = getattr(context, "light", None)
    if isinstance(light, Light):
        return light
    if is_shaft_light(context.object):
        return context.object.data
    chosen = context.scene.tyndall.edited_light
    return chosen.data if is_shaft_light(chosen) and context.scene.objects.get(chosen.name) == chosen else None
