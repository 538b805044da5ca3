# SPDX-License-Identifier: GPL-3.0-or-later
"""Any object may be the scene's camera: what Cycles sees through lamps, meshes and empties."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Node, add, cube, empty_scene, light, material


def _place(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
    glow = new("ShaderNodeEmission")
    link(new("ShaderNodeNewGeometry").outputs["Position"], glow.inputs["Color"])
    return glow.outputs[0]


@pytest.mark.parametrize("size_px", [(40, 30), (30, 40)], ids=["wide", "high"])
@pytest.mark.parametrize("kind", ["spot", "sun", "area", "mesh", "empty"])
def test_the_scene_is_seen_through_any_object(kind: str, size_px: tuple[int, int]) -> None:
    """The walls of a room glow as they lie: each pixel shows whereto it looks."""
    scene = empty_scene()
    scene.render.resolution_x, scene.render.resolution_y = size_px
    room = cube("Room", material("Place", _place))
    room.scale, room.location = (4, 5, 6), (5, 6, 7)
    if kind in {"mesh", "empty"}:
        through = add("Through", bpy.data.meshes.new("Through") if kind == "mesh" else None)
    else:
        through = light(kind.upper(), (0, 0, 0), energy=0.0)
    if kind == "spot":
        through.data.spot_size = 0.9
    through.location, through.rotation_euler, through.scale = (4, 7, 6), (0.9, 0.2, math.radians(30)), (1, 2, 0.5)
    scene.camera = through
    ours = tyndall_pixels(scene)
    assert (ours.std(axis=(0, 1)) > 0.5).all()  # corners of the room are seen
    assert ours == pytest.approx(cycles_pixels(scene, 1, seed=1), abs=0.03)
