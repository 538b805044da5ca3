# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface shaders reflect light as Cycles' do, each on a faceted ball that shows every angle.

Under a sun without a size neither engine has any noise: what differs is the formula. Lamps with a size and the
world are noisy in both.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import bpy
import pytest

from addon import last_render
from support.closure_scenes import IS_OLD, assert_like_cycles, errors, lamp, pane_scene, scene_of, shader, sun, world
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, empty_scene, material, plane

if TYPE_CHECKING:
    from collections.abc import Callable

GOLD, RED = (0.9, 0.6, 0.2, 1.0), (0.8, 0.2, 0.1, 1.0)
#: What the product promises: mean and median block within 1 %.
BOUND = 0.01
TILT = 50.0
HAS_METALLIC = hasattr(bpy.types, "ShaderNodeBsdfMetallic")
GLOSSY = "ShaderNodeBsdfGlossy" if IS_OLD else "ShaderNodeBsdfAnisotropic"


def principled(**inputs: object) -> Build:
    values: dict[str, object] = {"Base_Color": RED, "Roughness": 0.4, **inputs}
    names = {"Specular": "Specular" if IS_OLD else "Specular_IOR_Level"}
    if not IS_OLD:
        names |= {"Clearcoat": "Coat_Weight", "Clearcoat_Roughness": "Coat_Roughness"}
        names |= {"Transmission": "Transmission_Weight"}
    single = {} if "node_distribution" in values else {"node_distribution": "GGX"}
    named = {names.get(name, name): value for name, value in values.items()}
    return shader("ShaderNodeBsdfPrincipled", **named, **single)


SHADERS: dict[str, Build] = {
    "rough diffuse": shader("ShaderNodeBsdfDiffuse", Color=RED, Roughness=0.7),
    "glossy 0.2": shader(GLOSSY, Color=GOLD, Roughness=0.2, node_distribution="GGX"),
    "glossy 0.6": shader(GLOSSY, Color=GOLD, Roughness=0.6, node_distribution="GGX"),
    "principled": principled(),
    "principled, rough": principled(Roughness=0.9),
    "principled, strong specular": principled(Specular=1.0, Roughness=0.3),
    "metal": principled(Base_Color=GOLD, Metallic=1.0),
    "half metal": principled(Base_Color=GOLD, Metallic=0.5, Roughness=0.6),
    "coat": principled(Clearcoat=0.8, Clearcoat_Roughness=0.3),
}
if IS_OLD:
    SHADERS |= {
        "velvet": shader("ShaderNodeBsdfVelvet", Color=RED, Sigma=0.6),
        "specular tint": principled(Specular_Tint=0.8, Specular=1.0),
        "sheen": principled(Sheen=1.0, Sheen_Tint=0.5),
    }
else:
    SHADERS |= {
        "glossy 0.6, multiple": shader(GLOSSY, Color=GOLD, Roughness=0.6, node_distribution="MULTI_GGX"),
        "principled, multiple": principled(Roughness=0.8, node_distribution="MULTI_GGX"),
        "metal, multiple": principled(Base_Color=GOLD, Metallic=1.0, Roughness=0.8, node_distribution="MULTI_GGX"),
        "metal, tinted": principled(Base_Color=GOLD, Metallic=1.0, Specular_Tint=(0.5, 0.8, 1.0, 1.0)),
        "specular tint": principled(Specular_Tint=(1.0, 0.3, 0.2, 1.0), Specular=0.9),
        "tinted coat": principled(Clearcoat=1.0, Coat_Tint=(0.7, 0.8, 0.4, 1.0), Coat_IOR=1.7),
        "velvet": shader("ShaderNodeBsdfSheen", Color=RED, Roughness=0.6, node_distribution="ASHIKHMIN"),
    }
if HAS_METALLIC:
    SHADERS |= {
        "metallic": shader("ShaderNodeBsdfMetallic", Base_Color=GOLD, Edge_Tint=(0.6, 0.8, 1.0, 1.0), Roughness=0.5),
        "conductor": shader("ShaderNodeBsdfMetallic", Roughness=0.4, node_fresnel_type="PHYSICAL_CONDUCTOR"),
        "rough principled": principled(Diffuse_Roughness=0.8),
    }
LONG: dict[str, Build] = {
    "diffuse toon": shader("ShaderNodeBsdfToon", Color=RED, Size=0.5, Smooth=0.3),
    "glossy toon": shader("ShaderNodeBsdfToon", Color=RED, Size=0.3, Smooth=0.2, node_component="GLOSSY"),
    **{
        f"rough diffuse {roughness}": shader("ShaderNodeBsdfDiffuse", Color=RED, Roughness=roughness)
        for roughness in (0.1, 0.4, 1.0)
    },
    **{
        f"principled {roughness} {metallic}": principled(Roughness=roughness, Metallic=metallic)
        for roughness in (0.15, 0.3, 0.7, 1.0)
        for metallic in (0.0, 1.0)
    },
}


ANISOTROPIC = "ShaderNodeBsdfAnisotropic"  #: From 4.0 on all of Glossy is.


