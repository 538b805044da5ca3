# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes full of fog that nodes vary: time and noise of default settings, ours and Cycles'.

scripts/python benchmarks/varying_media_bench.py --context FILE --output FILE. Both engines take the samples that ours
has by default; noise_and_time.py says what is measured.
"""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path

import bpy
from noise_and_time import both_engines

from report import Row, run_scenes

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.small_scenes import Build, cube, empty_scene, light, material, node, plane

SIZE_PX = 240, 160
SAMPLES = 16


def _times(new: object, link: object, socket: bpy.types.NodeSocket, factor: float) -> bpy.types.NodeSocket:
    product = node(new, "ShaderNodeMath")
    product.operation, product.inputs[1].default_value = "MULTIPLY", factor
    link(socket, product.inputs[0])
    return product.outputs[0]


def _fog(density: float, texture: str, *, colours: bool, glow: float = 0.0) -> Build:
    """Its density, its colours and what it emits go with one texture of the object."""

    def build(new: object, link: object) -> bpy.types.NodeSocket:
        pattern = node(new, texture, Scale=2.0)
        link(node(new, "ShaderNodeTexCoord").outputs["Object"], pattern.inputs["Vector"])
        number = pattern.outputs.get("Fac") or pattern.outputs["Distance"]
        shader = node(new, "ShaderNodeVolumePrincipled", Anisotropy=0.2)
        link(_times(new, link, number, density), shader.inputs["Density"])
        if colours:
            link(pattern.outputs["Color"], shader.inputs["Color"])
        if glow:
            link(_times(new, link, number, glow), shader.inputs["Emission Strength"])
        return shader.outputs[0]

    return build


_NOISE, _CELLS, _WAVES = "ShaderNodeTexNoise", "ShaderNodeTexVoronoi", "ShaderNodeTexWave"
SCENES: dict[str, tuple[Build, ...]] = {
    "a density": (_fog(2.0, _NOISE, colours=False),),
    "a density and colours": (_fog(2.0, _NOISE, colours=True),),
    "cells of colours within waves": (_fog(2.0, _CELLS, colours=True), _fog(0.7, _WAVES, colours=True)),
    "noise that glows": (_fog(1.5, _NOISE, colours=True, glow=0.3),),
}


def build(fogs: tuple[Build, ...]) -> bpy.types.Scene:
    """A ball, and a box around it if there are two, over a floor, by a sun with a size and a lamp."""
    scene = empty_scene(SIZE_PX[0])
    scene.render.resolution_x, scene.render.resolution_y = SIZE_PX
    scene.camera.data.type = "PERSP"
    scene.camera.location, scene.camera.rotation_euler = (0.0, -9.0, 2.5), (1.4, 0.0, 0.0)
    plane(-1.0).scale = (15.0, 15.0, 1.0)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1.5, location=(0.0, 0.0, 1.0))
    bpy.context.object.data.materials.append(material("Ball", volume=fogs[0]))
    for fog in fogs[1:]:
        box = cube("Box", material("Box", volume=fog))
        box.location, box.scale = (0.3, 0.4, 1.1), (2.4, 2.0, 1.8)
    light("SUN", (0.0, 0.0, 5.0), energy=2.0, angle=math.radians(3.0)).rotation_euler = (0.6, 0.4, 0.0)
    light("POINT", (-3.0, -2.0, 3.5), energy=300.0, shadow_soft_size=0.2)
    return scene


def run(names: list[str]) -> list[Row]:
    """Measure both engines in all scenes."""
    return both_engines({name: partial(build, SCENES[name]) for name in names or SCENES}, SAMPLES)


if __name__ == "__main__":
    run_scenes(run, __doc__)
