# SPDX-License-Identifier: GPL-3.0-or-later
"""Watts, exposure and temperature of lights mean what they mean in Cycles: a lit plane, looked at from above."""

from __future__ import annotations

from math import radians

import bpy
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import empty_scene, light, material, node, plane

HAS_EXPOSURE = bpy.app.version >= (4, 5, 0)
LIGHTS: dict[str, tuple[str, dict[str, object]]] = {
    "sun": ("SUN", {"energy": 3.0, "angle": 0.0, "color": (1.0, 0.5, 0.2)}),
    "wide sun": ("SUN", {"energy": 3.0, "angle": 1.0}),
    "point": ("POINT", {"energy": 100.0, "shadow_soft_size": 0.0, "color": (1.0, 0.5, 0.2)}),
    "ball": ("POINT", {"energy": 100.0, "shadow_soft_size": 0.5}),
    "spot": ("SPOT", {"energy": 100.0, "shadow_soft_size": 0.0, "spot_blend": 0.0}),
    "square": ("AREA", {"energy": 100.0, "size": 1.0, "color": (1.0, 0.5, 0.2)}),
    "rectangle": ("AREA", {"energy": 100.0, "shape": "RECTANGLE", "size": 2.0, "size_y": 0.3}),
    "disk": ("AREA", {"energy": 100.0, "shape": "DISK", "size": 1.5, "size_y": 9.0}),
    "ellipse": ("AREA", {"energy": 100.0, "shape": "ELLIPSE", "size": 0.4, "size_y": 2.5}),
    "soft box": ("AREA", {"energy": 100.0, "shape": "RECTANGLE", "size": 1.0, "size_y": 0.3, "spread": 1.2}),
    "beam": ("AREA", {"energy": 10.0, "size": 1.0, "spread": radians(3)}),  # of a disk, Cycles 3.4 samples all
}
if HAS_EXPOSURE:
    LIGHTS |= {
        "exposed": ("POINT", {"energy": 100.0, "shadow_soft_size": 0.0, "exposure": 1.5}),
        "warm": ("POINT", {"energy": 100.0, "shadow_soft_size": 0.0, "use_temperature": True, "temperature": 3000.0}),
        "point, not normalised": ("POINT", {"energy": 100.0, "shadow_soft_size": 0.0, "normalize": False}),
        "ball, not normalised": ("POINT", {"energy": 100.0, "shadow_soft_size": 0.5, "normalize": False}),
        "area, not normalised": ("AREA", {"energy": 100.0, "shape": "ELLIPSE", "size_y": 0.3, "normalize": False}),
        "sun, not normalised": ("SUN", {"energy": 100.0, "angle": 0.1, "normalize": False}),
    }


def lit_plane() -> bpy.types.Scene:
    scene = empty_scene()
    grey = material("Grey", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs[0])
    plane(material=grey)
    return scene


def agree(scene: bpy.types.Scene, tolerance: float) -> None:
    ours = tyndall_pixels(scene, surface_samples=64).mean(axis=(0, 1))
    cycles = cycles_pixels(scene, samples=64, seed=1).mean(axis=(0, 1))
    assert cycles.max() > 0.01
    assert ours == pytest.approx(cycles, rel=tolerance)


@pytest.mark.parametrize("name", LIGHTS)
def test_a_light_is_as_bright_as_in_cycles(name: str) -> None:
    """Lights with a size are sampled by both, which leaves some noise."""
    kind, properties = LIGHTS[name]
    scene = lit_plane()
    light(kind, (0, 0, 2), **properties)
    has_size = kind == "AREA" or properties.get("shadow_soft_size", 0.0) or properties.get("angle", 0.0)
    agree(scene, 1e-2 if has_size else 1e-4)


@pytest.mark.parametrize("scale", [(1, 1, 0), (0, 1, 1), (1, 0, 0), (0, 0, 0)])
@pytest.mark.parametrize("kind", ["POINT", "SUN"])
def test_a_flat_light_shines_where_it_does_in_cycles(kind: str, scale: tuple[int, int, int]) -> None:
    """A point light wherever it is, a sun as long as it has an axis."""
    scene = lit_plane()
    lamp = light(kind, (0, 0, 1), energy=3.0 if kind == "SUN" else 100.0)
    lamp.scale, lamp.rotation_euler = scale, (0.3, 0.2, 0.1)
    if kind == "SUN":
        lamp.data.angle = 0.0
    else:
        lamp.data.shadow_soft_size = 0.0
    if kind == "POINT" or scale[2] == 1:
        agree(scene, 1e-3)
    else:
        assert cycles_pixels(scene, samples=1, seed=1).max() == tyndall_pixels(scene).max() == 0.0


def test_a_lights_own_nodes_multiply_its_strength() -> None:
    scene = lit_plane()
    lamp = light("POINT", (0, 0, 2), energy=100.0, shadow_soft_size=0.0)
    lamp.data.use_nodes = True
    glow = lamp.data.node_tree.nodes["Emission"]
    glow.inputs["Color"].default_value, glow.inputs["Strength"].default_value = (0.2, 0.5, 1.0, 1.0), 1.7
    agree(scene, 1e-4)


def test_a_world_of_one_colour_lights_evenly() -> None:
    scene = lit_plane()
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (0.2, 0.5, 1.0, 1.0), 0.7
    agree(scene, 1e-2)
