# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog shows in mirrors and through glass as in Cycles: scattered once, with shadows, within the noise of both."""

from __future__ import annotations

from collections.abc import Callable
from math import radians
from pathlib import Path

import bpy
import pytest

from support.cycles_reference import agreement, prepare_cycles, rendered_pixels, save_side_by_side
from support.engine_pictures import tyndall_pixels
from support.glow_scenes import empty_stage, fog, plate
from support.small_scenes import light, material, node, plane

PICTURES = Path(__file__).parents[2] / "out" / "air_in_mirrors"
#: Ours and Cycles'.
SAMPLES = {"sky": (256, 1024)}
FEW_SAMPLES = 64, 256


def spot(scene: bpy.types.Scene) -> None:
    lamp = light("SPOT", (0.0, -3.0, 4.5), energy=900.0, spot_size=0.9, spot_blend=0.3, shadow_soft_size=0.2)
    lamp.rotation_euler = (0.6, 0.0, 0.0)


def points(scene: bpy.types.Scene) -> None:
    """Within the fog, and beside it."""
    light("POINT", (0.7, 0.4, 2.0), energy=60.0, shadow_soft_size=0.0)
    light("POINT", (-2.6, 0.0, 2.5), energy=150.0, shadow_soft_size=0.3, color=(1.0, 0.4, 0.2))


def area(scene: bpy.types.Scene) -> None:
    lamp = light("AREA", (2.8, 0.0, 3.0), energy=300.0, shape="RECTANGLE", size=1.0, size_y=0.5)
    lamp.rotation_euler = (0.0, 1.2, 0.0)


def suns(scene: bpy.types.Scene) -> None:
    lamp = light("SUN", (0, 0, 5), energy=4.0, angle=0.05)
    lamp.rotation_euler = (0.5, 0.3, 0.0)
    lamp = light("SUN", (0, 0, 5), energy=1.0, angle=0.0, color=(0.2, 0.4, 1.0))
    lamp.rotation_euler = (-0.9, 0.0, 0.0)


def sky(scene: bpy.types.Scene) -> None:
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)


LIGHTS: dict[str, Callable[[bpy.types.Scene], object]] = {
    "spot": spot,
    "points": points,
    "area": area,
    "suns": suns,
    "sky": sky,
    "glow": lambda _: plate(),
}


def stage(name: str, *, glass: bool = False) -> bpy.types.Scene:
    """Fog around posts, seen in a mirror beside it, or through a slanted face of glass."""
    scene = empty_stage()
    shown = "ShaderNodeBsdfGlass" if glass else "ShaderNodeBsdfGlossy"
    face = plane(0.0, material("Face", lambda new, _: node(new, shown, Color=(1,) * 4, Roughness=0.0).outputs[0]))
    if glass:
        face.location, face.rotation_euler, face.scale = (0, -5.2, 1.2), (radians(60), 0, 0), (0.2, 0.2, 1)
    else:
        face.location, face.rotation_euler = (0, -6.5, 0), (radians(-90), 0, 0)
        scene.camera.location, scene.camera.rotation_euler = (0, -5, 1.2), (radians(92), 0, radians(180))
    fog(lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.2, Anisotropy=0.4).outputs[0])
    LIGHTS[name](scene)
    for lamp in bpy.data.lights:  # what mirrors show of lamps themselves is test_refraction_agreement.py's
        bpy.data.objects[lamp.name].visible_glossy = bpy.data.objects[lamp.name].visible_transmission = False
    indirect = scene.tyndall.indirect
    indirect.has_mirrors = True
    indirect.mirror_depth = indirect.refraction_depth = 1
    indirect.has_refraction = glass
    return scene


def check(scene: bpy.types.Scene, name: str) -> None:
    ours, cycles = [], []
    samples, cycles_samples = SAMPLES.get(name, FEW_SAMPLES)
    for seed in (0, 1):
        scene.tyndall.seed = seed
        ours.append(tyndall_pixels(scene, samples))
        prepare_cycles(scene, cycles_samples, seed + 1, glossy_bounces=1)
        scene.cycles.transmission_bounces = 1
        cycles.append(rendered_pixels(scene))
    verdict = agreement((ours[0], ours[1]), (cycles[0], cycles[1]), None, cycles_samples)
    print(f"{name}: {verdict}")
    picture = PICTURES / f"{bpy.app.version_string} {name}.png".replace(" ", "_")
    save_side_by_side(picture, sum(ours) / 2, sum(cycles) / 2)
    assert verdict.holds, str(verdict)
    assert verdict.mean_sigma < 0.02
    assert cycles[0].mean() > 0.005


#: The versions' Cycles differ in how lamps shine, which is tested elsewhere.
COSTLY = ("points", "area", "sky", "glow")


@pytest.mark.dealt
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.costly) if name in COSTLY else name for name in LIGHTS]
)
def test_mirrors_show_lit_fog(name: str) -> None:
    check(stage(name), name)


@pytest.mark.dealt
def test_glass_shows_lit_fog() -> None:
    check(stage("spot", glass=True), "glass")
