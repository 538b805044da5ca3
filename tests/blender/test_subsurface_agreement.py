# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that leaves a body elsewhere than it came in, as in the running Cycles: by the noise of both."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from support.closure_scenes import IS_OLD, errors, lamp, sun, world
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import node
from support.subsurface_scenes import METHODS, block, principled, scattering, sheet, sphere

PROFILE, OTHER_WALK, WALK = METHODS
SIZE_PX, SAMPLES = 24, 512
#: Walks are noisy: of the mean, and of the median block. A profile is not.
NOISE, OF_PROFILE = (0.015, 0.035), (0.008, 0.02)
GLOSSY = "ShaderNodeBsdfGlossy" if IS_OLD else "ShaderNodeBsdfAnisotropic"
Make = Callable[[], bpy.types.Scene]


def beside_cycles(scene: bpy.types.Scene, bounds: tuple[float, float], samples: int = SAMPLES) -> None:
    ours, cycles = tyndall_pixels(scene, samples), cycles_pixels(scene, samples, seed=1)
    mean, median = errors(ours, cycles)
    print(f"mean {mean:.5f}, median block {median:.5f}")
    assert mean <= bounds[0]
    assert median <= bounds[1]


def varying(new: Callable[[str], bpy.types.Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
    """Colour and radius by the place, over a bump, half under gloss."""
    place = new("ShaderNodeTexCoord").outputs["Generated"]
    surface = scattering(WALK, Scale=0.3)(new, link)
    dimmed = new("ShaderNodeVectorMath")  # of what is white, Cycles' walks lose some
    dimmed.operation = "MULTIPLY"
    link(place, dimmed.inputs[0])
    dimmed.inputs[1].default_value = (0.8, 0.8, 0.8)
    for name in ("Color", "Radius"):
        link(dimmed.outputs[0], surface.node.inputs[name])
    waves, bump = node(new, "ShaderNodeTexWave", Scale=2.0), node(new, "ShaderNodeBump", Strength=0.6, Distance=0.1)
    link(waves.outputs["Fac"], bump.inputs["Height"])
    link(bump.outputs["Normal"], surface.node.inputs["Normal"])
    gloss, mix = node(new, GLOSSY, Roughness=0.5), new("ShaderNodeMixShader")
    link(surface, mix.inputs[1])
    link(gloss.outputs[0], mix.inputs[2])
    mix.inputs[0].default_value = 0.3
    return mix.outputs[0]


LAYERS = {"Coat_Weight": 0.7, "Sheen_Weight": 0.5, "Roughness": 0.4}
SCENES: dict[str, Make] = {
    "a block that is scaled": lambda: block(
        scattering(OTHER_WALK, Scale=0.3, Anisotropy=0.6), sun(60.0), (1.0, 0.6, 1.4), SIZE_PX
    ),
    "layers": lambda: sphere(principled(WALK, 0.5, **LAYERS), sun(50.0), SIZE_PX),
    "what varies": lambda: sphere(varying, sun(50.0), SIZE_PX),
}
#: What does not depend on the version, or is as another of these.
COSTLY: dict[str, Make] = {
    "a block with a sharp edge of light": lambda: block(scattering(WALK, Scale=0.2), sun(60.0), size_px=SIZE_PX),
    "a slab from behind": lambda: block(scattering(WALK, Scale=0.8), sun(110.0), (1.0, 1.0, 0.12), SIZE_PX),
    "an open sheet": lambda: sheet(scattering(WALK, Scale=0.3), sun(50.0), SIZE_PX),
    "layers of skin": lambda: sphere(principled(OTHER_WALK, 0.7, Subsurface_Anisotropy=0.5), sun(50.0), SIZE_PX),
    "a lamp": lambda: sphere(scattering(WALK, Scale=0.4), lamp(0.3), SIZE_PX),
    "sharp facets": lambda: sphere(scattering(WALK, Scale=0.4, Roughness=0.1, IOR=1.8), sun(50.0), SIZE_PX),
}
RARELY = {"layers of skin", "a lamp", "an open sheet"}


# Seen to fail: without the bump where light comes in, by 5 %.
@pytest.mark.dealt
@pytest.mark.parametrize("name", SCENES)
def test_walks(name: str) -> None:
    beside_cycles(SCENES[name](), NOISE)
    said = last_render.statistics_of(bpy.context.scene.name)["reports"]
    assert not any("subsurface" in str(line).lower() for line in said)


@pytest.mark.costly
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in RARELY else ()) for name in COSTLY]
)
def test_other_walks(name: str) -> None:
    beside_cycles(COSTLY[name](), NOISE)


@pytest.mark.parametrize("of_principled", [False, True], ids=["node", "principled"])
def test_a_profile(*, of_principled: bool) -> None:
    build = principled(PROFILE, 0.5, **LAYERS) if of_principled else scattering(PROFILE, Scale=0.5)
    beside_cycles(sphere(build, sun(50.0), SIZE_PX), OF_PROFILE, 256)


# Seen to fail: with walks that end at the 256th scattering, as Cycles' do, which loses 6 to 8 % here.
@pytest.mark.dealt
def test_a_white_body_is_not_seen_in_an_even_world() -> None:
    method = WALK if not IS_OLD else OTHER_WALK
    white = scattering(method, Color=(1.0, 1.0, 1.0, 1.0), Scale=0.3, Radius=(1.0, 1.0, 1.0))
    ours = tyndall_pixels(sphere(white, world(), SIZE_PX), SAMPLES, "RGBA")
    inside = ours[..., 3] == 1.0
    radiance = ours[inside][:, :3].mean(axis=0) / np.array([0.9, 0.7, 0.5])
    assert radiance == pytest.approx(1.0, abs=0.005)


def test_radii_of_nothing_are_diffuse() -> None:
    scene = sphere(scattering(WALK, Scale=0.0), sun(50.0), SIZE_PX)
    beside_cycles(scene, (1e-3, 1e-3), 4)
