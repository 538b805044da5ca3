# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists of layers and constraints: operators, keys that stay with their items, and what panels show."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon.animation_paths import curves_at
from addon.function_trees import ramp_of, set_stops
from addon.panels import transfer_functions as panels
from addon.properties import transfer_functions as properties
from support.recording_layout import drawn
from support.transfer_scene import LAYERS, add_layers, keyed, names, sent, shafts
from tyndall.native_transfer_functions import compose

# Keys and drivers


def values_by_name() -> dict[str, tuple[float, float]]:
    bpy.context.scene.frame_set(1)
    return {layer.name: (layer.opacity, layer.smoothness) for layer in sent().layers}


def test_keys_and_drivers_stay_with_their_layers(function: bpy.types.NodeTree) -> None:
    """After moves, and after the removal of a layer before them."""
    keyed(function)
    at_first = values_by_name()
    assert at_first["Gradient"][0] == 0.25
    assert at_first["Diffusion"] == pytest.approx((0.5, 0.5))
    bpy.ops.tyndall.transfer_layer_move(direction="DOWN")
    assert values_by_name() == at_first
    function.tyndall.active_layer = 0
    bpy.ops.tyndall.transfer_layer_remove()
    del at_first["Solid"]
    assert values_by_name() == at_first
    function.tyndall.active_layer = 0
    bpy.ops.tyndall.transfer_layer_remove()
    assert values_by_name() == {"Diffusion": pytest.approx((0.5, 0.5))}
    assert not function.nodes, "the gradient's ramp went with it"


def test_keys_stay_with_their_constraints(function: bpy.types.NodeTree) -> None:
    """Collections in collections: only those of this layer count down."""
    add_layers("DIFFUSION", "DIFFUSION")
    for layer in (0, 1):
        function.tyndall.active_layer = layer
        for _ in range(2):
            bpy.ops.tyndall.transfer_constraint_add()
        constraint = function.tyndall.layers[layer].constraints[1]
        constraint.position = (0.25, 0.25 + layer / 2)
        constraint.keyframe_insert("position", index=1, frame=1)
    function.tyndall.active_layer, function.tyndall.layers[1].active_constraint = 1, 0
    bpy.ops.tyndall.transfer_constraint_remove()
    assert len(curves_at(function, f"{LAYERS}[0].constraints[1].position")) == 1
    assert len(curves_at(function, f"{LAYERS}[1].constraints[0].position")) == 1
    bpy.context.scene.frame_set(1)
    assert [layer.constraints[-1].position for layer in sent().layers] == [(0.25, 0.25), (0.25, 0.75)]


# The lists


def test_names_are_unique_within_their_list(function: bpy.types.NodeTree) -> None:
    """Library overrides find an item by its name; so does the artist."""
    add_layers("SOLID", "SOLID", "DIFFUSION")
    function.tyndall.layers[1].name = "Solid"
    assert names(function) == ["Solid", "Solid.001", "Diffusion"]
    function.tyndall.layers[1].name = ""
    assert names(function)[1] == "Layer"
    for _ in range(2):
        bpy.ops.tyndall.transfer_constraint_add()
    assert [constraint.name for constraint in function.tyndall.layers[2].constraints] == ["Colour", "Colour.001"]


def test_a_duplicate_has_its_own_ramp_and_constraints(function: bpy.types.NodeTree) -> None:
    """All settings but the name; what is done to it is not done to the original."""
    add_layers("GRADIENT")
    ramp = ramp_of(function.tyndall.layers[0])
    set_stops(ramp, [(0.0, (1, 0, 0, 1)), (0.5, (0, 1, 0, 0.5)), (1.0, (0, 0, 1, 1))])
    ramp.interpolation = "CONSTANT"
    bpy.ops.tyndall.transfer_layer_duplicate()
    original, copied = sent().layers
    assert copied.ramp == original.ramp
    ramp_of(function.tyndall.layers[1]).elements[0].color = (0, 0, 0, 1)
    original, copied = sent().layers
    assert copied.ramp[0] != original.ramp[0]

    add_layers("DIFFUSION")
    bpy.ops.tyndall.transfer_constraint_add()
    function.tyndall.layers[2].constraints[0].position = (0.125, 0.875)
    bpy.ops.tyndall.transfer_layer_duplicate()
    assert [layer.constraints[0].position for layer in sent().layers[2:]] == [(0.125, 0.875)] * 2
    assert function.tyndall.layers[3].constraints[0].name == "Colour"


