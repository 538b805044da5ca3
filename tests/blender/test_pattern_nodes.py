# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns have the values that Cycles gives them, over random inputs of every socket."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import bpy
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.flat_nodes import deviations
from support.pattern_setups import Case, all_cases, setups_of, usual_cases
from support.small_scenes import empty_scene, material, plane

BOUND = 1e-4
#: Green and blue of a Noise node are noise 100 to 200 cells away, where float32 keeps 1.5e-5 of a cell; the fourth
#: octave multiplies that by 2.5^3. Which way the last bit of a displaced place goes is not the pattern's doing.
FAR_BOUND = 1e-3
#: A face whose place is on a cell's border to rounding may be on its other side.
TORN_SHARE = 1 / 64


def check(cases: Iterator[Case], seed: int) -> None:
    setups = setups_of(cases)
    wrong = []
    for name, found in deviations([setup for setup, _ in setups.values()], seed).items():
        scale = abs(found.cycles).max(axis=1).clip(1.0)
        bound = FAR_BOUND if name.startswith("Noise Color") else BOUND
        is_off = abs(found.ours - found.cycles).max(axis=1) > bound * scale
        print(f"{name}: {found.largest:.1e}, {is_off.mean():.1%} of faces")
        if is_off.mean() > (TORN_SHARE if setups[name][1] else 0.0):
            wrong.append(f"{name}: {found.largest:.1e}, {is_off.mean():.1%} of faces")
    assert not wrong


# Seen to fail with noise normalized where it should not be, and with Voronoi's points of Blender 5 in 4.5.
def test_patterns_are_as_in_cycles() -> None:
    check(usual_cases(), seed=2)


def without_a_vector(kind: str) -> bpy.types.Scene:
    def glowing(new: Callable[[str], bpy.types.Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        emission, pattern = new("ShaderNodeEmission"), new(kind)
        if kind == "ShaderNodeMapRange":
            pattern.data_type = "FLOAT_VECTOR"
        if kind == "ShaderNodeVectorRotate":
            pattern.inputs["Center"].default_value, pattern.inputs["Angle"].default_value = (0.3, 0.2, 0.4), 2.0
        shown = [one for one in pattern.outputs if one.enabled]
        link(next((one for one in shown if one.type == "RGBA"), shown[0]), emission.inputs["Color"])
        return emission.outputs[0]

    scene = empty_scene(16)
    scene.camera.location.x = 0.3  # on no border of a cell
    plane(0.2, material("Shown", glowing))
    return scene


NO_PATTERNS = {f"ShaderNodeTex{name}" for name in ("Coord", "Image", "Environment", "IES", "Sky", "PointDensity")}
PATTERNS = {name for name in dir(bpy.types) if name.startswith("ShaderNodeTex")} - NO_PATTERNS


# Seen to fail: White Noise, Map Range and Vector Rotate have one value then, and had one of each place.
@pytest.mark.parametrize("kind", sorted(PATTERNS | {"ShaderNodeMapRange", "ShaderNodeVectorRotate"}))
def test_what_has_no_vector_is_as_in_cycles(kind: str) -> None:
    scene = without_a_vector(kind)
    assert tyndall_pixels(scene, 4) == pytest.approx(cycles_pixels(scene, 4, seed=1), abs=1e-3)


@pytest.mark.long
def test_all_kinds_of_patterns_are_as_in_cycles() -> None:
    check(all_cases(), seed=3)
