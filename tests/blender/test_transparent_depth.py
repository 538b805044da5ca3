# SPDX-License-Identifier: GPL-3.0-or-later
"""Light Path's Transparent Depth counts as in Cycles: along camera rays, in mirrors, and on the way to lights.

Lights have no size: ours has no noise, and Cycles' is of the light and of the rays that it picks.
"""

from __future__ import annotations

from math import radians
from typing import TYPE_CHECKING

import bpy
import numpy as np
import pytest

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, cube, empty_scene, light, material, node, plane

pytestmark = pytest.mark.dealt

if TYPE_CHECKING:
    from collections.abc import Callable

SIZE_PX = 16
GLOSSY = "ShaderNodeBsdfGlossy" if bpy.app.version < (4, 0, 0) else "ShaderNodeBsdfAnisotropic"


def by_depth(operation: str, *numbers: float, is_glowing: bool = True) -> Build:
    """Transparent by a number that is made of the depth; what is left glows by the depth, or is black."""

    def build(new: Callable[[str], bpy.types.Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        path, share, mix = new("ShaderNodeLightPath"), new("ShaderNodeMath"), new("ShaderNodeMixShader")
        share.operation = operation
        for socket, number in zip(share.inputs[1:], numbers, strict=False):
            socket.default_value = number
        link(path.outputs["Transparent Depth"], share.inputs[0])
        link(share.outputs[0], mix.inputs["Fac"])
        if is_glowing:
            glow = node(new, "ShaderNodeEmission", Color=(0.5, 0.7, 1.0, 1.0))
            link(path.outputs["Transparent Depth"], glow.inputs["Strength"])
            link(glow.outputs[0], mix.inputs[1])
        link(new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
        return mix.outputs[0]

    return build


def grey(new: Callable[[str], bpy.types.Node], _link: object) -> bpy.types.NodeSocket:
    return node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs[0]


def sheets(*, are_glowing: bool) -> bpy.types.Scene:
    """Five of two kinds, seen from above: each lets less pass the more there were before."""
    scene = empty_scene(SIZE_PX)
    scene.camera.location.x = 0.3  # not above the diagonals, where Cycles' rays leave through the other triangle
    counting = material("Counting", by_depth("MULTIPLY_ADD", -0.07, 0.95, is_glowing=are_glowing))
    veil = material("Veil", lambda new, _: node(new, "ShaderNodeBsdfTransparent", Color=(0.8, 0.9, 1, 1)).outputs[0])
    for place, kind in enumerate([counting, veil, counting, counting, veil]):
        plane(0.4 + 0.4 * place, kind)
    return scene


def agree(scene: bpy.types.Scene, bound: float = 0.01) -> None:
    ours, cycles = (
        pixels.reshape(2, SIZE_PX // 2, 2, SIZE_PX // 2, 3).mean(axis=(1, 3))
        for pixels in (tyndall_pixels(scene), cycles_pixels(scene, 1024, seed=1))
    )
    assert cycles.min() > 0.01
    assert ours == pytest.approx(cycles, rel=bound)


def test_what_glows_is_seen_through_sheets() -> None:
    agree(sheets(are_glowing=True))


# Seen to fail with a count of 0 for the sun's light, and with one that begins at 0 where the camera's has passed some.
def test_a_sun_lights_what_is_behind_sheets() -> None:
    scene = sheets(are_glowing=False)
    plane(0.0, material("Floor", grey))
    light("SUN", (0, 0, 5), energy=300.0, angle=0.0).rotation_euler.y = radians(20.0)
    agree(scene)


def test_a_room_is_seen_through_its_first_wall() -> None:
    """The trick of interiors: light from outside must not come through walls that the camera sees through."""
    scene = empty_scene(SIZE_PX)
    scene.camera.data.type, scene.camera.location = "PERSP", (0.1, 0.2, 6)
    walls = material("Walls", by_depth("LESS_THAN", 0.5))
    mix = walls.node_tree.nodes["Mix Shader"]
    walls.node_tree.links.new(grey(walls.node_tree.nodes.new, None), mix.inputs[1])
    cube("Room", walls)
    light("SUN", (0, 0, 5), energy=3.0, angle=0.0).rotation_euler.y = radians(30.0)
    light("POINT", (0.3, -0.4, 0.2), energy=20.0, shadow_soft_size=0.0)
    agree(scene)


# Seen to fail below the surface, where light began to count anew.
@pytest.mark.parametrize("kind", ["diffuse", "gloss", "below the surface", "from behind"])
@pytest.mark.parametrize("light_it", ["sun", "world", "what glows", "lamps"])
def test_a_wall_that_the_camera_alone_sees_through_keeps_light_out(kind: str, light_it: str) -> None:
    """Whatever waits for light behind it."""
    builds = {
        "diffuse": grey,
        "gloss": lambda new, _: node(new, GLOSSY, Roughness=0.5).outputs[0],
        "below the surface": lambda new, _: node(new, "ShaderNodeSubsurfaceScattering", Scale=0.05).outputs[0],
        "from behind": lambda new, _: node(new, "ShaderNodeBsdfTranslucent").outputs[0],
    }
    scene = empty_scene(SIZE_PX)
    shown = material("Thing", builds[kind])
    if kind == "from behind":
        plane(0.0, shown, half_side=0.5)
    else:
        cube("Thing", shown).scale = (0.5, 0.5, 0.5)
    wall = cube("Wall", material("Wall", by_depth("LESS_THAN", 0.5, is_glowing=False)))
    if light_it == "world":
        scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    elif light_it == "what glows":
        glow = material("Glow", lambda new, _: node(new, "ShaderNodeEmission", Strength=5.0).outputs[0])
        for height in (-4.0, 4.0):
            plane(height, glow, half_side=2.0).location.x = 2.5  # beside the camera's way
    elif light_it == "lamps":  # so many that a tree picks among them
        for place in range(40):
            light("POINT", (2.0, 0.1 * place, 3.0 if place % 2 else -3.0), energy=100.0, shadow_soft_size=0.1)
    else:
        for tilt in (20.0, 160.0):
            light("SUN", (0, 0, 5), energy=3.0, angle=0.0).rotation_euler.y = radians(tilt)
    scene.tyndall.indirect.has_bounce = True
    assert tyndall_pixels(scene, 4).max() == 0.0
    bpy.data.objects.remove(wall)
    assert tyndall_pixels(scene, 4).mean() > 0.01


def test_light_shafts_say_that_they_do_not_count() -> None:
    scene = sheets(are_glowing=False)
    light("SUN", (0, 0, 5), energy=3.0, angle=0.0)
    for has_fog in (False, True):
        if has_fog:
            cube("Fog", material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter").outputs[0]))
        tyndall_pixels(scene)
        reports = last_render.statistics_of(scene.name)["reports"]
        assert any("Transparent Depth is 0" in str(line) for line in reports) == has_fog


def test_a_mirror_does_not_begin_anew() -> None:
    scene = empty_scene(SIZE_PX)
    scene.camera.location.x = 0.3
    plane(0.0, material("Mirror", lambda new, _: node(new, "ShaderNodeBsdfGlossy", Roughness=0.0).outputs[0]))
    plane(1.0, material("Pane", by_depth("LESS_THAN", 1.5)))
    plane(2.0, material("Other", by_depth("LESS_THAN", 1.5)))
    scene.tyndall.indirect.has_mirrors = True
    # Both are met from above with counts of 0 and 1, and pass; the pane from below with 2.
    assert tyndall_pixels(scene) == pytest.approx(
        0.8 * 2.0 * np.array([0.5, 0.7, 1.0]) * np.ones((SIZE_PX, SIZE_PX, 3)), rel=1e-3
    )


@pytest.mark.parametrize("second", [0.1, 0.7])
def test_shaders_that_let_more_light_pass_than_there_is_are_named(second: float) -> None:
    """Two transparent ones, added: above 1 Cycles brightens what lies behind, and here all of it passes."""

    def both(new: Callable[[str], bpy.types.Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        added = new("ShaderNodeAddShader")
        for socket, share in zip(added.inputs, (0.8, second), strict=True):
            link(node(new, "ShaderNodeBsdfTransparent", Color=(share, 0.5, 0.5, 1)).outputs[0], socket)
        return added.outputs[0]

    scene = empty_scene(4)
    plane(0.0, material("Glow", lambda new, _: node(new, "ShaderNodeEmission", Color=(0.4, 0.6, 0.8, 1)).outputs[0]))
    plane(1.0, material("Both", both))
    pixels = tyndall_pixels(scene)
    behind = np.array((0.4, 0.6, 0.8)) * (min(0.8 + second, 1.0), 1.0, 1.0)
    assert np.allclose(pixels[..., :3], behind, atol=1e-5)
    reports = [line for line in last_render.statistics_of("Scene")["reports"] if '"Both"' in line]
    assert len(reports) == (1 if second > 0.2 else 0)
    assert all(line.endswith("lets more light through than meets it: all of it passes") for line in reports)
    if not reports:
        assert np.allclose(pixels[..., :3], cycles_pixels(scene, samples=1, seed=1)[..., :3], atol=1e-5)
