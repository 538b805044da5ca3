# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints the air with the mouse, in the 3D view: from the panel and from the toolbar, with every key, undo and redo.

Places in the view are shares of it, from its left and its bottom; those in the sidebar are for Blender 3.4's at its
default width, in which our other panels are away.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import Any

import bpy
import numpy as np

from support.mouse import TAB, click, press, xdotool

CLICKS = ("tyndall.paint_air",)
PAINT_BUTTON = (120, 71)


def paint_in_box() -> list[float]:
    """How far its voxels are from neutral, on average: intensity, amount, level."""
    from addon.painted_air import read_volume

    box = bpy.data.objects["Painted Air"]
    means = []
    for name, neutral in (("intensity", 1.0), ("amount", 0.0), ("level", 0.0)):
        values = read_volume(box, name)
        means.append(0.0 if values is None else float(np.abs(values - neutral).mean()))
    return means


def is_painting() -> bool:
    from addon.air_painting import active_painting

    return active_painting() is not None


def brush() -> Any:
    return bpy.context.scene.tyndall.air_brush


def place_px(window: Any, share: tuple[float, float]) -> tuple[int, int]:
    """In pixels from the window's left and top."""
    region = window.region("VIEW_3D")
    x = region.x + int(share[0] * region.width)
    return x, window.bpy_window.height - region.y - int(share[1] * region.height)


def hover(window: Any, share: tuple[float, float]) -> Iterator[float]:
    x, y = place_px(window, share)
    xdotool("mousemove", x - 3, y)
    yield from window.settled()
    xdotool("mousemove", x, y)
    yield from window.settled()


def drag(window: Any, shares: Sequence[tuple[float, float]], *, button: int = 1, held: str = "") -> Iterator[float]:
    """From place to place, straight."""
    yield from hover(window, shares[0])
    if held:
        xdotool("keydown", held)
        yield from window.settled()
    xdotool("mousedown", button)
    yield from window.settled()
    for (x0, y0), (x1, y1) in pairwise(shares):
        for step in range(1, 5):
            xdotool("mousemove", *place_px(window, (x0 + (x1 - x0) * step / 4, y0 + (y1 - y0) * step / 4)))
            yield from window.settled()
    xdotool("mouseup", button)
    yield from window.settled()
    if held:
        xdotool("keyup", held)
    yield from window.calm()


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    bpy.context.scene.render.engine = "TYNDALL"
    bpy.ops.tyndall.add_fog_box(with_camera_and_lights=False, margin=0.5)
    bpy.ops.tyndall.add_painted_box(voxels=64)
    brush().opacity = 1.0
    bpy.ops.ed.undo_push(message="begin")
    show_our_panel_alone(window)
    yield from window.calm()
    yield from click(window, TAB)
    window.screenshot("paint_air_panel")
    window.facts.update(painted={}, brush={})
    yield from click(window, PAINT_BUTTON)
    window.facts["begun"] = is_painting()
    yield from paint(window)
    yield from use_keys(window)
    yield from look_around(window)
    yield from leave(window)
    yield from use_tool(window)
    yield from reload(window)


def show_our_panel_alone(window: Any) -> None:
    """Open; the others of its tab are away for this session."""
    from addon import panels
    from addon.panels.base import SidebarPanel

    window.area("VIEW_3D").spaces[0].show_region_ui = True
    ours = panels.paint_air.CLASSES
    for cls in reversed(panels.CLASSES):
        if issubclass(cls, SidebarPanel):
            bpy.utils.unregister_class(cls)
    parent, *children = ours
    del parent.bl_parent_id
    parent.bl_options = set()
    for cls in (parent, *children):
        cls.bl_options = set()
        bpy.utils.register_class(cls)
    panels.CLASSES = tuple(cls for cls in panels.CLASSES if not issubclass(cls, SidebarPanel) or cls in ours)


def paint(window: Any) -> Iterator[float]:
    """A stroke, one that erases, undo and redo of both, one that smooths, one outside of the box."""
    painted = window.facts["painted"]
    yield from drag(window, [(0.3, 0.4), (0.5, 0.6), (0.6, 0.4)])
    painted["stroke"] = paint_in_box()
    window.screenshot("paint_air_stroke")
    yield from drag(window, [(0.4, 0.3), (0.4, 0.7)], held="ctrl")
    painted["erase"] = paint_in_box()
    for step, keys in (
        ("undo erase", ("ctrl+z",)),
        ("undo stroke", ("ctrl+z",)),
        ("redo stroke", ("ctrl+shift+z",)),
    ):
        yield from press(window, keys)
        painted[step] = paint_in_box()
    yield from drag(window, [(0.35, 0.45), (0.5, 0.6)], held="shift")
    painted["smooth"] = paint_in_box()
    yield from drag(window, [(0.1, 0.2), (0.1, 0.3)])
    painted["outside"] = paint_in_box()
    window.screenshot("paint_air_outside")


