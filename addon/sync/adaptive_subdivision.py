# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether Cycles would cut an object's faces until they are about a pixel: here its modifier has the levels it says.

Up to Blender 4.5 the object says so, and the scene that what is experimental counts; from 5.0 on the modifier does. Of
an object's modifiers the last decides. What is displaced shows it most: with few levels, its shader has few vertices to
move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Object

    from .reports import Reports

NOTE = "is not subdivided adaptively: its modifier's levels are drawn, which may be raised"


def is_adaptive(thing: Object, depsgraph: Depsgraph) -> bool:
    """Of an evaluated object."""
    if not thing.modifiers or (last := thing.modifiers[-1]).type != "SUBSURF":
        return False
    if not (last.show_render if depsgraph.mode == "RENDER" else last.show_viewport):
        return False
    if hasattr(last, "use_adaptive_subdivision"):
        return bool(last.use_adaptive_subdivision)
    of_scene, of_object = (getattr(each, "cycles", None) for each in (depsgraph.scene_eval, thing))
    if of_scene is None or of_object is None:  # Cycles is switched off
        return False
    return of_scene.feature_set == "EXPERIMENTAL" and bool(of_object.use_adaptive_subdivision)


def note_adaptive(thing: Object, depsgraph: Depsgraph, reports: Reports) -> None:
    """What is drawn instead."""
    if is_adaptive(thing, depsgraph):
        reports.add(f'Object "{thing.name}"', NOTE)
