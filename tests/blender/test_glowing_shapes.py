# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and points that glow light what is around them as in Cycles, whose rays meet them by chance, too."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

from support.hair_scenes import agree, both_engines, furry, made_by_nodes, stage
from support.small_scenes import Node, cube, material, mesh, node

pytestmark = pytest.mark.dealt


def _dark_to_cameras(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
    strength = node(new, "ShaderNodeMath")
    strength.operation, strength.inputs[0].default_value = "SUBTRACT", 1.0
    link(new("ShaderNodeLightPath").outputs["Is Camera Ray"], strength.inputs[1])
    times = node(new, "ShaderNodeMath")
    times.operation, times.inputs[1].default_value = "MULTIPLY", 9.0
    link(strength.outputs[0], times.inputs[0])
    glow = node(new, "ShaderNodeEmission", Color=(1.0, 0.6, 0.3, 1.0))
    link(times.outputs[0], glow.inputs["Strength"])
    return glow.outputs[0]


def _glowing(kind: str, ground: str) -> bpy.types.Scene:
    """Black to the camera, over a floor in the dark; or in fog alone."""
    scene = stage()
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    glow = material("Glow", _dark_to_cameras)
    if kind == "points":
        places = mesh("Places", [(-0.6, 0.0, 0.4), (0.6, 0.0, 0.4), (0.0, 0.5, 0.8)], [])
        shape = made_by_nodes(
            places,
            [("GeometryNodeMeshToPoints", {"Radius": 0.2}), ("GeometryNodeSetMaterial", {"Material": glow})],
        )
    else:
        shape = furry(scene, kind)
        shape.data.materials[1] = glow
    shape.name = "Glow"
    if ground == "fog":
        fog = material(
            "Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.15, Anisotropy=0.4).outputs[0]
        )
        box = cube("Fog", fog)
        box.scale, box.location = (2.0, 2.0, 1.2), (0.0, 0.0, 1.25)
        bpy.data.objects["Plane"].hide_render = True
    elif ground == "gloss":
        tree = bpy.data.materials["Floor"].node_tree
        kind_of_node = "ShaderNodeBsdfAnisotropic" if bpy.app.version >= (4, 0, 0) else "ShaderNodeBsdfGlossy"
        gloss = node(tree.nodes.new, kind_of_node, Roughness=0.3)
        output = next(each for each in tree.nodes if each.type == "OUTPUT_MATERIAL")
        tree.links.new(gloss.outputs[0], output.inputs["Surface"])
    return scene


# Seen to fail where they lit nothing, and where their own width blocked most of a ribbon's light.
@pytest.mark.parametrize("ground", ["diffuse", "gloss", "fog"])
@pytest.mark.parametrize("kind", ["RIBBONS", "THICK", "points"])
def test_what_glows_lights_surfaces_and_fog_as_in_cycles(kind: str, ground: str) -> None:
    ours, cycles = both_engines(_glowing(kind, ground), 400 if ground == "fog" else 256)
    assert cycles.mean() > 0.02
    bounds = {"mean_bound": 0.015, "median_bound": 0.03, "block_bound": 0.1}
    agree(f"glow_{kind.lower()}_{ground}", ours, cycles, block_px=18, **bounds)


@pytest.mark.parametrize("hidden", ["visible_diffuse", "visible_glossy", "visible_volume_scatter"])
def test_rays_that_do_not_see_it_bring_none_of_its_light(hidden: str) -> None:
    ground = {"visible_diffuse": "diffuse", "visible_glossy": "gloss", "visible_volume_scatter": "fog"}[hidden]
    scene = _glowing("points", ground)
    setattr(bpy.data.objects["Glow"], hidden, False)
    ours, cycles = both_engines(scene, 4)
    assert not np.any(ours)
    if hidden != "visible_volume_scatter" or bpy.app.version >= (4, 0, 0):  # 3.4 asks no such thing of points
        assert not np.any(cycles)
