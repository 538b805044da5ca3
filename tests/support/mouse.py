# SPDX-License-Identifier: GPL-3.0-or-later
"""A person's hands in Blender's window: clicks and keys, as sessions of the window tests use them."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from typing import Any

import bpy

#: Of the tab Light Shafts, in pixels from the sidebar's right and its top.
TAB = (8, 140)


def xdotool(*words: object) -> None:
    subprocess.run(["xdotool", *map(str, words)], check=True)


def click_at(window: Any, x: int, y: int, *, held: str = "", is_calm_then: bool = True) -> Iterator[float]:
    """In pixels from the window's left and top, with a key held down. Not calm: where it begins what draws steadily."""
    xdotool("mousemove", x - 3, y)
    yield from window.settled()  # one by one: Blender handles no event before this, and skips moves that wait
    xdotool("mousemove", x, y)
    yield from window.settled()
    if held:
        xdotool("keydown", held, "click", 1, "keyup", held)
    else:
        xdotool("click", 1)
    yield from window.settled()
    if is_calm_then:
        yield from window.calm()


def click(window: Any, place: tuple[int, int], *, is_calm_then: bool = True) -> Iterator[float]:
    """In pixels from the right and the top of the 3D view's sidebar."""
    sidebar = next(region for region in window.area("VIEW_3D").regions if region.type == "UI")
    from_right, from_top = place
    x = sidebar.x + sidebar.width - from_right
    y = window.bpy_window.height - (sidebar.y + sidebar.height) + from_top
    yield from click_at(window, x, y, is_calm_then=is_calm_then)


def through_browser(window: Any, button: tuple[int, int], name: str) -> Iterator[float]:
    """Open Blender's file browser by a button, and agree to what it proposes by its own: at the lower right."""
    yield from click(window, button)
    yield 0.5
    yield from window.calm()
    window.screenshot(name)
    area = window.area("FILE_BROWSER")
    yield from click_at(window, area.x + area.width - 73, window.bpy_window.height - area.y - 18)
    yield 0.5
    yield from window.calm()


def press(window: Any, keys: tuple[str, ...]) -> Iterator[float]:
    for key in keys:
        xdotool("key", key)
        yield from window.settled()
    if keys:
        yield from window.calm()


def show_only(name: str) -> None:
    """Take the tab's other panels away, less what this one is within: where things are does not depend on them then.

    What an earlier call took away is there again.
    """
    from addon.panels import CLASSES  # noqa: PLC0415  where it is registered

    of_tab = [cls for cls in CLASSES if getattr(cls, "bl_category", "") == "Light Shafts"]
    for cls in of_tab:
        if not cls.is_registered:
            bpy.utils.register_class(cls)
    within = {cls.__name__: getattr(cls, "bl_parent_id", "") for cls in of_tab}

    def line(panel: str) -> list[str]:
        return [panel, *line(within[panel])] if panel else []

    for cls in reversed(of_tab):
        if cls.__name__ not in line(name) and name not in line(cls.__name__):
            bpy.utils.unregister_class(cls)
