# SPDX-License-Identifier: GPL-3.0-or-later
"""The small picture of a transfer function in its panel."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from addon import transfer_function_preview
from addon.function_trees import ramp_of, set_stops
from support.transfer_scene import add_layers, image
from tyndall import native_transfer_functions
from tyndall.native_transfer_functions import compose
from tyndall.transfer_functions import TransferFunction


@pytest.fixture
def composed(monkeypatch: pytest.MonkeyPatch) -> list[TransferFunction]:
    """Every function that a picture is made of, in turn."""
    seen: list[TransferFunction] = []

    def spy(made: TransferFunction, size: int) -> np.ndarray:
        seen.append(made)
        return compose(made, size)

    monkeypatch.setattr(native_transfer_functions, "compose", spy)
    return seen


def shown_pixels(tree: bpy.types.NodeTree) -> np.ndarray:
    bpy.context.view_layer.update()
    transfer_function_preview.picture_of(tree, bpy.context.view_layer.depsgraph)
    shown = transfer_function_preview._previews._shown[tree.name_full]  # noqa: SLF001
    return np.array(shown.picture.image_pixels_float).reshape(128, 128, 4)


def test_the_small_picture_shows_the_function(function: bpy.types.NodeTree) -> None:
    """As a screen shows it: sRGB, from left to right along X; a checkerboard where it is transparent."""
    add_layers("GRADIENT")
    set_stops(ramp_of(function.tyndall.layers[0]), [(0.0, (0, 0, 0, 1)), (1.0, (0.5, 1, 1, 1))])
    shown = shown_pixels(function)
    assert shown[:, 0] == pytest.approx(np.tile([0, 0, 0, 1], (128, 1)), abs=0.06)
    assert shown[:, -1] == pytest.approx(np.tile([0.735, 1, 1, 1], (128, 1)), abs=0.01)
    function.tyndall.layers[0].opacity = 0.0
    shown = shown_pixels(function)
    assert len(np.unique(shown[..., :3])) == 2
    assert (shown[..., 3] == 1.0).all()


def test_the_small_picture_is_made_when_the_function_changes(
    function: bpy.types.NodeTree, composed: list[TransferFunction]
) -> None:
    """Not when a panel draws, nor when anything else changes."""
    add_layers("GRADIENT", "IMAGE")
    function.tyndall.layers[1].image = image("Picture")
    shown_pixels(function)
    shown_pixels(function)
    bpy.data.objects["Cube"].location.x += 1.0
    shown_pixels(function)
    function.tyndall.layers[0].opacity = 1.0
    shown_pixels(function)
    assert len(composed) == 1
    function.tyndall.layers[0].opacity = 0.5
    shown_pixels(function)
    ramp_of(function.tyndall.layers[0]).elements[0].color = (1, 0, 0, 1)
    shown_pixels(function)
    assert [made.layers[0].opacity for made in composed] == [1.0, 0.5, 0.5]
    assert composed[2].layers[0].ramp[0] == (1.0, 0.0, 0.0, 1.0)


def test_the_small_picture_follows_keys(function: bpy.types.NodeTree, composed: list[TransferFunction]) -> None:
    add_layers("SOLID")
    layer = function.tyndall.layers[0]
    for frame in (1, 2):
        layer.opacity = frame / 2
        layer.keyframe_insert("opacity", frame=frame)
    for frame in (1, 2):
        bpy.context.scene.frame_set(frame)
        shown_pixels(function)
    assert [made.layers[0].opacity for made in composed] == [0.5, 1.0]
