# SPDX-License-Identifier: GPL-3.0-or-later
"""Native sessions: of viewports, of tools, and of final renders, which keep them from frame to frame.

Of the last, one per scene and view layer, with what was read of Blender's scene. All end with the render, unless the
scene asks for persistent data.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy
from bpy.app.handlers import persistent

from tyndall import Progress
from tyndall.renderer import Session

from ..sync.images import ImageReader
from ..sync.reports import Reports
from ..sync.scene import SceneReader
from .settings import KEPT_MAPS_BYTES, KEPT_SURFACES_BYTES

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Scene


@dataclass(eq=False)
class KeptFrame:
    """The two sides of a sync: keys that the reader promises are keys that the session keeps."""

    session: Session
    reader: SceneReader = field(default_factory=SceneReader)
    function_images: ImageReader = field(default_factory=ImageReader)


_kept: dict[tuple[str, str], KeptFrame] = {}


def kept_frame(scene_name: str, view_layer_name: str, *, keeps_maps: bool, follows_moves: bool) -> KeptFrame:
    """What a view layer kept. Lights' maps are part of it, if asked for, or from the second frame on.

    Blender says of the scene it was asked to render that it is an animation, and not of others beside it.
    """
    kept = _kept.get((scene_name, view_layer_name))
    if kept is None:
        maps_bytes = KEPT_MAPS_BYTES if keeps_maps else 0
        kept = KeptFrame(session=Session(kept_maps_bytes=maps_bytes, follows_moves=follows_moves))
        _kept[scene_name, view_layer_name] = kept
    else:
        kept.session.keep_maps(KEPT_MAPS_BYTES)
    return kept


def viewport_session() -> Session:
    """That of one viewport, which shows picture after picture of a scene that is edited."""
    return Session(
        kept_pictures=1,
        kept_maps_bytes=KEPT_MAPS_BYTES,
        kept_surfaces_bytes=KEPT_SURFACES_BYTES,
        follows_moves=True,
        keeps_trees=True,
        builds_hastily=True,
    )


def session_of(depsgraph: Depsgraph) -> Session:
    """A session of its own with the scene as it is now, for a tool that asks once."""
    session = Session()
    session.update(SceneReader().read(depsgraph, Reports(), lambda: None), Progress())
    return session


def release(scene_name: str) -> None:
    for key in [key for key in _kept if key[0] == scene_name]:
        del _kept[key]


@persistent
def _end_of_render(scene: Scene, _: object = None) -> None:
    if not scene.render.use_persistent_data:
        release(scene.name)


@persistent
def _before_another_file(_: object = None, __: object = None) -> None:
    _kept.clear()


_HANDLERS = (
    ("render_complete", _end_of_render),
    ("render_cancel", _end_of_render),
    ("load_pre", _before_another_file),
)


def register() -> None:
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)


def unregister() -> None:
    for event, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, event)
        if handler in handlers:
            handlers.remove(handler)
    _kept.clear()
