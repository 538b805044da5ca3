# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene with one transfer function, and what is sent of it: for the tests of functions, states, layers, picks."""

from __future__ import annotations

from typing import Any

import bpy

from addon.item_lists import in_order
from addon.sync.images import ImageReader
from addon.sync.reports import Reports
from addon.sync.transfer_functions import read_transfer_functions
from support.small_scenes import cube, empty_scene
from tyndall.transfer_functions import TransferFunction, WeightedFunction

LAYERS = "tyndall.layers"


def function_scene() -> bpy.types.NodeTree:
    """A new function without layers, the only one of a scene with a cube."""
    empty_scene()
    cube()
    assert bpy.ops.tyndall.transfer_function_new() == {"FINISHED"}
    return shafts().transfer_states[0].function


def shafts() -> Any:
    return bpy.context.scene.tyndall.shafts


def add_layers(*kinds: str) -> None:
    for kind in kinds:
        assert bpy.ops.tyndall.transfer_layer_add(kind=kind) == {"FINISHED"}


def names(tree: bpy.types.NodeTree) -> list[str]:
    """From bottom to top."""
    return [layer.name for layer in in_order(tree.tyndall.layers)]


def read() -> tuple[tuple[WeightedFunction, ...], tuple[str, ...]]:
    """What a render would be given, and what it would be told."""
    reports = Reports()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    functions = read_transfer_functions(depsgraph.scene_eval, depsgraph, ImageReader(), reports)
    return functions, reports.lines()


def sent() -> TransferFunction:
    """The only one, which is all of what is shown."""
    (weighted,), lines = read()
    assert weighted.weight == 1.0
    assert lines == ()
    return weighted.function


def weights() -> dict[str, float]:
    return {weighted.function.name: weighted.weight for weighted in read()[0]}


def image(name: str, side_px: int = 2) -> bpy.types.Image:
    return bpy.data.images.new(name, side_px, side_px)


def keyed_states(*frames: int) -> list[str]:
    """Keys a state at each frame; names of the functions in their order."""
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        assert bpy.ops.tyndall.transfer_state_key() == {"FINISHED"}
    return [state.function.name for state in in_order(shafts().transfer_states)]


def keyed(tree: bpy.types.NodeTree) -> None:
    """Three layers; the second and third have a key on their opacity, the third a driver on its smoothness."""
    add_layers("SOLID", "GRADIENT", "DIFFUSION")
    for index in (1, 2):
        layer = tree.tyndall.layers[index]
        layer.opacity = index / 4
        layer.keyframe_insert("opacity", frame=1)
    tree.tyndall.layers[2].driver_add("smoothness").driver.expression = "frame / 2"
    bpy.ops.tyndall.transfer_constraint_add()
