# SPDX-License-Identifier: GPL-3.0-or-later
"""Light Falloff makes lamps weaker with the distance as in Cycles, on surfaces and in the air."""

from __future__ import annotations

import bpy
import pytest

from support.agreement_scenes import Arrangement, build
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.lamp_scenes import (
    IS_4,
    assert_air_like_cycles,
    assert_like_cycles,
    assert_same_light,
    bands,
    mixed,
    output,
    read_through,
    shows,
    stage,
    tree_of,
)
from support.sky_scenes import errors
from support.small_scenes import empty_scene, light, material, node, plane, read


def falls(lamp: bpy.types.Object, output_name: str, smooth: float = 0.0, strength: float = 0.2) -> None:
    tree = tree_of(lamp)
    emission = next(one for one in tree.nodes if one.type == "EMISSION")
    falloff = node(tree.nodes.new, "ShaderNodeLightFalloff", Strength=strength, Smooth=smooth)
    tree.links.new(falloff.outputs[output_name], emission.inputs["Strength"])


@pytest.mark.dealt
@pytest.mark.parametrize(
    ("kind", "output_name", "smooth", "has_pattern"),
    [
        ("POINT", "Linear", 0.0, False),
        ("SPOT", "Constant", 3.0, True),
        ("POINT", "Quadratic", 20.0, True),
    ],
)
def test_light_falls_off_as_its_node_says(
    kind: str,
    output_name: str,
    smooth: float,
    has_pattern: bool,  # noqa: FBT001
) -> None:
    lamp = stage(kind)
    falls(lamp, output_name, smooth)
    if has_pattern:
        shows(lamp, bands)
    assert read().reports == ()
    assert_like_cycles(4e-3)


# Seen to fail: with the square of the distance, half and a quarter of the light.
@pytest.mark.parametrize(
    ("output_name", "smooth", "has_picture"),
    [("Linear", 0.0, False), ("Constant", 3.0, True), ("Quadratic", 5.0, True)],
)
def test_an_area_lights_light_falls_off_as_its_node_says(
    output_name: str,
    smooth: float,
    has_picture: bool,  # noqa: FBT001
) -> None:
    scene = empty_scene(32)
    plane(material=material("Lambert", lambda new, _: node(new, "ShaderNodeBsdfDiffuse").outputs[0]))
    lamp = light("AREA", (0.4, -0.3, 1.6), energy=50.0, size=1.2)
    lamp.rotation_euler = (0.3, 0.2, 0.0)
    if has_picture:
        read_through(lamp, lambda _new, _link: None)
    falls(lamp, output_name, smooth)
    assert read().reports == ()
    ours, cycles = tyndall_pixels(scene, 64), cycles_pixels(scene, 256, seed=1)
    assert ours.mean(axis=(0, 1)) == pytest.approx(cycles.mean(axis=(0, 1)), rel=3e-3)
    assert max(errors(ours, cycles)) <= 0.01


def test_a_suns_light_does_not_fall_off() -> None:
    falls(stage("SUN"), "Linear")
    if IS_4:
        assert read().reports == ()
        assert_same_light()
        return
    assert read().reports == ('Light "Sun": its falloff, which is without bounds in Cycles 3.x, is left out',)


@pytest.mark.dealt
@pytest.mark.parametrize("kind", ["spot", "area"])
def test_fog_is_lit_by_the_same_falloff(kind: str) -> None:
    def make() -> None:
        build(Arrangement(light=kind))
        falls(next(thing for thing in bpy.context.scene.objects if thing.type == "LIGHT"), "Linear", 1.0)

    assert_air_like_cycles(f"falloff_{kind}", make, make, methods=("EXACT", "EPIPOLAR"))


# Seen to fail: beyond 1e12 the falloff was left out, and the lamp shone in full.
def test_a_smooth_without_measure_leaves_no_light() -> None:
    falls(stage("POINT"), "Quadratic", 1e30)
    assert read().reports == ()
    assert tyndall_pixels(bpy.context.scene).max() < 1e-6


def test_a_falloff_among_other_nodes_is_named() -> None:
    lamp = stage("POINT")
    shows(lamp, mixed(bands, output("ShaderNodeLightFalloff", "Linear")))
    assert read().reports == ('Light "Point": Linear falloff is drawn as quadratic',)
    lamp = stage("POINT")
    falls(lamp, "Quadratic")
    assert read().reports == ()
    assert read().lights[0].texture is None
