# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scale of 0 makes flat is drawn where Cycles draws it: alone, but not as one of several copies."""

from __future__ import annotations

import bpy
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import add, cube, empty_scene, material, node

GLOW = (0.9, 0.5, 0.2)


def glowing() -> bpy.types.Material:
    return material("Glow", lambda new, _: node(new, "ShaderNodeEmission", Color=(*GLOW, 1)).outputs[0])


@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("others", ["none", "a copy", "a copy with a slot of its own", "a mirrored copy"])
def test_flat_cubes_are_drawn_as_in_cycles(others: str, axis: int) -> None:
    scene = empty_scene()
    scene.camera.data.ortho_scale, scene.camera.rotation_euler = 1.0, (0.2, 0.3, 0.0)
    flat = cube("Flat", glowing())
    flat.scale[axis], flat.rotation_euler = 0.0, (0.3, 0.2, 0.5)
    if others != "none":
        other = add("Other", flat.data, location=(50, 0, 0))
        if others == "a mirrored copy":
            other.scale = (-1, 1, 1)
        if others == "a copy with a slot of its own":
            flat.material_slots[0].link = "OBJECT"
            flat.material_slots[0].material = flat.data.materials[0]
    is_drawn = others in {"none", "a copy with a slot of its own"}
    ours = tyndall_pixels(scene)
    assert (ours.max() > 0.0) == is_drawn
    if bpy.app.version >= (4, 0, 0):  # the Embree of 3.4's Cycles ends the process over flat copies
        assert ours == pytest.approx(cycles_pixels(scene, samples=1, seed=1), abs=1e-5)
