# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints the air with the mouse, in the 3D view: strokes, eraser, smoothing, the keys, undo and redo, save and reload.

Places in the view are shares of it, from its left and its bottom.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import bpy
import numpy as np

from support.mouse import TAB, click, press, xdotool


def painted() -> list[float]:
    """How much there is of each volume, as shares of the box that are not neutral: intensity, amount, level."""
    from addon.painted_air import read_volume

    box = bpy.data.objects["Painted Air"]
    shares = []
    for name, neutral in (("intensity", 1.0), ("amount", 0.0), ("level", 0.0)):
        values = read_volume(box, name)
        shares.append(0.0 if values is None else float(np.mean(values != neutral)))
    return shares


def place_px(window: Any, share: tuple[float, float]) -> tuple[int, int]:
    """In pixels from the window's left and top."""
    region = window.region("VIEW_3D")
    x = region.x + int(share[0] * region.width)
    return x, window.bpy_window.height - region.y - int(share[1] * region.height)


def hover(window: Any, share: tuple[float, float]) -> Iterator[float]:
    x, y = place_px(window, share)
    xdotool("mousemove", x - 3, y)
    yield 0.2
    xdotool("mousemove", x, y)
    yield 0.3


def drag(window: Any, shares: Sequence[tuple[float, float]], *, held: str = "") -> Iterator[float]:
    """With the left button, from place to place, straight."""
    yield from hover(window, shares[0])
    if held:
        xdotool("keydown", held)
        yield 0.2
    xdotool("mousedown", 1)
    yield 0.2
    for one, other in pairwise(shares):
        for step in range(1, 9):
            t = step / 8
            xdotool(
                "mousemove", *place_px(window, (one[0] + (other[0] - one[0]) * t, one[1] + (other[1] - one[1]) * t))
            )
            yield 0.05
    yield 0.2
    xdotool("mouseup", 1)
    yield 0.3
    if held:
        xdotool("keyup", held)
    yield from window.calm()


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    bpy.data.objects["Cube"].location = (0.0, 0.0, 0.0)
    bpy.ops.tyndall.add_fog_box(with_camera_and_lights=False, margin=0.5)
    bpy.ops.tyndall.add_painted_box(voxels=64)
    scene.tyndall.air_brush.opacity = 1.0
    bpy.ops.ed.undo_push(message="begin")
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    yield from window.calm()
    yield from click(window, TAB)
    window.screenshot("paint_air_before")
    yield from paint(window)


def paint(window: Any) -> Iterator[float]:
    facts = window.facts
    facts["painted"] = {}
    yield from hover(window, (0.45, 0.5))
    area = window.area("VIEW_3D")
    with bpy.context.temp_override(window=window.bpy_window, area=area, region=window.region("VIEW_3D")):
        facts["invoked"] = list(bpy.ops.tyndall.paint_air("INVOKE_DEFAULT"))
    yield from window.calm()
    window.screenshot("paint_air_tool")
    yield from drag(window, [(0.3, 0.4), (0.5, 0.6), (0.6, 0.4)])
    facts["painted"]["stroke"] = painted()
    window.screenshot("paint_air_stroke")
    yield from drag(window, [(0.4, 0.3), (0.4, 0.7)], held="ctrl")
    facts["painted"]["erase"] = painted()
    window.screenshot("paint_air_erase")
    yield from press(window, ("ctrl+z",))
    facts["painted"]["undo erase"] = painted()
    yield from press(window, ("ctrl+z",))
    facts["painted"]["undo stroke"] = painted()
    window.screenshot("paint_air_undo")
    yield from press(window, ("ctrl+shift+z",))
    facts["painted"]["redo stroke"] = painted()
    window.screenshot("paint_air_redo")
