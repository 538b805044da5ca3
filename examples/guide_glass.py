# SPDX-License-Identifier: GPL-3.0-or-later
"""The still life of the guide to indirect light: a glass of water, a ball, a block of amber, before a tiled wall."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np
from guide_voxels import shader
from mathutils import Vector

if TYPE_CHECKING:
    from collections.abc import Sequence

_TURNS = 96  #: Faces around what is turned on a lathe.
_CLEAR = {"Base_Color": (1, 1, 1, 1), "Roughness": 0.0}
_IS_3 = bpy.app.version < (4, 0, 0)


def _transmitting(name: str, ior: float) -> bpy.types.Material:
    inputs = {**_CLEAR, "Transmission" if _IS_3 else "Transmission_Weight": 1.0, "IOR": ior}
    return shader(name, "ShaderNodeBsdfPrincipled", **inputs)


def _tiles() -> bpy.types.Material:
    material = shader("Tiles", "ShaderNodeBsdfDiffuse")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    bricks, place = nodes.new("ShaderNodeTexBrick"), nodes.new("ShaderNodeTexCoord")
    bricks.offset = 0.0
    values = {
        "Color1": (0.06, 0.3, 0.36, 1),
        "Color2": (0.75, 0.72, 0.62, 1),
        "Mortar": (0.8, 0.8, 0.78, 1),
        "Scale": 1.0,
        "Mortar Size": 0.012,
        "Brick Width": 0.24,
        "Row Height": 0.24,
    }
    for name, value in values.items():
        bricks.inputs[name].default_value = value
    diffuse = next(node for node in nodes if node.type == "BSDF_DIFFUSE")
    links.new(place.outputs["Object"], bricks.inputs["Vector"])
    links.new(bricks.outputs["Color"], diffuse.inputs["Color"])
    return material


def _add(name: str, data: bpy.types.ID, location: Sequence[float] = (0, 0, 0)) -> bpy.types.Object:
    thing = bpy.data.objects.new(name, data)
    thing.location = location
    bpy.context.scene.collection.objects.link(thing)
    return thing


def _mesh(
    name: str, corners: Sequence[Sequence[float]], faces: Sequence[Sequence[int]], made_of: bpy.types.Material
) -> bpy.types.Mesh:
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    data.materials.append(made_of)
    return data


def _turned(name: str, profile: Sequence[Sequence[tuple[float, float]]], made_of: bpy.types.Material) -> bpy.types.Mesh:
    """Turn pieces of a profile, radii and heights, each smooth by itself; outside is to the right of the way."""
    corners: list[tuple[float, float, float]] = []
    faces: list[tuple[int, ...]] = []
    for piece in profile:
        first = len(corners)
        around = np.linspace(0.0, 2.0 * math.pi, _TURNS, endpoint=False)
        corners += [(radius * math.cos(turn), radius * math.sin(turn), z) for radius, z in piece for turn in around]
        for ring in range(len(piece) - 1):
            for turn in range(_TURNS):
                below, above = first + ring * _TURNS, first + (ring + 1) * _TURNS
                following = (turn + 1) % _TURNS
                faces.append((below + turn, below + following, above + following, above + turn))
    data = _mesh(name, corners, faces, made_of)
    data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
    return data


def _arc(radius: float, count: int = 48) -> list[tuple[float, float]]:
    return [(radius * math.sin(t), -radius * math.cos(t)) for t in np.linspace(1e-3, math.pi - 1e-3, count)]


def _tumbler(at: tuple[float, float]) -> None:
    """A glass, and water that reaches a little into it, so that no air is between."""
    base, top, height, wall, floor = 0.29, 0.36, 0.95, 0.03, 0.07

    def outer(z: float) -> float:
        return base + (top - base) * z / height

    lip = [
        (outer(height) - wall / 2 + wall / 2 * math.cos(t), height + wall / 2 * math.sin(t))
        for t in np.linspace(0.0, math.pi, 12)
    ]
    glass = [
        [(1e-4, 0.0), (base - 0.02, 0.0)],
        [(base - 0.02, 0.0), (base, 0.02), *((outer(z), z) for z in np.linspace(0.05, height, 12)), *lip[1:],
         *((outer(z) - wall, z) for z in np.linspace(height, floor + 0.03, 12)[1:]),
         (outer(floor) - wall - 0.02, floor)],
        [(outer(floor) - wall - 0.02, floor), (1e-4, floor)],
    ]  # fmt: skip
    level, into = 0.62, wall / 3
    water = [
        [(1e-4, floor - into), (outer(floor) - wall - 0.02 + into, floor - into)],
        [(outer(floor) - wall - 0.02 + into, floor - into)]
        + [(outer(z) - wall + into, z) for z in np.linspace(floor + 0.03, level, 12)],
        [(outer(level) - wall + into, level), (1e-4, level)],
    ]
    _add("Tumbler", _turned("Tumbler", glass, _transmitting("Glass", 1.45)), (*at, 0.001))
    _add("Water", _turned("Water", water, _transmitting("Water", 1.33)), (*at, 0.001))
    for name, colour, foot, head in (
        ("Red Straw", (0.7, 0.03, 0.02, 1), (-0.17, 0.05, 0.12), (0.42, -0.03, 1.3)),
        ("White Straw", (0.8, 0.8, 0.8, 1), (0.1, -0.12, 0.12), (-0.36, 0.12, 1.22)),
    ):
        way = Vector(head) - Vector(foot)
        straw = [
            [(1e-4, 0.0), (0.028, 0.0)],
            [(0.028, 0.0), (0.028, way.length)],
            [(0.028, way.length), (1e-4, way.length)],
        ]
        thing = _add(name, _turned(name, straw, shader(name, "ShaderNodeBsdfDiffuse", Color=colour)))
        thing.location = Vector((*at, 0.0)) + Vector(foot)
        thing.rotation_euler = way.to_track_quat("Z", "Y").to_euler()


def _amber(at: tuple[float, float]) -> None:
    material = shader("Amber", "ShaderNodeBsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.5)
    tree = material.node_tree
    inside = tree.nodes.new("ShaderNodeVolumeAbsorption")
    inside.inputs["Color"].default_value, inside.inputs["Density"].default_value = (1.0, 0.62, 0.12, 1), 2.6
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(inside.outputs[0], output.inputs["Volume"])
    side = 0.25
    corners = [(x, y, z) for z in (0.0, 2 * side) for y in (-side, side) for x in (-side, side)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    _add("Amber", _mesh("Amber", corners, faces, material), (*at, 0.001)).rotation_euler = (0, 0, 0.5)


def _room() -> None:
    """A table, the wall behind it, and a window that lights them: four panes that glow."""
    table = [(-4, -6, 0), (4, -6, 0), (4, 1.5, 0), (-4, 1.5, 0)]
    _add(
        "Table",
        _mesh("Table", table, [(0, 1, 2, 3)], shader("Wood", "ShaderNodeBsdfDiffuse", Color=(0.5, 0.33, 0.2, 1))),
    )
    wall = _add("Wall", _mesh("Wall", [(-4, 0, 0), (4, 0, 0), (4, 4, 0), (-4, 4, 0)], [(0, 1, 2, 3)], _tiles()))
    wall.location, wall.rotation_euler = (0, 1.4, 0), (math.pi / 2, 0, 0)
    panes = shader("Window", "ShaderNodeEmission", Color=(0.85, 0.93, 1.0, 1), Strength=14.0)
    corners: list[tuple[float, float, float]] = []
    for y in (-1.9, -0.85):
        for z in (0.9, 1.95):
            corners += [(-3.2, y, z), (-3.2, y + 0.95, z), (-3.2, y + 0.95, z + 0.95), (-3.2, y, z + 0.95)]
    _add("Window", _mesh("Window", corners, [tuple(range(i, i + 4)) for i in range(0, 16, 4)], panes))


def show_still_life(*, bends: bool) -> None:
    """Build the scene anew; what is seen through its glass is bent, or straight behind it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    _room()
    _tumbler((-0.62, 0.05))
    _amber((0.98, 0.1))
    ball = shader("Crystal", "ShaderNodeBsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.5)
    _add("Ball", _turned("Ball", [_arc(0.33)], ball), (0.3, -0.45, 0.331))
    fruit = shader("Orange", "ShaderNodeBsdfDiffuse", Color=(0.85, 0.28, 0.03, 1))
    _add("Orange", _turned("Orange", [_arc(0.2)], fruit), (0.22, 0.75, 0.2))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.color, sun.angle = 1.6, (1.0, 0.85, 0.65), 0.02
    _add("Sun", sun).rotation_euler = (math.radians(38), math.radians(-28), 0)
    scene.world = bpy.data.worlds.new("Room")
    if not scene.world.use_nodes:
        scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (0.5, 0.6, 0.8, 1), 0.35
    lens = bpy.data.cameras.new("Camera")
    lens.lens = 58
    scene.camera = _add("Camera", lens, (0.2, -4.6, 1.5))
    towards = Vector((0.12, 0.0, 0.5)) - scene.camera.location
    scene.camera.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 48, 0.015
    scene.view_settings.view_transform = "Filmic" if _IS_3 else "AgX"
    indirect = scene.tyndall.indirect
    indirect.has_bounce = indirect.has_mirrors = True
    indirect.mirror_depth, indirect.has_refraction = 4, bends
