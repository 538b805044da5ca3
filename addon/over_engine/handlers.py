# SPDX-License-Identifier: GPL-3.0-or-later
"""When the scenes of light shafts are brought in step with their masters.

Blender calls handlers of a render in the window off the main thread, where nothing may be linked: there only the camera
follows, and all else has followed before, when the window heard of the change.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import bpy
from bpy.app.handlers import persistent

from ..granted_writes import write
from .shafts_scene import follow_frame, keep_in_step, shafts_scene_of

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Scene


def _is_main_thread() -> bool:
    return threading.get_ident() == threading.main_thread().ident


@persistent
def _on_change(scene: Scene, depsgraph: Depsgraph) -> None:
    """Objects that move change neither scene nor collections, and cost nothing here."""
    if not _is_main_thread() or not (depsgraph.id_type_updated("SCENE") or depsgraph.id_type_updated("COLLECTION")):
        return
    _bring_in_step(scene)


@persistent
def _before_render(scene: Scene, _: object = None) -> None:
    """A script may render right after a change, of which nobody has told the window."""
    if _is_main_thread():
        _bring_in_step(scene)


@persistent
def _before_frame(scene: Scene, _: object = None) -> None:
    shafts = shafts_scene_of(scene.original)
    if shafts is not None:
        write(lambda: follow_frame(scene.original, shafts))


def _bring_in_step(scene: Scene) -> None:
    shafts = shafts_scene_of(scene.original)
    if shafts is not None and shafts.library is None:
        write(lambda: keep_in_step(scene.original, shafts))


_HANDLERS = (
    ("depsgraph_update_post", _on_change),
    ("render_init", _before_render),
    ("render_pre", _before_frame),
)


def register() -> None:
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)


def unregister() -> None:
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).remove(handler)
