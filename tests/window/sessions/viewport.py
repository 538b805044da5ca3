# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading in the camera's view, in a free view while it turns, and after its area is gone."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import bpy
import numpy as np
from mathutils import Quaternion

from support.beam_scene import build_beam_scene

THREAD_NAME = "tyndall viewport"


def thread_count() -> int:
    return sum(thread.name == THREAD_NAME for thread in threading.enumerate())


def set_up(window: Any) -> tuple[bpy.types.Scene, bpy.types.SpaceView3D]:
    """The scene, seen without anything that Blender draws over it."""
    scene = build_beam_scene()
    space = window.area("VIEW_3D").spaces[0]
    space.overlay.show_overlays = space.show_gizmo = space.show_region_toolbar = space.show_region_header = False
    space.show_region_tool_header = False
    # A free view from the camera's place: the camera's own view would draw its frame over the picture.
    space.region_3d.view_perspective = "PERSP"
    space.region_3d.view_matrix = scene.camera.matrix_world.inverted()
    space.shading.type = "RENDERED"
    return scene, space


def show_timings(
    window: Any, scene: bpy.types.Scene, worker: Callable[[], Any], finished: Callable[[], Iterator[float]]
) -> Iterator[float]:
    """What a changed light took and what was used again; small, and as large as an artist may have texts."""
    scene.tyndall.shows_viewport_work = True
    yield from finished()
    bpy.data.lights["Lamp"].energy *= 1.5
    yield 0.1
    yield from finished()
    window.screenshot("viewport_timings")
    window.facts["work"] = worker().work.statistics["counts"]
    view = bpy.context.preferences.view
    view.ui_scale = 2.0
    window.area("VIEW_3D").tag_redraw()
    yield from window.calm()
    window.screenshot("viewport_timings_large")
    view.ui_scale = 1.0
    scene.tyndall.shows_viewport_work = False


def show_passes(
    window: Any, space: bpy.types.SpaceView3D, worker: Callable[[], Any], finished: Callable[[], Iterator[float]]
) -> Iterator[float]:
    """One in place of the picture, and the picture again: what surfaces are like knows no lamp."""
    for name in ("DIFFUSE_COLOR", "COMBINED"):
        space.shading.tyndall.render_pass = name
        yield 0.1
        yield from finished()
        window.screenshot(f"viewport_{name.lower()}")
        mean = worker().picture.rgba.mean(axis=(0, 1))
        window.facts[f"red_over_blue of {name}"] = float(mean[0] / mean[2])


def session(window: Any) -> Iterator[float]:
    from addon.engine import viewport

    yield from window.calm()
    scene, space = set_up(window)
    area = window.area("VIEW_3D")

    def worker() -> Any:
        return next(iter(viewport.open_viewports.values())).worker

    def finished() -> Iterator[float]:
        yield from window.until(lambda: bool(viewport.open_viewports))
        yield from window.until(lambda: worker().picture is not None and not worker().status, at_most_s=300)
        yield from window.calm()

    yield from finished()
    region = window.region("VIEW_3D")
    window.screenshot("viewport")
    np.save(window.folder / "picture.npy", worker().picture.rgba)
    window.facts.update(
        region=[region.x, region.y, region.width, region.height], window_height=window.bpy_window.height
    )

    # A change of the scene arrives by itself.
    before = worker().picture.rgba.sum()
    bpy.data.lights["Lamp"].color = (1.0, 0.2, 0.1)
    yield 0.1
    yield from window.until(lambda: worker().picture.rgba.sum() != before)
    yield from finished()
    window.screenshot("viewport_red")
    mean = worker().picture.rgba.mean(axis=(0, 1))
    window.facts["red_over_blue"] = float(mean[0] / mean[2])

    yield from show_passes(window, space, worker, finished)
    yield from show_timings(window, scene, worker, finished)

    # So many samples that a picture takes long: the window must answer meanwhile.
    scene.tyndall.viewport_samples = 2
    space.region_3d.view_perspective = "CAMERA"
    yield 0.1
    started = time.monotonic()
    yield from finished()
    window.facts["picture_s"] = time.monotonic() - started
    window.screenshot("viewport_camera")
    space.region_3d.view_perspective = "PERSP"
    window.start_watch()
    pictures = {}  # by id, and kept: where one was, the next may come to lie
    turn = Quaternion((0, 0, 1), 0.02)
    for _ in range(40):
        space.region_3d.view_rotation = turn @ space.region_3d.view_rotation
        yield 0.03
        pictures[id(worker().picture.rgba)] = worker().picture.rgba
    window.facts["longest_gap_s"] = window.longest_gap_s()
    window.facts["pictures_while_turning"] = len(pictures)

    window.facts["threads_before"] = thread_count()
    area.type = "TEXT_EDITOR"
    yield from window.until(lambda: thread_count() == 0, at_most_s=20)
    area.type = "VIEW_3D"
    yield 0.1
    area.spaces[0].shading.type = "RENDERED"
    yield from finished()
    bpy.ops.wm.read_factory_settings()  # opening a file in the middle
    yield from window.until(lambda: thread_count() == 0, at_most_s=20)
    window.facts["threads_after"] = thread_count()
