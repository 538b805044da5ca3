# SPDX-License-Identifier: GPL-3.0-or-later
"""Phase functions of scatter nodes beside Cycles: by the angle of a sun, and around a lamp within the fog."""

from __future__ import annotations

import math

import bpy
import pytest

from support.cycles_reference import tyndall_pixels as pixels_by_methods
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, cube, empty_scene, light, material, node

pytestmark = pytest.mark.skipif(bpy.app.version < (4, 3, 0), reason="Henyey-Greenstein's is the only one before 4.3")

#: Of Fournier and Forand's the fit is 1 to 2 % off.
PHASES: dict[str, tuple[str, dict[str, float], float]] = {
    "Rayleigh": ("RAYLEIGH", {}, 0.006),
    "Draine": ("DRAINE", {"Anisotropy": 0.5, "Alpha": 8.0}, 0.006),
    "Draine back": ("DRAINE", {"Anisotropy": -0.6, "Alpha": 0.5}, 0.006),
    "dust of 0.05 um": ("MIE", {"Diameter": 0.05}, 0.006),
    "haze of 0.7 um": ("MIE", {"Diameter": 0.7}, 0.006),
    "mist of 3 um": ("MIE", {"Diameter": 3.0}, 0.006),
    "fog of 20 um": ("MIE", {"Diameter": 20.0}, 0.006),
    "water": ("FOURNIER_FORAND", {"IOR": 1.33, "Backscatter": 0.1}, 0.02),
    "clear water": ("FOURNIER_FORAND", {"IOR": 1.1, "Backscatter": 0.02}, 0.02),
}


def fog_of(phase: str, inputs: dict[str, float]) -> Build:
    def build(new: object, _link: object) -> bpy.types.NodeSocket:
        made = node(new, "ShaderNodeVolumeScatter", Color=(0.9, 0.6, 0.3, 1.0), Density=0.3)
        made.phase = phase
        for socket, value in inputs.items():
            made.inputs[socket].default_value = value
        return made.outputs[0]

    return build


def fog(name: str) -> Build:
    phase, inputs, _ = PHASES[name]
    return fog_of(phase, inputs)


# Seen to fail: all of them as Henyey and Greenstein's, which they were read as; Mie's shares the other way round; an
# alpha without its total.
@pytest.mark.parametrize("name", PHASES)
def test_a_sun_lights_fog_from_each_side_as_in_cycles(name: str) -> None:
    """Pictures of 64 pixels, one for each of five angles between straight on and straight back."""
    scene = empty_scene()
    cube("Fog", material("Fog", volume=fog(name)))
    sun = light("SUN", (0, 0, 0), energy=1.0, angle=0.0)
    for angle_deg in (8.0, 40.0, 90.0, 130.0, 170.0):
        sun.rotation_euler.x = math.pi - math.radians(angle_deg)
        ours = tyndall_pixels(scene).mean(axis=(0, 1))
        reference = cycles_pixels(scene, samples=1024, seed=1).mean(axis=(0, 1))
        assert ours == pytest.approx(reference, rel=PHASES[name][2] + 0.006), angle_deg


# Seen to fail: dark, where the squared cosine's factor and its total were both beyond floats.
def test_absurd_values_leave_fog_lit() -> None:
    for phase, inputs in (
        ("DRAINE", {"Anisotropy": 0.5, "Alpha": 1e30}),
        ("MIE", {"Diameter": 1e30}),
        ("MIE", {"Diameter": -3.0}),
        ("FOURNIER_FORAND", {"IOR": 1e30, "Backscatter": 1e30}),
        ("FOURNIER_FORAND", {"IOR": 0.0, "Backscatter": -1.0}),
    ):
        scene = empty_scene()
        cube("Fog", material("Fog", volume=fog_of(phase, inputs)))
        light("POINT", (0.3, 0.2, 0.1), energy=100.0, shadow_soft_size=0.0)
        pixels = tyndall_pixels(scene)
        assert 0.05 < pixels.min() <= pixels.max() < 100.0, phase


# Seen to fail: without the squared cosine along rays (local_scatter_kernel.cpp).
@pytest.mark.parametrize("name", PHASES)
def test_a_lamp_in_fog_is_as_in_cycles(name: str) -> None:
    scene = empty_scene(24)
    scene.camera.data.ortho_scale = 1.2
    cube("Fog", material("Fog", volume=fog(name)))
    light("POINT", (0.8, 0.4, 0.1), energy=10.0, shadow_soft_size=0.0)
    reference = cycles_pixels(scene, samples=512, seed=1).mean(axis=(0, 1))
    for picture in pixels_by_methods(scene, ["EXACT", "EPIPOLAR"], light_samples=1, world_samples=0):
        assert picture.mean(axis=(0, 1)) == pytest.approx(reference, rel=PHASES[name][2])


# Seen to fail: without what Draine's factor adds in all.
@pytest.mark.parametrize("name", ["Rayleigh", "Draine", "Draine back", "clear water"])
def test_the_world_lights_fog_as_in_cycles(name: str) -> None:
    """Where half of it, below the horizon, is dark. Cycles finds 3 to 5 % more or less of it than is there in Mie's."""
    scene = empty_scene(16)
    scene.camera.data.ortho_scale = 3.0
    tree = scene.world.node_tree
    above = node(tree.nodes.new, "ShaderNodeSeparateXYZ")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], above.inputs[0])
    bright = tree.nodes.new("ShaderNodeMath")
    bright.operation, bright.inputs[1].default_value = "MAXIMUM", 0.0
    tree.links.new(above.outputs["Z"], bright.inputs[0])
    tree.links.new(bright.outputs[0], tree.nodes["Background"].inputs["Strength"])
    tree.nodes["Background"].inputs["Color"].default_value = (1.0, 0.8, 0.6, 1.0)
    cube("Fog", material("Fog", volume=fog(name)))
    scene.camera.rotation_euler = (1.2, 0.3, 0.0)
    scene.camera.location = (0.0, -2.8, 1.0)
    reference = cycles_pixels(scene, samples=512, seed=1).mean(axis=(0, 1))
    (ours,) = pixels_by_methods(scene, ["EXACT"], light_samples=1, world_samples=1024)
    assert ours.mean(axis=(0, 1)) == pytest.approx(reference, rel=0.01)
