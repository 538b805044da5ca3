# SPDX-License-Identifier: GPL-3.0-or-later
"""What glows or shines below 0 is shown so and takes light away, as in Cycles: artists darken corners with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import cube, empty_scene, light, material, node, plane

if TYPE_CHECKING:
    from collections.abc import Callable

    from support.patch_nodes import Link, New, Socket

pytestmark = pytest.mark.dealt
BLOCK_PX = 8


LESS = (0.4, 0.2, 0.1)


def normals(new: New, link: Link, subtracted: tuple[float, float, float] = LESS) -> Socket:
    """Each direction's, less so much of each colour that all have parts below 0."""
    less = node(new, "ShaderNodeVectorMath")
    less.operation, less.inputs[1].default_value = "SUBTRACT", subtracted
    link(new("ShaderNodeNewGeometry").outputs["Normal"], less.inputs[0])
    return less.outputs[0]


def glows(new: New, link: Link) -> Socket:
    emission = new("ShaderNodeEmission")
    link(normals(new, link), emission.inputs["Color"])
    return emission.outputs[0]


def is_dark(new: New, _link: Link) -> Socket:
    return node(new, "ShaderNodeEmission", Strength=-3.0).outputs[0]


def ball(surface: Callable[[New, Link], Socket]) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.6, location=(1.2, 1.0, 0.5))
    bpy.context.object.data.materials.append(material("Below 0", surface))


def world(*, varies: bool) -> None:
    bpy.context.scene.world = bpy.data.worlds.new("Below 0")
    bpy.context.scene.world.use_nodes = True
    tree = bpy.context.scene.world.node_tree
    background = next(one for one in tree.nodes if one.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1.0, 0.8, 0.6, 1.0)
    background.inputs["Strength"].default_value = 0.3 if varies else -0.3
    if varies:
        tree.links.new(normals(tree.nodes.new, tree.links.new), background.inputs["Color"])


def lamp(kind: str, *, varies: bool, subtracted: tuple[float, float, float] = LESS) -> None:
    size = {"size": 0.5} if kind == "AREA" else {}
    made = light(kind, (1.2, 1.0, 1.5), energy=(1.0 if kind == "SUN" else 60.0) * (1.0 if varies else -1.0), **size)
    if varies:
        made.data.use_nodes = True
        tree = made.data.node_tree
        emission = next(one for one in tree.nodes if one.type == "EMISSION")
        tree.links.new(normals(tree.nodes.new, tree.links.new, subtracted), emission.inputs["Color"])


MAKERS: dict[str, Callable[[], None]] = {
    "POINT that sends as much as it takes": lambda: lamp("POINT", varies=True, subtracted=(0.0, 0.0, 0.0)),
    "a ball in the colours of its normals": lambda: ball(glows),
    "a ball that is dark": lambda: ball(is_dark),
    "a world that varies": lambda: world(varies=True),
    "a world": lambda: world(varies=False),
    **{f"{kind} that varies": (lambda kind=kind: lamp(kind, varies=True)) for kind in ("POINT", "SPOT", "SUN", "AREA")},
    **{kind: (lambda kind=kind: lamp(kind, varies=False)) for kind in ("POINT", "SPOT", "SUN", "AREA")},
}


@pytest.mark.parametrize("air", ["clear", "fog"])
@pytest.mark.parametrize("name", MAKERS)
def test_light_below_0_is_taken_away_as_in_cycles(name: str, air: str) -> None:
    """Beside a sun. Seen to fail where what varies is black below 0, and where what glows below 0 lights nothing."""
    if name == "a world that varies" and bpy.app.version < (4, 0, 0):
        pytest.skip("3.x draws a world's directions by brightness with its sign, and so finds no light, or too much")
    scene = empty_scene(48)
    scene.camera.data.ortho_scale, scene.camera.location.z = 5.0, 8.0
    plane(-1.0, half_side=4.0)
    cube()
    light("SUN", (0.0, 0.0, 3.0), energy=2.0)
    if air == "fog":
        fog = material("Fog", None, lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.1).outputs[0])
        cube("Fog", fog).scale = (3.0, 3.0, 2.0)
    without = tyndall_pixels(scene, 32)
    MAKERS[name]()
    ours, cycles = tyndall_pixels(scene, 32), cycles_pixels(scene, 256, seed=1)
    assert np.abs(without - ours).mean() > 0.01 * ours.mean()
    assert np.abs(ours.mean(axis=(0, 1)) / cycles.mean(axis=(0, 1)) - 1.0).max() < 0.01
    blocks = [
        picture.reshape(48 // BLOCK_PX, BLOCK_PX, 48 // BLOCK_PX, BLOCK_PX, 3).mean(axis=(1, 3))
        for picture in (ours, cycles)
    ]
    assert np.median(np.abs(blocks[0] - blocks[1])) < 0.01 * cycles.mean()
