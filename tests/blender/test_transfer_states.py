# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions over time: whole functions as keyed states."""

from __future__ import annotations

import bpy
import pytest

from addon.animation_paths import curves_at
from addon.panels import transfer_functions as panels
from addon.transfer_states import keys_of, shares
from support.recording_layout import drawn
from support.transfer_scene import LAYERS, add_layers, keyed_states, read, sent, shafts, weights


def test_a_state_shares_itself_between_two_neighbours() -> None:
    """2.4 is 60 % of the third and 40 % of the fourth; beyond the ends there is nothing else to show."""
    assert [(place, pytest.approx(share)) for place, share in shares(2.4, 5)] == [(2, 0.6), (3, 0.4)]
    assert shares(3.0, 5) == [(3, 1.0)]
    assert shares(9.0, 5) == [(4, 1.0)]
    assert shares(-1.0, 1) == [(0, 1.0)]
    assert shares(0.5, 0) == []


def at(frame: float) -> dict[str, float]:
    bpy.context.scene.frame_set(int(frame), subframe=frame % 1)
    return {name: pytest.approx(weight, abs=1e-6) for name, weight in weights().items()}


def make_linear() -> None:
    for key in keys_of(bpy.context.scene):
        key.interpolation = "LINEAR"


def test_keys_give_the_keyed_functions_exactly(function: bpy.types.NodeTree) -> None:
    """At its frame a state is alone, with the layers that it was given; between two, both have a share."""
    add_layers("SOLID")
    first, second = keyed_states(1, 11)
    copied = bpy.data.node_groups[second]
    copied.tyndall.layers[0].colour = (1.0, 0.0, 0.0, 1.0)
    make_linear()
    assert at(1) == {first: 1.0}
    assert at(11) == {second: 1.0}
    assert sent().layers[0].colour == (1.0, 0.0, 0.0, 1.0)
    assert at(4) == {first: 0.7, second: 0.3}
    assert at(3.5) == {first: 0.75, second: 0.25}
    shafts().transfer_mix = 0.5
    assert at(4) == {first: 0.35, second: 0.15}


def test_a_state_that_is_keyed_between_two_goes_between_them(function: bpy.types.NodeTree) -> None:
    """The keys behind it move up: on the way from one key to the next nothing else shows."""
    add_layers("SOLID")
    first, last = keyed_states(10, 30)
    order = keyed_states(20, 1)
    earliest, middle = order[0], order[2]
    assert order == [earliest, first, middle, last]
    assert [tuple(key.co) for key in keys_of(bpy.context.scene)] == [(1, 0), (10, 1), (20, 2), (30, 3)]
    make_linear()
    assert at(15) == {first: 0.5, middle: 0.5}
    assert at(25) == {middle: 0.5, last: 0.5}
    # A copy of what was shown there, with keys of its own.
    assert len(bpy.data.node_groups[middle].tyndall.layers) == 1


def test_handles_move_with_their_keys(function: bpy.types.NodeTree) -> None:
    """Easing that an artist has shaped by hand keeps its shape."""
    add_layers("SOLID")
    keyed_states(11, 21)
    for key in keys_of(bpy.context.scene):
        key.handle_left_type = key.handle_right_type = "FREE"
        key.handle_left, key.handle_right = (key.co.x - 2, key.co.y - 0.25), (key.co.x + 2, key.co.y + 0.125)
    keyed_states(1)
    for place, key in enumerate(keys_of(bpy.context.scene)[1:], start=1):
        assert (key.handle_left.y, key.co.y, key.handle_right.y) == (place - 0.25, place, place + 0.125)


def test_keying_a_keyed_frame_again_shows_its_state(function: bpy.types.NodeTree) -> None:
    """Nothing is added; the state of that key is the one to edit."""
    add_layers("SOLID")
    keyed_states(1, 11)
    assert len(keyed_states(1)) == 2
    assert shafts().active_transfer_state == 0


def test_a_removed_state_takes_its_keys_along(function: bpy.types.NodeTree) -> None:
    """The others show what they showed. Its function stays in the file."""
    add_layers("SOLID")
    first, second, third = keyed_states(1, 11, 21)
    shafts().active_transfer_state = 1
    bpy.ops.tyndall.transfer_state_remove()
    assert [tuple(key.co) for key in keys_of(bpy.context.scene)] == [(1, 0), (21, 1)]
    assert at(21) == {third: 1.0}
    assert at(1) == {first: 1.0}
    assert second in bpy.data.node_groups
    for _ in range(2):
        bpy.ops.tyndall.transfer_state_remove()
    assert read() == ((), ())
    assert keys_of(bpy.context.scene) == []
    assert shafts().transfer_state == 0.0


def test_states_have_layers_of_their_own_number(function: bpy.types.NodeTree) -> None:
    """They are mixed as pictures: nothing of them needs to match."""
    add_layers("SOLID")
    first, second = keyed_states(1, 11)
    add_layers("GRADIENT", "DIFFUSION", "SOLID")
    bpy.ops.tyndall.transfer_layer_move(direction="DOWN")
    make_linear()
    bpy.context.scene.frame_set(6)
    functions, _lines = read()
    assert {one.function.name: len(one.function.layers) for one in functions} == {first: 1, second: 3}


def test_a_state_without_a_function_is_the_physical_picture(function: bpy.types.NodeTree) -> None:
    """What its share leaves is physical: shafts go over from plain to coloured."""
    add_layers("SOLID")
    bpy.ops.tyndall.transfer_state_add()
    shafts().transfer_state = 0.75
    assert weights() == {"Transfer Function": 0.25}
    assert "Physical" in drawn(panels.TYNDALL_PT_transfer_states)


def test_one_function_in_two_states_is_sent_once(function: bpy.types.NodeTree) -> None:
    """Going from it to itself shows it whole."""
    add_layers("SOLID")
    bpy.ops.tyndall.transfer_state_add()
    shafts().transfer_states[1].function = function
    shafts().transfer_state = 0.25
    assert weights() == {"Transfer Function": pytest.approx(1.0)}


def test_a_copied_function_has_keys_of_its_own(function: bpy.types.NodeTree) -> None:
    """A copy of a datablock shares its action: keys of one would be keys of both."""
    add_layers("SOLID")
    layer = function.tyndall.layers[0]
    layer.keyframe_insert("opacity", frame=1)
    keyed_states(1, 11)
    copied = shafts().transfer_states[1].function
    copied.tyndall.layers[0].opacity = 0.25
    copied.tyndall.layers[0].keyframe_insert("opacity", frame=1)
    assert curves_at(function, f"{LAYERS}[0].opacity")[0].evaluate(1) == 1.0
    assert curves_at(copied, f"{LAYERS}[0].opacity")[0].evaluate(1) == 0.25
    assert sent().layers[0].opacity == pytest.approx(0.25)
