# SPDX-License-Identifier: GPL-3.0-or-later
"""Clicks once on everything in the list of a light's occluder edits, in the 3D view's sidebar; then looks at each edit.

Places are those of Blender 3.4's sidebar at its default width, in pixels from its right and its top.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from support.mouse import TAB, click, press, show_only, xdotool

CLICKS = (
    "tyndall.occluder_edit_add",
    "tyndall.occluder_edit_duplicate",
    "tyndall.occluder_edit_move",
    "tyndall.occluder_edit_remove",
    "tyndall.occluder_edit_solo",
)
ADD, REMOVE, MENU, UP, DOWN = ((49, y) for y in (71, 92, 120, 147, 168))
DUPLICATE, SOLO = (168, 144), (168, 165)  # in the menu, once it is open
EYE_OF_FIRST = (84, 77)


def edits_of(light: bpy.types.Light) -> list[str]:
    """In order: their names, and what is special about them."""
    from addon.item_lists import in_order

    return [
        f"{edit.name}{'' if edit.is_enabled else ' off'}{' solo' * edit.is_solo}"
        for edit in in_order(light.tyndall.occluder_edits)
    ]


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    bpy.context.scene.render.engine = "TYNDALL"
    bpy.ops.object.select_all(action="DESELECT")
    thing = bpy.data.objects["Light"]
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing
    bpy.ops.ed.undo_push(message="begin")
    show_only("TYNDALL_PT_sidebar_occluder_edits")
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    yield from window.calm()
    yield from click(window, TAB)
    window.screenshot("occluder_edits_none")
    yield from use_every_button(window)
    yield from show_every_kind(window)


def use_every_button(window: Any) -> Iterator[float]:
    window.facts["lists"] = {}
    steps = (
        ("add", (ADD,), ("Down", "Return")),
        ("duplicate", (MENU, DUPLICATE), ()),
        ("up", (UP,), ()),
        ("eye", (EYE_OF_FIRST,), ()),
        ("down", (DOWN,), ()),
        ("solo", (MENU, SOLO), ()),
        ("remove", (REMOVE,), ()),
        ("undo", (), ("ctrl+z",)),
        ("redo", (), ("ctrl+shift+z",)),
    )
    for step, places, keys in steps:
        for place in places:
            yield from click(window, place)
        yield from press(window, keys)
        window.facts["lists"][step] = edits_of(bpy.data.lights["Light"])
        window.screenshot(f"occluder_edits_{step}")


def show_every_kind(window: Any) -> Iterator[float]:
    """In the sidebar, and the last of them in the Properties editor."""
    light = bpy.data.lights["Light"]
    light.type = "SUN"
    for kind in ("EPIPOLAR_CLOSE", "SILHOUETTE", "HOLES"):
        bpy.ops.tyndall.occluder_edit_add(kind=kind)
        edit = bpy.data.lights["Light"].tyndall.occluder_edits[-1]
        if kind == "HOLES":
            edit.target, edit.mask_image = "COLLECTION", bpy.data.images.new("Mask", 4, 4)
        yield from window.calm()
        window.screenshot(f"occluder_edits_{kind.lower()}")
    area = window.area("VIEW_3D")
    area.type = "PROPERTIES"
    yield from window.calm()
    area.spaces[0].context = "DATA"
    yield from window.calm()
    xdotool("mousemove", area.x + area.width // 2, window.bpy_window.height - area.y - area.height // 2)
    yield 0.2
    xdotool("click", "--repeat", 40, 5)  # the wheel
    yield from window.calm()
    window.screenshot("occluder_edits_properties")
