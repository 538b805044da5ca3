# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps, meshes that glow, and worlds light the shaders that their ray visibility lets see them, as in Cycles."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, Node, cube, empty_scene, light, material, node, plane

pytestmark = pytest.mark.dealt

_IS_4 = bpy.app.version >= (4, 0, 0)
_SHADERS: dict[str, Build] = {
    "diffuse": lambda new, _: node(new, "ShaderNodeBsdfDiffuse").outputs[0],
    "glossy": lambda new, _: node(
        new, "ShaderNodeBsdfAnisotropic" if _IS_4 else "ShaderNodeBsdfGlossy", Roughness=0.5
    ).outputs[0],
    "Principled": lambda new, _: node(new, "ShaderNodeBsdfPrincipled").outputs[0],
    "sheen": lambda new, _: node(new, "ShaderNodeBsdfSheen" if _IS_4 else "ShaderNodeBsdfVelvet").outputs[0],
    "translucent": lambda new, _: node(new, "ShaderNodeBsdfTranslucent").outputs[0],
}


def _emitter(kind: str, height: float) -> bpy.types.Object:
    """Above the floor, or below it."""
    if kind == "MESH":
        glowing = material("Glow", lambda new, _: node(new, "ShaderNodeEmission", Strength=20.0).outputs[0])
        box = cube("Glow", glowing)
        box.scale, box.location, box.visible_camera = (0.3, 0.3, 0.3), (0.5, 1.0, height), False
        return box
    lamp = light(kind, (0.5, 1.0, height), energy=3.0 if kind == "SUN" else 100.0)
    if kind == "AREA":
        lamp.data.size = 0.5
    lamp.rotation_euler.x = math.pi if height < 0.0 else 0.0
    return lamp


def _lit(kind: str, shader: str, hidden: str) -> bpy.types.Scene:
    scene = empty_scene()
    scene.camera.data.type = "PERSP"
    scene.camera.location, scene.camera.rotation_euler = (0.0, -4.0, 3.0), (0.9, 0.0, 0.0)
    plane(0.0, material("Floor", _SHADERS[shader]))
    setattr(_emitter(kind, -1.5 if shader == "translucent" else 1.5), hidden, False)
    return scene


# Seen to fail where only "Diffuse" was looked at, and kept all light from all surfaces: lamps that artists keep out of
# reflections showed in them.
@pytest.mark.parametrize("hidden", ["visible_diffuse", "visible_glossy", "visible_transmission"])
@pytest.mark.parametrize("kind", ["POINT", "SUN", "AREA", "MESH"])
def test_an_emitter_lights_what_sees_it_as_in_cycles(kind: str, hidden: str) -> None:
    """Of Cycles' rays that surfaces send, a few find a mesh that is hidden from others, and a few miss it."""
    bounds = {"rel": 0.05, "abs": 1e-2} if kind == "MESH" else {"rel": 0.02, "abs": 1e-4}
    for shader in _SHADERS:
        scene = _lit(kind, shader, hidden)
        cycles = cycles_pixels(scene, samples=4096 if kind == "MESH" else 256, seed=1).mean()
        assert tyndall_pixels(scene, 256).mean() == pytest.approx(cycles, **bounds), shader


# Seen to fail where what lights surfaces and air asked as diffuse rays do.
@pytest.mark.parametrize("hidden", ["diffuse", "glossy", "scatter"])
@pytest.mark.parametrize("varies", [False, True])
def test_a_world_lights_what_sees_it_as_in_cycles(hidden: str, *, varies: bool) -> None:
    """In Cycles transmission keeps it from translucent shaders, which here are diffuse.

    Before 5.0 a ray that one of a point's shaders sends has the light of all of them: of a Principled BSDF's gloss half
    as much again, and in 3.4 something of velvet.
    """

    def fog(new: Callable[[str], Node], _: object) -> bpy.types.NodeSocket:
        return node(new, "ShaderNodeVolumeScatter", Density=0.3).outputs[0]

    for shader in (*_SHADERS, "fog"):
        scene = _lit("SUN", "diffuse" if shader == "fog" else shader, "visible_camera")
        bpy.data.objects.remove(next(thing for thing in scene.objects if thing.type == "LIGHT"))
        tree = scene.world.node_tree
        tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        if varies:
            gradient = tree.nodes.new("ShaderNodeTexGradient")
            tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], gradient.inputs[0])
            tree.links.new(gradient.outputs[0], tree.nodes["Background"].inputs["Color"])
        if shader == "fog":
            bpy.data.objects.remove(bpy.data.objects["Plane"])
            cube("Fog", material("Fog", volume=fog)).scale = (2.0, 2.0, 2.0)
        if shader in {"Principled", "sheen"} and bpy.app.version < (5, 0, 0):
            continue
        setattr(scene.world.cycles_visibility, hidden, False)
        cycles = cycles_pixels(scene, samples=512, seed=1).mean()
        assert tyndall_pixels(scene, 64).mean() == pytest.approx(cycles, rel=0.03, abs=1e-4), shader


@pytest.mark.parametrize("kind", ["POINT", "AREA"])
def test_many_lamps_light_what_sees_them(kind: str) -> None:
    """Forty in one place, half of which are kept from gloss: as many as light it."""

    def picture(count: int, hidden_count: int, shader: str) -> float:
        scene = _lit("SUN", shader, "visible_camera")
        bpy.data.objects.remove(next(thing for thing in scene.objects if thing.type == "LIGHT"))
        for index in range(count):
            _emitter(kind, 1.5).visible_glossy = index >= hidden_count
        return float(tyndall_pixels(scene, 64).mean())

    for shader, lit_count in (("glossy", 20), ("diffuse", 40)):
        expected = picture(lit_count, 0, shader)
        assert picture(40, 20, shader) == pytest.approx(expected, rel=0.03), shader


def test_a_lamp_that_gloss_does_not_see_shows_in_no_mirror() -> None:
    """A large panel over polished metal, which is followed."""
    scene = empty_scene()
    scene.camera.data.ortho_scale = 0.5
    metal = material(
        "Metal", lambda new, _: node(new, "ShaderNodeBsdfPrincipled", Metallic=1.0, Roughness=0.0).outputs[0]
    )
    plane(0.0, metal)
    indirect = scene.tyndall.indirect
    indirect.has_mirrors = indirect.has_refraction = True
    panel = light("AREA", (0.0, 0.0, 4.0), energy=100.0)
    panel.data.size = 3.0
    assert tyndall_pixels(scene).mean() > 1.0
    panel.visible_glossy = False
    assert tyndall_pixels(scene).max() == pytest.approx(0.0, abs=1e-6)