def along_tangent(build: Build, **settings: object) -> Build:
    """With a Tangent node that has these settings."""

    def linked(new: Callable[[str], bpy.types.Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        output = build(new, link)
        tangent = new("ShaderNodeTangent")
        for name, value in settings.items():
            setattr(tangent, name, value)
        link(tangent.outputs[0], output.node.inputs["Tangent"])
        return output

    return linked


def glossy(distribution: str, roughness: float, **inputs: object) -> Build:
    kind = ANISOTROPIC if inputs else GLOSSY
    return shader(kind, Color=GOLD, Roughness=roughness, node_distribution=distribution, **inputs)


#: How facets lie; what is not asked of every version is under `costly`.
FACETS: dict[str, Build] = {
    "anisotropic 0.7": glossy("GGX", 0.4, Anisotropy=0.7, Rotation=0.15),
    "beckmann": glossy("BECKMANN", 0.4),
    "ashikhmin and shirley": glossy("ASHIKHMIN_SHIRLEY", 0.4),
    "principled along": principled(Base_Color=GOLD, Metallic=0.7, Anisotropic=0.8, Anisotropic_Rotation=0.1),
}
COSTLY_FACETS: dict[str, Build] = {
    "anisotropic -0.6": along_tangent(glossy("GGX", 0.5, Anisotropy=-0.6), direction_type="RADIAL", axis="X"),
    "beckmann 0.7": glossy("BECKMANN", 0.4, Anisotropy=0.7, Rotation=0.3),
    "beckmann, rough": glossy("BECKMANN", 0.9),
    "ashikhmin and shirley 0.7": glossy("ASHIKHMIN_SHIRLEY", 0.5, Anisotropy=0.7),
}
if not IS_OLD:
    COSTLY_FACETS["anisotropic, multiple"] = glossy("MULTI_GGX", 0.8, Anisotropy=0.7)
    COSTLY_FACETS["principled along, multiple"] = principled(
        Roughness=0.8, Anisotropic=1.0, node_distribution="MULTI_GGX"
    )
if HAS_METALLIC:
    metallic = {"Base_Color": GOLD, "Anisotropy": 0.8, "Rotation": 0.2, "Roughness": 0.5}
    COSTLY_FACETS["metallic along"] = shader("ShaderNodeBsdfMetallic", **metallic, node_distribution="MULTI_GGX")
    COSTLY_FACETS["metallic of beckmann"] = shader("ShaderNodeBsdfMetallic", **metallic, node_distribution="BECKMANN")


def check(build: Build, light_it: object, samples: int = 1, cycles_samples: int = 2) -> None:
    assert_like_cycles(scene_of(build, light_it), BOUND, samples, cycles_samples)


@pytest.mark.parametrize("name", SHADERS)
def test_a_shader_under_a_sun(name: str) -> None:
    check(SHADERS[name], sun(TILT))


# Seen to fail with widths exchanged, half of the rotation, and Beckmann's drawn as GGX.
@pytest.mark.parametrize("name", [*FACETS, *(pytest.param(name, marks=pytest.mark.costly) for name in COSTLY_FACETS)])
def test_how_facets_lie_under_a_sun(name: str) -> None:
    check((FACETS | COSTLY_FACETS)[name], sun(TILT))


@pytest.mark.costly
def test_how_facets_lie_under_a_lamp_with_a_size() -> None:
    check(COSTLY_FACETS["beckmann 0.7"], lamp(0.3), 64, 256)


@pytest.mark.costly
@pytest.mark.parametrize(
    "of_roughness",
    [
        lambda roughness: glossy("GGX", roughness, Anisotropy=0.5),
        lambda roughness: principled(Roughness=roughness, Metallic=1.0, Anisotropic=0.5),
    ],
    ids=["glossy", "principled"],
)
def test_a_mirror_says_that_it_is_as_sharp_along_its_tangent_as_across(of_roughness: Callable[[float], Build]) -> None:
    """One without any width is."""
    said = []
    for roughness in (0.02, 0.0):
        scene = scene_of(of_roughness(roughness), sun(TILT), 8)
        scene.tyndall.indirect.has_mirrors = True
        tyndall_pixels(scene)
        reports = last_render.statistics_of(scene.name)["reports"]
        said.append(any("as sharp along its tangent" in str(line) for line in reports))
    assert said == [True, False]


@pytest.mark.dealt
@pytest.mark.parametrize("kind", ["glossy", "coat", "principled"])
def test_what_is_nearly_a_mirror_shows_a_sun_without_a_size(kind: str) -> None:
    """On facets that lean a little past it; what is narrower than Cycles draws shows none of it."""
    coat = {"Coat_IOR": 1.7} if bpy.app.version >= (4, 0, 0) else {}
    name = "Coat_Roughness" if bpy.app.version >= (4, 0, 0) else "Clearcoat_Roughness"
    builds = {
        "glossy": lambda roughness: shader(GLOSSY, Color=RED, Roughness=roughness, node_distribution="GGX"),
        "coat": lambda roughness: principled(Clearcoat=1.0, **coat, **{name: roughness}),
        "principled": lambda roughness: principled(Base_Color=RED, Roughness=roughness),
    }
    brightness = []
    for roughness in (0.003, 0.0165, 0.0185, 0.025, 0.03):
        scene = scene_of(builds[kind](roughness), sun(30.0))
        ours, cycles = (shown[24:30, 27:32] for shown in (tyndall_pixels(scene, 1), cycles_pixels(scene, 2, seed=1)))
        assert ours == pytest.approx(cycles, rel=2e-3, abs=1e-4)
        brightness.append(float(ours.sum()))
    assert brightness[-1] > 1.002 * brightness[0]


@pytest.mark.parametrize("tilt", [0.0, TILT])
def test_what_has_no_material(tilt: float) -> None:
    """Grey and diffuse; from 5.0 on it is a Principled BSDF."""
    scene = scene_of(SHADERS["rough diffuse"], sun(tilt))
    bpy.data.objects["Ball"].data.materials.clear()
    ours, cycles = tyndall_pixels(scene, 1), cycles_pixels(scene, 2, seed=1)
    mean, median = errors(ours, cycles)
    assert mean <= BOUND / 5
    assert median <= BOUND / 5


@pytest.mark.dealt
@pytest.mark.parametrize("name", ["principled", "glossy 0.2"])
@pytest.mark.parametrize("light_it", [lamp(0.3), world()], ids=["lamp", "world"])
def test_lights_with_a_size(name: str, light_it: object) -> None:
    check(SHADERS[name], light_it, 256, 1024)


@pytest.mark.parametrize("tilt", [150.0, 100.0])
def test_translucent_surfaces_are_lit_from_behind(tilt: float) -> None:
    scene = pane_scene(shader("ShaderNodeBsdfTranslucent", Color=RED), sun(tilt))
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, 2, seed=1)
    assert cycles.mean() > 0.01
    assert ours == pytest.approx(cycles, rel=1e-4)


# Seen to fail: without what facets hide, with the other side's share, and with that of clear glass in the coloured one.
@pytest.mark.skipif(IS_OLD, reason="rough glass of 3.4 has one share over the whole lobe")
@pytest.mark.parametrize("turn", [0.0, pi], ids=["from without", "from within"])
@pytest.mark.parametrize("tilt", [10.0, 60.0])
@pytest.mark.parametrize("kind", ["glass", "coloured glass", "principled"])
def test_what_rough_glass_mirrors(kind: str, tilt: float, turn: float) -> None:
    """With what its facets hide: 0 bounces are black in Cycles behind it."""
    rough = {"Roughness": 0.7, "node_distribution": "MULTI_GGX"}
    builds = {
        "glass": shader("ShaderNodeBsdfGlass", IOR=1.5, **rough),
        "coloured glass": shader("ShaderNodeBsdfGlass", Color=RED, IOR=1.8, **rough),
        "principled": principled(Base_Color=RED, IOR=1.3, Transmission=1.0, **rough),
    }
    scene = pane_scene(builds[kind], sun(tilt), turn)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, 2, seed=1)
    assert cycles.mean() > 0.003
    assert ours == pytest.approx(cycles, rel=2e-3)


