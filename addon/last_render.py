# SPDX-License-Identifier: GPL-3.0-or-later
"""What each scene's last final render did: kept in memory only, written by the engine, shown by a panel.

The engine runs off the main thread and must not write Blender data there; replacing an entry of a dictionary is atomic.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent

_statistics_by_scene: dict[str, dict[str, Any]] = {}


def record(scene_name: str, statistics: dict[str, Any]) -> None:
    """Keep the statistics of a finished film: ``stages``, ``skipped``, ``counts`` and ``reports``."""
    _statistics_by_scene[scene_name] = statistics


def statistics_of(scene_name: str) -> dict[str, Any] | None:
    """Statistics of the scene's last render in this session of Blender, if there was one."""
    return _statistics_by_scene.get(scene_name)


@persistent
def _forget_all(_path: object = None) -> None:
    """Forget every render: another file has been opened, whose scenes may have the same names."""
    _statistics_by_scene.clear()


def register() -> None:
    bpy.app.handlers.load_post.append(_forget_all)


def unregister() -> None:
    bpy.app.handlers.load_post.remove(_forget_all)
    _statistics_by_scene.clear()
