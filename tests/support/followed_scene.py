# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's scene as a viewport follows it, without a window."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy

from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from tyndall import Progress
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import Camera, SceneDescription

CONFIG = RenderConfig(pixel_samples=1, passes=frozenset({"Shadow", "Normal", "Position"}))


class Followed:
    """A reader and a session that hear of every update."""

    def __init__(self, session: Session | None = None) -> None:
        self._reader = SceneReader()
        self._session = session or Session(follows_moves=True, keeps_trees=True)

    @contextmanager
    def hears(self) -> Iterator[None]:
        def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
            self._reader.note_updates(depsgraph)

        handlers = bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.frame_change_post
        for events in handlers:
            events.append(note)
        try:
            yield
        finally:
            for events in handlers:
                events.remove(note)

    def read(self) -> SceneDescription:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return self._reader.read(depsgraph, Reports(), lambda: None, is_live=True)

    def update(self, description: SceneDescription) -> bool:
        """Whether the native scene was not built anew, though something moved."""
        self._session.update(description, Progress())
        return bool(self._session.statistics["counts"]["scene moved"])

    def picture(self, camera: Camera) -> dict[str, Any]:
        return self._session.render(camera, CONFIG, Progress()).planes