@pytest.mark.long
@pytest.mark.parametrize("tilt", [0.0, 30.0, 70.0, 110.0])
@pytest.mark.parametrize("name", [*SHADERS, *LONG])
def test_a_shader_under_suns_of_all_heights(name: str, tilt: float) -> None:
    check((SHADERS | LONG)[name], sun(tilt))


@pytest.mark.long
@pytest.mark.parametrize("tilt", [0.0, 30.0, 70.0])
@pytest.mark.parametrize("name", [*FACETS, *COSTLY_FACETS])
def test_how_facets_lie_under_suns_of_other_heights(name: str, tilt: float) -> None:
    """From behind, at 110 degrees, one pixel on an edge of the ball is a hundredth of all light."""
    check((FACETS | COSTLY_FACETS)[name], sun(tilt))


@pytest.mark.long
@pytest.mark.parametrize("light_it", [lamp(0.05), lamp(0.5), world(), sun(TILT, angle=10.0)])
@pytest.mark.parametrize("name", [*SHADERS, *FACETS])
def test_every_shader_under_lights_with_a_size(name: str, light_it: object) -> None:
    check((SHADERS | FACETS)[name], light_it, 256, 1024)


def test_a_pane_that_transmits_tints_what_is_behind_it_as_in_cycles() -> None:
    """One side's colour, before an even world; in Cycles 5 % of all colours are lost where indices do not differ."""
    scene = empty_scene(8)
    pane = principled(Base_Color=(0.04, 0.36, 0.81, 1.0), Roughness=0.0, IOR=1.0, Transmission=1.0, Specular=0.0)
    plane(0.0, material("Pane", pane))
    world(1.0)(scene)
    scene.render.film_transparent = False
    ours, cycles = (
        pixels.mean(axis=(0, 1)) for pixels in (tyndall_pixels(scene, 16), cycles_pixels(scene, 64, seed=1))
    )
    assert ours == pytest.approx(cycles, rel=0.06)
    assert ours / ours[2] == pytest.approx(cycles / cycles[2], rel=5e-3)
