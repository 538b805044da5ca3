# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets light shafts up over Cycles by the mouse, renders with F12, switches them off, and ends a render by Esc.

Places are those of Blender 3.4's Render properties in a window of 1000 x 900, in pixels from its left and top.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

from support.beam_scene import build_beam_scene
from support.mouse import click_at, press, xdotool

CLICKS = ("tyndall.over_engine_set_up", "tyndall.leave_fog", "tyndall.over_engine_remove")
HEADER, SET_UP = (140, 767), (436, 515)
SWITCH, LEAVE_FOG, REMOVE = (66, 448), (245, 573), (626, 573)


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    scene = build_beam_scene()
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.max_bounces = "CPU", 16, 0
    scene.cycles.use_denoising = False
    bpy.context.preferences.view.render_display_type = "NONE"
    area = window.area("VIEW_3D")
    area.type = "PROPERTIES"
    yield from window.calm()  # its tabs exist once it has been drawn
    area.spaces[0].context = "RENDER"
    bpy.ops.ed.undo_push(message="begin")
    yield from window.calm()
    yield from click_at(window, *HEADER, held="ctrl")  # opens it, and closes all others
    yield from use_every_button(window)
    yield from render_frames(window)


def state() -> list[object]:
    """Whether it is on, the file's scenes, and the fog's nodes."""
    from addon.over_engine import fog

    is_enabled = bpy.data.scenes["Scene"].tyndall.over_engine.is_enabled
    return [is_enabled, sorted(bpy.data.scenes.keys()), [node.mute for _, node in fog.left_nodes()]]


def use_every_button(window: Any) -> Iterator[float]:
    window.facts["steps"] = {}
    steps = (
        ("set up", SET_UP, ()),
        ("leave fog", LEAVE_FOG, ()),
        ("off", SWITCH, ()),
        ("on", SWITCH, ()),
        ("remove", REMOVE, ()),
        ("undo", None, ("ctrl+z",)),
    )
    for step, place, keys in steps:
        if place is not None:
            yield from click_at(window, *place)
        yield from press(window, keys)
        window.facts["steps"][step] = state()
        window.screenshot(f"over_engine_{step.replace(' ', '_')}")


def pixels_of_render(window: Any) -> np.ndarray:
    path = str(window.folder / "over_engine.exr")
    scene = bpy.data.scenes["Scene"]
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    bpy.data.images["Render Result"].save_render(path, scene=scene)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels)
    bpy.data.images.remove(image)
    return pixels


def end_of_render(window: Any, *, escape_after_s: float = 0.0) -> Iterator[float]:
    """Wait for it; the window is never calm while both cores render."""
    ends: list[str] = window.facts.setdefault("ends", [])
    known = len(ends)
    if escape_after_s > 0.0:
        yield from window.until(lambda: bpy.app.is_job_running("RENDER") or len(ends) > known)
        yield escape_after_s
        xdotool("key", "Escape")
    yield from window.until(lambda: len(ends) > known and not bpy.app.is_job_running("RENDER"), at_most_s=300.0)


def render_frames(window: Any) -> Iterator[float]:
    """F12 with and without light shafts, and Ctrl-F12 with another camera from the second frame on; then Esc."""
    scene = bpy.data.scenes["Scene"]
    area = window.area("PROPERTIES")
    ends = window.facts["ends"] = []
    bpy.app.handlers.render_complete.append(lambda *_: ends.append("complete"))
    bpy.app.handlers.render_cancel.append(lambda *_: ends.append("cancel"))
    window.facts["levels"] = []
    for is_enabled in (True, False):
        scene.tyndall.over_engine.is_enabled = is_enabled
        xdotool("key", "F12")
        yield from end_of_render(window)
        window.facts["levels"].append(float(pixels_of_render(window).mean()))
        area.type = "IMAGE_EDITOR"
        area.spaces[0].image = bpy.data.images["Render Result"]
        yield from window.calm()
        window.screenshot(f"over_engine_render_{'on' if is_enabled else 'off'}")
        area.type = "PROPERTIES"
    scene.tyndall.over_engine.is_enabled = True
    scene.frame_end, scene.cycles.samples = 8, 1
    scene.render.filepath = str(window.folder / "over_engine_frame_")
    scene.timeline_markers.new("first", frame=1).camera = scene.camera
    second = scene.camera.copy()
    second.location.x += 1.0
    scene.collection.objects.link(second)
    scene.timeline_markers.new("second", frame=2).camera = second
    xdotool("key", "ctrl+F12")
    yield from end_of_render(window)
    window.facts["frames"] = len(list(window.folder.glob("over_engine_frame_*.exr")))
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 65536, 0.0
    xdotool("key", "F12")
    yield from end_of_render(window, escape_after_s=4.0)