def test_a_painted_layer_begins_as_the_function_is(function: bpy.types.NodeTree, tmp_path: Path) -> None:
    """What is transparent, too; its pixels are saved with the file, and painting on them changes the function."""
    bpy.ops.tyndall.transfer_function_preset(preset="ALARM")
    tree = shafts().transfer_states[0].function
    tree.tyndall.layers[0].opacity = 0.5
    before = compose(sent(), 256)
    assert bpy.ops.tyndall.transfer_layer_paint() == {"FINISHED"}
    assert [layer.name for layer in sent().layers] == ["Painted"]
    half_float = 2e-3
    assert np.abs(compose(sent(), 256) - before).max() < half_float
    path = str(tmp_path / "painted.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert np.abs(compose(sent(), 256) - before).max() < half_float
    bpy.data.images["Alarm painted"].pixels.foreach_set(np.ones(256 * 256 * 4, np.float32))
    assert (compose(sent(), 256) == 1.0).all()


def test_operators_ask_for_what_they_need(function: bpy.types.NodeTree) -> None:
    """A function, a layer, a diffusion layer, a constraint."""
    assert bpy.ops.tyndall.transfer_layer_add.poll()
    assert not bpy.ops.tyndall.transfer_layer_remove.poll()
    add_layers("SOLID")
    assert not bpy.ops.tyndall.transfer_constraint_add.poll()
    add_layers("DIFFUSION")
    assert bpy.ops.tyndall.transfer_constraint_add.poll()
    assert not bpy.ops.tyndall.transfer_constraint_remove.poll()
    shafts().transfer_states[0].function = None
    assert not bpy.ops.tyndall.transfer_layer_add.poll()
    assert bpy.ops.tyndall.transfer_state_remove() == {"FINISHED"}
    assert not bpy.ops.tyndall.transfer_state_key.poll()


# What is shown


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("SOLID", {"colour"}),
        ("GRADIENT", {"color_ramp", "shape", "start", "end"}),
        ("DIFFUSION", {"smoothness", "colour", "position", "is_tracked"}),
        ("IMAGE", {"image"}),
    ],
)
def test_only_settings_that_the_layer_reads_are_shown(
    function: bpy.types.NodeTree, kind: str, settings: set[str]
) -> None:
    add_layers(kind)
    if kind == "DIFFUSION":
        bpy.ops.tyndall.transfer_constraint_add()
    shown = set(drawn(panels.TYNDALL_PT_transfer_layers))
    all_settings = {"colour", "color_ramp", "shape", "start", "end", "smoothness", "position", "is_tracked", "image"}
    assert shown & all_settings == settings
    assert {"kind", "blend_mode", "opacity"} <= shown
    assert set(drawn(panels.TYNDALL_PT_sidebar_transfer_layers)) == shown


def test_a_scene_without_functions_says_how_to_begin(function: bpy.types.NodeTree) -> None:
    bpy.ops.tyndall.transfer_state_remove()
    shown = drawn(panels.TYNDALL_PT_sidebar_transfer_functions)
    assert "New from Preset" in shown
    assert not panels.TYNDALL_PT_transfer_layers.poll(bpy.context)


def test_only_transfer_functions_are_offered(function: bpy.types.NodeTree) -> None:
    """Not the node groups of shaders."""
    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    offered = [tree for tree in (function, group) if properties.is_transfer_function(shafts().transfer_states[0], tree)]
    assert offered == [function]