def use_keys(window: Any) -> Iterator[float]:
    """F and its companions: what follows the mouse is kept by a click, and brought back by Esc."""
    sizes = window.facts["brush"]
    for name, key, end in (
        ("radius_m", "f", "click"),
        ("opacity", "shift+f", "click"),
        ("hardness", "ctrl+f", "click"),
        ("depth", "alt+f", "Escape"),
    ):
        yield from hover(window, (0.45, 0.5))
        before = getattr(brush(), name)
        yield from press(window, (key,))
        yield from hover(window, (0.42 if name == "opacity" else 0.47, 0.5))  # it begins at 1
        if name == "radius_m":
            window.screenshot("paint_air_dial")
        during = getattr(brush(), name)
        if end == "click":
            xdotool("click", 1)
            yield from window.calm()
        else:
            yield from press(window, (end,))
        sizes[name] = [before, during, getattr(brush(), name)]
    before = brush().radius_m
    yield from press(window, ("bracketright",))
    sizes["]"] = brush().radius_m / before
    window.facts["still painting"] = is_painting()


def look_around(window: Any) -> Iterator[float]:
    """The wheel slides the plane while Ctrl is held; without it, and with the middle button, the view moves."""
    from addon.air_painting import active_painting

    facts = window.facts
    view = window.region("VIEW_3D").data
    yield from hover(window, (0.45, 0.5))
    plane = active_painting().plane
    depths = [plane.depth_in_box(view)]
    xdotool("keydown", "ctrl", "click", "--repeat", 6, 4, "keyup", "ctrl")
    yield from window.calm()
    depths.append(plane.depth_in_box(view))
    yield from press(window, ("Down", "Down"))
    depths.append(plane.depth_in_box(view))
    yield from hover(window, (0.51, 0.5))
    yield from press(window, ("s",))  # the cube's surface is nearer than the middle
    depths.append(plane.depth_in_box(view))
    facts["depths"] = depths
    window.screenshot("paint_air_surface")
    before = view.view_rotation.copy()
    yield from drag(window, [(0.5, 0.5), (0.65, 0.6)], button=2)
    facts["turned_rad"] = before.rotation_difference(window.region("VIEW_3D").data.view_rotation).angle
    brush().volume, brush().amount, brush().opacity = "AMOUNT", 1.0, 0.7
    yield from press(window, ("Up",) * 12)
    yield from drag(window, [(0.4, 0.5), (0.5, 0.45), (0.55, 0.55)])
    facts["painted"]["amount"] = paint_in_box()
    window.screenshot("paint_air_amount")


def leave(window: Any) -> Iterator[float]:
    yield from hover(window, (0.45, 0.5))
    yield from press(window, ("Escape",))
    window.facts["painting after Esc"] = is_painting()


def use_tool(window: Any) -> Iterator[float]:
    """The first press in the view paints; another tool ends it."""
    area = window.area("VIEW_3D")
    with bpy.context.temp_override(window=window.bpy_window, area=area, region=window.region("VIEW_3D")):
        bpy.ops.wm.tool_set_by_id(name="tyndall.paint_air_tool")
    yield from window.calm()
    brush().volume = "LEVEL"
    yield from drag(window, [(0.4, 0.5), (0.5, 0.5)])
    window.facts["painted"]["by tool"] = paint_in_box()
    window.screenshot("paint_air_by_tool")
    with bpy.context.temp_override(window=window.bpy_window, area=area, region=window.region("VIEW_3D")):
        bpy.ops.wm.tool_set_by_id(name="builtin.select_box")
    yield from hover(window, (0.4, 0.45))
    yield from window.calm()
    window.facts["painting after another tool"] = is_painting()


def reload(window: Any) -> Iterator[float]:
    """While it goes on: the file has all strokes, and the painting ends."""
    area = window.area("VIEW_3D")
    with bpy.context.temp_override(window=window.bpy_window, area=area, region=window.region("VIEW_3D")):
        bpy.ops.tyndall.paint_air("INVOKE_DEFAULT")
    yield from window.calm()
    path = str(window.folder / "painted.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with suppress(RuntimeError):  # the operator's window is gone when it ends
        bpy.ops.wm.open_mainfile(filepath=path)
    yield from window.calm()
    window.facts["painting after reload"] = is_painting()
    window.facts["painted"]["reload"] = paint_in_box()
