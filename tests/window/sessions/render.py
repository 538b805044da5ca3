# SPDX-License-Identifier: GPL-3.0-or-later
"""F12, as the Render menu calls it; then Esc in the middle of a long render."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from typing import Any

import bpy

from support.beam_scene import build_beam_scene


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    scene = build_beam_scene()
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    ended: list[str] = []
    bpy.app.handlers.render_complete.append(lambda *_: ended.append("complete"))
    bpy.app.handlers.render_cancel.append(lambda *_: ended.append("cancel"))
    bpy.ops.wm.save_as_mainfile(filepath=str(window.folder / "scene.blend"))
    with bpy.context.temp_override(window=window.bpy_window):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from window.until(lambda: bool(ended) and not bpy.app.is_job_running("RENDER"))
    window.facts["first"] = ended.pop()
    yield from window.calm()
    window.screenshot("render")
    bpy.data.images["Render Result"].save_render(str(window.folder / "window.exr"), scene=scene)

    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 65536, 0.0
    with bpy.context.temp_override(window=window.bpy_window):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from window.until(lambda: bpy.app.is_job_running("RENDER"))
    yield 2.0
    window.facts["ended_before_escape"] = list(ended)
    started = time.monotonic()
    window_id = subprocess.run(
        ["xdotool", "search", "--onlyvisible", "--name", "Blender"], capture_output=True, text=True, check=True
    ).stdout.split()[-1]
    subprocess.run(["xdotool", "mousemove", "600", "400", "key", "--window", window_id, "Escape"], check=True)
    yield from window.until(lambda: bool(ended))
    window.facts["second"] = ended.pop()
    window.facts["escape_s"] = time.monotonic() - started
    window.screenshot("render_cancelled")
