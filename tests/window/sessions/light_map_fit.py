# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints a stroke over the camera's picture with the mouse, and fits a sun's map to it, by the buttons of the sidebar.

Places are those of Blender 3.4's sidebar at its default width, in pixels from its right and its top, in a high window.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

from support.mouse import TAB, click, press, show_only, xdotool
from support.small_scenes import add, cube, light, material, node, plane


def stage() -> bpy.types.Object:
    """A sun straight above a metre of fog on the ground, that a camera looks down at; the sun is active."""
    scene = bpy.context.scene
    for thing in list(scene.objects):
        bpy.data.objects.remove(thing)
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y = 160, 120
    plane(half_side=4.0)
    fog = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.05).outputs["Volume"])
    box = cube("Fog", fog)
    box.location, box.scale = (0.0, 0.0, 0.5), (4.0, 4.0, 0.5)
    leaf = cube("Leaf")
    leaf.location, leaf.scale = (0.0, 0.0, 1.5), (0.3, 0.8, 0.02)
    scene.camera = add("Camera", bpy.data.cameras.new("Camera"), (0.0, 0.0, 6.0))
    sun = light("SUN", (0.0, 0.0, 5.0), energy=1.5)
    bpy.context.view_layer.objects.active = sun
    return sun


CLICKS = (
    "tyndall.paint_strokes",
    "tyndall.fit_light_map",
    "tyndall.continue_light_map",
    "tyndall.fit_view_add",
    "tyndall.fit_view_remove",
)
PANEL_HEADER, PAINT, FIT, CONTINUE = (100, 74), (136, 200), (161, 338), (83, 338)
ADD_VIEW, REMOVE_VIEW = (49, 104), (49, 125)
STROKE_PX = (150, 190), 434  #: x from and to, y: over the left of the picture.


def stroke(window: Any) -> Iterator[float]:
    """As a hand does it: each move an event of its own."""
    (begin, end), y = STROKE_PX
    xdotool("mousemove", begin, y)
    yield from window.settled()
    xdotool("mousedown", 1)
    for x in range(begin, end + 1, 4):
        xdotool("mousemove", x, y)
        yield from window.settled()
    xdotool("mouseup", 1)
    yield from window.calm()


def is_fitting() -> bool:
    return any(thread.name == "tyndall fit" for thread in threading.enumerate())


def begin_endless_fit(window: Any) -> Iterator[float]:
    from addon.fitted_maps import PreparedFit

    def endless(_fit: PreparedFit, progress: Any) -> None:
        progress.message = "a fit that never ends"
        while True:
            progress.poll()
            time.sleep(0.01)

    whole, PreparedFit.run = PreparedFit.run, endless
    yield from click(window, FIT, is_calm_then=False)
    yield from window.until(is_fitting)
    yield 0.5
    PreparedFit.run = whole


def stop_a_fit(window: Any) -> Iterator[float]:
    """One that would never end, by Esc."""
    yield from begin_endless_fit(window)
    window.screenshot("light_map_fit_running")
    xdotool("key", "Escape")
    yield from window.until(lambda: not is_fitting())
    yield from window.calm()


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    sun = stage()
    brush = bpy.data.brushes["TexDraw"]
    brush.color, brush.size, brush.strength = (1.0, 0.0, 0.0), 20, 1.0
    bpy.ops.ed.undo_push(message="begin")
    show_only("TYNDALL_PT_light_map_fit")
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    yield from window.calm()
    yield from click(window, TAB)
    yield from click(window, PANEL_HEADER)
    yield from click(window, PAINT)
    window.screenshot("light_map_fit_backdrop")
    yield from stroke(window)
    window.screenshot("light_map_fit_stroke")
    name = sun.name
    window.facts["painted"] = texels_of(sun.data.tyndall.light_map_fit.views[0].strokes)[..., 3].mean().item()
    yield from stop_a_fit(window)
    window.facts["stopped"] = sun.data.tyndall.gobo_image is None
    yield from click(window, FIT)
    yield from window.until(lambda: bpy.data.objects[name].data.tyndall.gobo_image is not None)
    yield from window.calm()
    settings = bpy.data.objects[name].data.tyndall
    window.facts["steps"] = [len(settings.light_map_fit.residuals.split()) - 1]
    texels = texels_of(settings.gobo_image)[..., :3].reshape(-1, 3)
    window.facts["reddest"] = texels[np.argmax(texels[:, 0] - texels[:, 2])].tolist()
    window.screenshot("light_map_fit_fitted")
    yield from click(window, CONTINUE)
    window.facts["steps"].append(len(settings.light_map_fit.residuals.split()) - 1)
    window.screenshot("light_map_fit_continued")
    for key in ("ctrl+z", "ctrl+z", "ctrl+shift+z"):
        xdotool("mousemove", 500, 700)
        yield from window.settled()
        yield from press(window, (key,))
        settings = bpy.data.objects[name].data.tyndall
        window.facts.setdefault("gobo", []).append(settings.gobo_image is not None)
    for place in (ADD_VIEW, REMOVE_VIEW):
        yield from click(window, place)
        window.facts.setdefault("views", []).append(len(bpy.data.objects[name].data.tyndall.light_map_fit.views))
        window.screenshot(f"light_map_fit_views_{len(window.facts['views'])}")
    yield from begin_endless_fit(window)  # amid which Blender is closed: seen to hang, where nothing told it to end


def texels_of(image: bpy.types.Image) -> np.ndarray:
    values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)
