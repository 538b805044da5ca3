# SPDX-License-Identifier: GPL-3.0-or-later
"""Clicks once on every tool for transfer functions, in the 3D view's sidebar, and picks on the picture.

Places are those of Blender 3.4's sidebar at its default width, in pixels from its right and its top, in a high window.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from support.mouse import TAB, click, click_at, press, show_only, xdotool

CLICKS = (
    "tyndall.pick_constraint",
    "tyndall.transfer_constraint_add",
    "tyndall.transfer_constraint_remove",
    "tyndall.transfer_function_new",
    "tyndall.transfer_function_preset",
    "tyndall.transfer_layer_add",
    "tyndall.transfer_layer_duplicate",
    "tyndall.transfer_layer_move",
    "tyndall.transfer_layer_paint",
    "tyndall.transfer_layer_remove",
    "tyndall.transfer_layer_solo",
    "tyndall.transfer_state_add",
    "tyndall.transfer_state_key",
    "tyndall.transfer_state_remove",
)
PANEL_HEADER = (100, 74)
NEW, CHOOSE, FIRST_PRESETS = (117, 181), (117, 203), (125, 161)
COPY, PRESETS = (71, 108), (125, 134)
ADD_LAYER, REMOVE_LAYER, LAYER_MENU, UP, DOWN = ((49, y) for y in (438, 459, 487, 514, 534))
DUPLICATE, SOLO, PAINT = ((168, y) for y in (511, 532, 553))  # in the menu, once it is open
EYE_OF_FIRST = (84, 443)
ADD_CONSTRAINT, REMOVE_CONSTRAINT, PICK = ((49, y) for y in (656, 677, 704))
ADD_STATE, KEY = (49, 491), (117, 604)
REMOVE_STATE = (49, 243)  # while the active state has no function, and so no picture
LAYERS_HEADER, STATES_HEADER = (160, 408), (160, 464)


def functions() -> list[str]:
    """States of the scene: their functions with layers, from bottom to top, and constraints."""
    from addon.item_lists import in_order

    found = []
    for state in in_order(bpy.context.scene.tyndall.shafts.transfer_states):
        if state.function is None:
            found.append("physical")
            continue
        layers = []
        for layer in in_order(state.function.tyndall.layers):
            marks = " off" * (not layer.is_enabled) + " solo" * layer.is_solo
            layers.append(f"{layer.name}{marks}{' *' * len(layer.constraints)}")
        found.append(f"{state.function.name}: {', '.join(layers)}")
    return found


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    bpy.context.scene.render.engine = "TYNDALL"
    bpy.ops.ed.undo_push(message="begin")
    show_only("TYNDALL_PT_sidebar_transfer_functions")
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    yield from window.calm()
    yield from click(window, TAB)
    yield from click(window, PANEL_HEADER)
    window.screenshot("transfer_functions_begin")
    window.facts["steps"] = {}
    yield from play(window, FUNCTION_STEPS)
    yield from play(window, LAYER_STEPS)
    yield from pick(window)
    yield from click(window, LAYERS_HEADER)
    yield from click(window, STATES_HEADER)
    yield from play(window, (("key", (KEY,), ()),))
    bpy.context.scene.frame_set(50)
    yield from window.calm()
    yield from play(window, STATE_STEPS)


FUNCTION_STEPS = (
    ("choose", (CHOOSE,), ()),
    ("undo choose", (), ("ctrl+z",)),
    ("new", (NEW,), ()),
    ("copy", (COPY,), ()),
    ("preset", (PRESETS,), ("Down", "Down", "Return")),
    ("undo preset", (), ("ctrl+z",)),
)
LAYER_STEPS = (
    ("add", (ADD_LAYER,), ("Down", "Down", "Down", "Return")),
    ("duplicate", (LAYER_MENU, DUPLICATE), ()),
    ("down", (DOWN,), ()),
    ("eye", (EYE_OF_FIRST,), ()),
    ("up", (UP,), ()),
    ("solo", (LAYER_MENU, SOLO), ()),
    ("remove", (REMOVE_LAYER,), ()),
    ("undo remove", (), ("ctrl+z",)),
    ("redo remove", (), ("ctrl+shift+z",)),
    ("paint", (LAYER_MENU, PAINT), ()),
    ("undo paint", (), ("ctrl+z",)),
    ("constraint", (ADD_CONSTRAINT,), ()),
    ("remove constraint", (REMOVE_CONSTRAINT,), ()),
    ("undo remove constraint", (), ("ctrl+z",)),
    ("eye again", (EYE_OF_FIRST,), ()),
)


STATE_STEPS = (
    ("key again", (KEY,), ()),
    ("add state", (ADD_STATE,), ()),
    ("remove state", (REMOVE_STATE,), ()),
    ("undo remove state", (), ("ctrl+z",)),
    ("redo remove state", (), ("ctrl+shift+z",)),
)


def play(window: Any, steps: tuple[Any, ...]) -> Iterator[float]:
    from addon.transfer_states import keys_of

    for step, places, keys in steps:
        for place in places:
            yield from click(window, place)
        yield from press(window, keys)
        window.facts["steps"][step] = functions()
        window.screenshot(f"transfer_functions_{step.replace(' ', '_')}")
    window.facts["keys"] = [tuple(key.co) for key in keys_of(bpy.context.scene)]


def pick(window: Any) -> Iterator[float]:
    """Two on the cube in the 3D view, one on the render in an Image Editor; Ctrl-Z takes the last one back."""
    yield from click(window, PICK)
    window.screenshot("transfer_functions_picking")
    yield from click_at(window, 330, 470, held="shift")
    yield from click_at(window, 330, 500)
    window.facts["steps"]["pick in the view"] = functions()
    window.screenshot("transfer_functions_pick_in_the_view")

    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = 96, 96
    bpy.ops.render.render()
    area = window.area("PROPERTIES")
    area.type = "IMAGE_EDITOR"
    area.spaces[0].image = bpy.data.images["Render Result"]
    yield from window.calm()
    yield from click(window, PICK)
    region = window.region("IMAGE_EDITOR")
    x, y = region.x + region.width // 2, window.bpy_window.height - region.y - region.height // 2
    yield from click_at(window, x, y)
    window.facts["steps"]["pick on the render"] = functions()
    layer = bpy.context.scene.tyndall.shafts.transfer_states[0].function.tyndall.layers[0]
    window.facts["tracked"] = [one.tracked_object.name for one in layer.constraints if one.is_tracked]
    window.screenshot("transfer_functions_pick_on_the_render")
    yield from press_over_view(window, "ctrl+z")
    window.facts["steps"]["undo pick"] = functions()


def press_over_view(window: Any, key: str) -> Iterator[float]:
    xdotool("mousemove", 330, 300)
    yield from window.settled()
    yield from press(window, (key,))
