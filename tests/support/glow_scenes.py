# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog that nothing but meshes that glow lights: black surfaces, boxes that cast shadows, glow that no camera sees.

What such pictures show is scattered light alone, without edges that two engines would draw apart.
"""

from __future__ import annotations

from collections.abc import Callable
from math import radians

import bmesh
import bpy
import numpy as np
from mathutils import Color

from support.small_scenes import Build, Node, add, cube, empty_scene, material, node, plane

WIDTH_PX, HEIGHT_PX = 45, 27


def _glow(name: str, strength: float, colour: tuple[float, float, float]) -> bpy.types.Material:
    return material(
        name, surface=lambda new, _: node(new, "ShaderNodeEmission", Color=(*colour, 1.0), Strength=strength).outputs[0]
    )


def _scatter(density: float, anisotropy: float = 0.0, colour: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Build:
    return lambda new, _: node(
        new, "ShaderNodeVolumeScatter", Density=density, Anisotropy=anisotropy, Color=(*colour, 1.0)
    ).outputs[0]


def fog(volume: Build, half_size: tuple[float, float, float] = (4, 4, 2), z: float = 1.0) -> bpy.types.Object:
    """A box of it."""
    box = cube("Fog", material("Fog", volume=volume))
    box.scale, box.location = half_size, (0, 0, z)
    return box


def plate(colour: tuple[float, float, float] = (1.0, 0.7, 0.3), strength: float = 12.0) -> bpy.types.Object:
    """High up and slanted."""
    shown = plane(2.0, _glow("Plate", strength, colour), half_side=0.6)
    shown.name, shown.location, shown.rotation_euler = "Plate", (0.3, 0.5, 2.0), (0.3, 0.2, 0.0)
    shown.visible_camera = False
    return shown


def _ball() -> None:
    data = bpy.data.meshes.new("Ball")
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=16, v_segments=8, radius=0.3)
    shape.to_mesh(data)
    shape.free()
    data.materials.append(_glow("Ball", 20.0, (0.4, 0.7, 1.0)))
    add("Ball", data, (-0.5, 2.2, 1.6))  # camera rays that end within it would be all of Cycles' noise


def _sparks() -> None:
    """Many, all over the fog, of one mesh each."""
    random = np.random.default_rng(2)
    for number in range(20):
        colour = Color()
        colour.hsv = (random.random(), 0.5, 1.0)
        spark = plane(0.0, _glow(f"Spark {number}", 8.0 + 16.0 * random.random(), tuple(colour)), half_side=0.15)
        spark.location = random.random(3) * (5.0, 4.0, 2.0) + (-2.5, -1.5, 0.0)
        spark.rotation_euler = random.random(3) * 3.0
        spark.visible_camera = False


def _picture() -> None:
    """Its colours vary over it, and only one of its sides glows."""

    def chequered(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        checker = node(new, "ShaderNodeTexChecker", Scale=3.0)
        checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (1, 0.1, 0, 1), (0, 0.2, 1, 1)
        link(new("ShaderNodeTexCoord").outputs["UV"], checker.inputs["Vector"])
        emission, dark, mix = (
            node(new, "ShaderNodeEmission", Strength=25.0),
            new("ShaderNodeBsdfDiffuse"),
            new("ShaderNodeMixShader"),
        )
        dark.inputs["Color"].default_value = (0, 0, 0, 1)
        link(checker.outputs["Color"], emission.inputs["Color"])
        link(new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs[0])
        link(dark.outputs[0], mix.inputs[1])
        link(emission.outputs[0], mix.inputs[2])
        return mix.outputs[0]

    shown = plate()
    shown.data.materials[0] = material("Picture", surface=chequered)


def _world_fog(density: float, anisotropy: float) -> None:
    tree = bpy.context.scene.world.node_tree
    scatter = _scatter(density, anisotropy)(tree.nodes.new, tree.links.new)
    output = next(each for each in tree.nodes if each.type == "OUTPUT_WORLD")
    tree.links.new(scatter, output.inputs["Volume"])


def _varied(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
    """Becomes a density grid in ours."""
    scatter, gradient, times = new("ShaderNodeVolumeScatter"), new("ShaderNodeTexGradient"), new("ShaderNodeMath")
    scatter.inputs["Color"].default_value = (1, 1, 1, 1)
    scatter.inputs["Anisotropy"].default_value = 0.3
    times.operation, times.inputs[1].default_value = "MULTIPLY", 0.4
    link(new("ShaderNodeTexCoord").outputs["Generated"], gradient.inputs["Vector"])
    link(gradient.outputs["Fac"], times.inputs[0])
    link(times.outputs[0], scatter.inputs["Density"])
    return scatter.outputs[0]


def _overlapping() -> None:
    _picture()
    fog(_scatter(0.1, 0.2, (1.0, 0.6, 0.3)))
    fog(_scatter(0.2, 0.2, (0.3, 0.6, 1.0)), (1.5, 2.0, 1.0), 1.2)


def _in(lights: Callable[[], object], volume: Build) -> Callable[[], object]:
    return lambda: (lights(), fog(volume))


def _wall() -> None:
    """Wide, and behind the fog."""
    shown = plate(strength=1.5)
    shown.location, shown.rotation_euler, shown.scale = (-1.0, 4.3, 1.5), (radians(90), 0.0, 0.0), (3.0, 3.0, 1.0)


def _dome() -> None:
    data = bpy.data.meshes.new("Dome")
    shape = bmesh.new()
    bmesh.ops.create_icosphere(shape, subdivisions=2, radius=9.0)
    shape.to_mesh(data)
    shape.free()
    data.materials.append(_glow("Dome", 0.5, (0.5, 0.7, 1.0)))
    add("Dome", data)


SCENES: dict[str, Callable[[], object]] = {
    "plate": _in(plate, _scatter(0.1, 0.5)),
    "wall, fog that scatters onwards": _in(_wall, _scatter(0.1, 0.8)),
    "dome": _in(_dome, _scatter(0.1)),
    "plate, dense": _in(plate, _scatter(0.8, 0.0, (0.9, 0.5, 0.2))),
    "ball in the world's fog": lambda: (_ball(), _world_fog(0.1, -0.3)),
    "sparks": _in(_sparks, _scatter(0.1)),
    "picture, fog in fog": _overlapping,
    "plate, fog that varies": _in(plate, _varied),
}


def empty_stage() -> bpy.types.Scene:
    """Without light and fog."""
    scene = empty_scene()
    scene.render.resolution_x, scene.render.resolution_y = WIDTH_PX, HEIGHT_PX
    camera = scene.camera
    camera.data.type, camera.data.angle = "PERSP", radians(55)
    camera.location, camera.rotation_euler = (0, -6, 1.2), (radians(88), 0, 0)
    black = material("Black", surface=lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0, 0, 0, 1)).outputs[0])
    plane(-0.8, black)
    wall = plane(0.0, black)
    wall.location, wall.rotation_euler = (0, 4.5, 0), (radians(90), 0, 0)
    for x in (-1.2, 0.0, 1.2):
        post = cube("Post", black)
        post.scale, post.location = (0.15, 0.4, 0.5), (x, 0.3, 0.4)
    return scene


def build(name: str) -> bpy.types.Scene:
    """Make one of SCENES in an empty file."""
    scene = empty_stage()
    SCENES[name]()
    return scene
