# SPDX-License-Identifier: GPL-3.0-or-later
"""Light shafts over the picture of any engine, put together by Blender's compositor.

The artist's scene renders with its own engine. A second scene shares its objects and renders with ours; a Render Layers
node in the artist's compositor reads it, and a node group before the output makes picture x transmittance + light of
the air. F12 renders both, frame by frame. Settings are those of the artist's scene: ours knows it as its ``master``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import availability
from . import compositor, fog, shafts_scene
from .shafts_scene import shafts_scene_of

if TYPE_CHECKING:
    import bpy


def why_not(scene: bpy.types.Scene) -> str | None:
    """What a button says that sets the light shafts up; None: it may."""
    if (reason := availability.why_no_render()) is not None:
        return reason
    if scene.tyndall.over_engine.master is not None:
        return f'This scene holds the light shafts of "{scene.tyndall.over_engine.master.name}": set up that one'
    if scene.render.engine == shafts_scene.ENGINE:
        return "Tyndall renders the light shafts of this scene itself: choose the engine of your picture first"
    return compositor.why_locked(scene)


def is_set_up(scene: bpy.types.Scene) -> bool:
    """Whether there is something that the switch switches."""
    return bool(compositor.our_nodes(scene))


def set_up(scene: bpy.types.Scene) -> None:
    """Make what is missing, mend what is broken, and leave the rest; ``why_not`` says whether it can be done."""
    shafts = shafts_scene_of(scene) or shafts_scene.new(scene)
    shafts_scene.keep_in_step(scene, shafts)
    compositor.connect(scene, shafts)
    switch(scene)


def remove(scene: bpy.types.Scene) -> None:
    """Take all of it away again: the artist's links are as they were, and fog is the engine's own."""
    compositor.disconnect(scene)
    shafts_scene.remove(scene)
    fog.take_back_all()


def switch(scene: bpy.types.Scene) -> None:
    """Mute or unmute what there is; the first time it is switched on, set it up, where that can be done."""
    settings = scene.tyndall.over_engine
    if settings.is_enabled and not is_set_up(scene) and why_not(scene) is None:
        set_up(scene)  # which comes back here
        return
    for node in compositor.our_nodes(scene):
        node.mute = not settings.is_enabled
    fog.mute()


def problems(scene: bpy.types.Scene) -> list[str]:
    """Why F12 would not show light shafts as it should, each with its remedy, in an artist's words."""
    if not is_set_up(scene):
        return []
    found = [reason] if (reason := why_not(scene)) is not None else []
    found += compositor.problems(scene, shafts_scene_of(scene))
    if scene.camera is None:
        found.append("The scene has no camera")
    settings = scene.tyndall.over_engine
    if settings.view_layer and settings.view_layer not in scene.view_layers:
        found.append(f'There is no view layer "{settings.view_layer}": all are taken together')
    return found
