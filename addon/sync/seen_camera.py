# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's camera as materials may read it: a window's own view is not sent with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mathutils import Matrix

from tyndall.scene_description import CameraKind

from .cameras import read_camera
from .reports import Reports

if TYPE_CHECKING:
    from bpy.types import Depsgraph

_PERCENT = 0.01


@dataclass(frozen=True)
class SeenCamera:
    """Where a surface lies before the camera, and in its picture."""

    from_world: Matrix  #: Without scale; it looks along +Z, as Cycles has it.
    is_perspective: bool
    is_panorama: bool  #: Its window is in units of its own.
    left: float  #: Of the window one metre ahead, or, of an orthographic camera, in metres.
    right: float
    bottom: float
    top: float


def seen_camera(depsgraph: Depsgraph) -> SeenCamera | None:
    """None without one, or with one that nothing can be seen through."""
    scene = depsgraph.scene_eval
    camera = scene.camera
    if camera is None:
        return None
    render = scene.render
    size_px = tuple(
        max(1, int(side * render.resolution_percentage * _PERCENT))
        for side in (render.resolution_x, render.resolution_y)
    )
    try:
        read = read_camera(camera.evaluated_get(depsgraph), render, (size_px[0], size_px[1]), Reports())
    except ValueError:
        return None
    from_world = Matrix(read.world_from_camera.tolist()).inverted_safe()
    from_world[2] = -from_world[2]
    left, right, bottom, top = read.window
    return SeenCamera(
        from_world=from_world,
        is_perspective=read.kind == CameraKind.PERSPECTIVE,
        is_panorama=read.kind == CameraKind.PANORAMIC,
        left=left,
        right=right,
        bottom=bottom,
        top=top,
    )
