# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene's transfer functions over time: one float goes over the list of them, and its keys go with the list.

Pointers cannot be keyed; a float can, with easing, in Blender's own editors. Its whole numbers are places in the list,
so a state that is put in or taken out moves the keys of those behind it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .animation_paths import curves_at
from .item_lists import OrderedList

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Keyframe, Scene

STATE_PATH = "tyndall.shafts.transfer_state"
_SAME_FRAME = 0.5  #: Frames: keys that are nearer than this are one in the timeline.


def states_of(scene: Scene) -> OrderedList:
    return OrderedList(scene.tyndall.shafts, "transfer_states", "active_transfer_state")


def shares(state: float, count: int) -> list[tuple[int, float]]:
    """Of ``count`` functions at a state: which places have a share, and how much; their sum is 1.

    Beyond the ends of the list it is the first or the last alone.
    """
    if count == 0:
        return []
    state = min(max(state, 0.0), count - 1.0)
    place = min(math.floor(state), count - 1)
    behind = state - place
    return [(place, 1.0 - behind), (place + 1, behind)] if behind > 0.0 else [(place, 1.0)]


def keys_of(scene: Scene) -> list[Keyframe]:
    """Keys of the scene's state, in time."""
    return sorted(
        (key for curve in curves_at(scene, STATE_PATH) for key in curve.keyframe_points), key=lambda key: key.co.x
    )


def key_at(scene: Scene, frame: float) -> Keyframe | None:
    return next((key for key in keys_of(scene) if abs(key.co.x - frame) < _SAME_FRAME), None)


def place_for(scene: Scene, frame: float) -> int:
    """Where a state that will be keyed at a frame belongs: behind that of the key before, or first of all."""
    count = len(scene.tyndall.shafts.transfer_states)
    before = [key for key in keys_of(scene) if key.co.x < frame]
    return min(round(before[-1].co.y) + 1, count) if before else 0


def make_room(scene: Scene, place: int) -> None:
    """Call before a state is put in at a place: what shows states from there on shows the same ones behind it."""
    _renumber(scene, lambda state: state + 1.0 if state >= place else state)


def close_gap(scene: Scene, place: int) -> None:
    """Call before the state at a place is taken out: keys that show it more than any other go with it."""
    for curve in curves_at(scene, STATE_PATH):
        keys = curve.keyframe_points
        for index in reversed(range(len(keys))):  # to remove one invalidates those behind it
            if round(keys[index].co.y) == place:
                keys.remove(keys[index])
    last = len(scene.tyndall.shafts.transfer_states) - 1
    _renumber(scene, lambda state: max(state - 1.0, 0.0) if state > place or state >= last == place else state)


def _renumber(scene: Scene, renumbered: Callable[[float], float]) -> None:
    for curve in curves_at(scene, STATE_PATH):
        for key in curve.keyframe_points:
            step = renumbered(key.co.y) - key.co.y
            key.co.y += step
            key.handle_left.y += step
            key.handle_right.y += step
        curve.update()
    shafts = scene.tyndall.shafts
    shafts.transfer_state = renumbered(shafts.transfer_state)
