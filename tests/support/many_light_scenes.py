# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes lit by meshes that glow, and by many lamps: a floor, a wall and a few boxes."""

from __future__ import annotations

from collections.abc import Callable
from math import radians

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from support.agreement_scenes import Arrangement, build
from support.agreement_shapes import _link, _mesh, _output, _plane, diffuse


def _glow(strength: float, *, picture: bool = False) -> bpy.types.Material:
    material = bpy.data.materials.new("Glow")
    tree, output = _output(material)
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (1.0, 0.7, 0.3, 1)
    emission.inputs["Strength"].default_value = strength
    if picture:
        checker = tree.nodes.new("ShaderNodeTexChecker")
        checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (
            (1, 0.2, 0.1, 1),
            (0, 0.1, 0.6, 1),
        )
        checker.inputs["Scale"].default_value = 4.0
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(coordinates.outputs["UV"], checker.inputs["Vector"])
        tree.links.new(checker.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def _boxes() -> None:
    for number, x in enumerate((-1.6, 0.2, 1.5)):
        mesh = _mesh("Box", lambda shape: bmesh.ops.create_cube(shape, size=0.8), diffuse((0.6, 0.5, 0.4)))
        turned = Matrix.Rotation(radians(20 * number), 4, "Z")
        _link("Box", mesh, Matrix.Translation((x, 0.3 * number, 0.4)) @ turned)


def _quad() -> None:
    _plane("Lamp", Matrix.Translation((-0.8, 0.5, 3.2)) @ Matrix.Rotation(0.4, 4, "Y"), _glow(12.0))


def _picture() -> None:
    _plane("Lamp", Matrix.Translation((-0.5, 0.5, 2.6)) @ Matrix.Scale(2.0, 4), _glow(6.0, picture=True), cells=3)


def _ball() -> None:
    mesh = _mesh(
        "Ball", lambda shape: bmesh.ops.create_uvsphere(shape, u_segments=16, v_segments=8, radius=0.4), _glow(15.0)
    )
    _link("Ball", mesh, Matrix.Translation((-0.6, -0.2, 2.0)))


def _lamps(count: int, radius_m: float = 0.05) -> None:
    random = np.random.default_rng(3)
    for number in range(count):
        kind = ("POINT", "SPOT", "AREA")[number % 3]
        data = bpy.data.lights.new(f"Lamp {number}", kind)
        data.energy = 600.0 / count * (0.2 + random.random())
        data.color = 0.3 + 0.7 * random.random(3)
        if kind == "AREA":
            data.size = 0.2
        else:
            data.shadow_soft_size = radius_m
        place = random.random(3) * (6.0, 3.5, 1.5) + (-3.0, -1.0, 1.2)
        turn = Matrix.Rotation(random.random() - 0.5, 4, "X") @ Matrix.Rotation(random.random() - 0.5, 4, "Y")
        _link(data.name, data, Matrix.Translation(place) @ turn)


def point_lamps(count: int) -> None:
    """Without a size, all over the room, near the floor and high up."""
    random = np.random.default_rng(5)
    for number in range(count):
        data = bpy.data.lights.new(f"Lamp {number}", "POINT")
        data.energy, data.shadow_soft_size = 600.0 / count * (0.2 + random.random()), 0.0
        data.color = 0.3 + 0.7 * random.random(3)
        place = random.random(3) * (6.0, 3.5, 2.0) + (-3.0, -1.0, 0.9)
        _link(data.name, data, Matrix.Translation(place))


def spots_and_points(count: int) -> None:
    """Spots that face straight down, as Blender adds them, and every fifth lamp a weak point."""
    random = np.random.default_rng(6)
    for number in range(count):
        data = bpy.data.lights.new(f"Lamp {number}", "POINT" if number % 5 == 0 else "SPOT")
        data.energy = (1000.0 if data.type == "SPOT" else 30.0) / count
        data.shadow_soft_size = 0.0
        place = random.random(3) * (6.0, 3.5, 1.5) + (-3.0, -1.0, 1.2)
        _link(data.name, data, Matrix.Translation(place))


def plates_over_gloss(count: int, roughness: float) -> None:
    """Squares, discs and balls that hang all over the room, mirrored by a floor of metal of that roughness."""
    random = np.random.default_rng(7)
    size_m = 0.4 * (21.0 / count) ** 0.5  # of the ceiling, about a sixth
    for number in range(count):
        data = bpy.data.lights.new(f"Lamp {number}", "POINT" if number % 3 == 2 else "AREA")
        data.energy = 600.0 / count * (0.2 + random.random())
        data.color = 0.3 + 0.7 * random.random(3)
        if data.type == "AREA":
            data.shape, data.size = ("SQUARE", "DISK")[number % 3], size_m
        else:
            data.shadow_soft_size = 0.4 * size_m
        place = random.random(3) * (6.0, 3.5, 1.0) + (-3.0, -1.0, 1.8)
        turn = Matrix.Rotation(random.random() - 0.5, 4, "X") @ Matrix.Rotation(random.random() - 0.5, 4, "Y")
        _link(data.name, data, Matrix.Translation(place) @ turn).visible_camera = False
    material = bpy.data.materials.new("Metal")
    tree, output = _output(material)
    metal = tree.nodes.new(
        "ShaderNodeBsdfGlossy" if bpy.app.version < (4, 0, 0) else "ShaderNodeBsdfAnisotropic"
    )  # one node under two names
    metal.distribution = "GGX"
    metal.inputs["Color"].default_value = (0.9, 0.8, 0.7, 1)
    metal.inputs["Roughness"].default_value = roughness
    tree.links.new(metal.outputs[0], output.inputs["Surface"])
    bpy.data.objects["Floor"].data.materials[0] = material
    camera = bpy.context.scene.camera
    place = Vector((0.0, -2.6, 3.5))
    turn = (place - Vector((0.0, -0.4, 0.0))).to_track_quat("Z", "Y")
    camera.matrix_world = Matrix.LocRotScale(place, turn, None)
    camera.data.lens = 24.0


LIT_BY: dict[str, Callable[[], None]] = {
    "quad": _quad,
    "picture": _picture,
    "ball": _ball,
    "200 lamps": lambda: _lamps(200),
    "40 spots and points": lambda: spots_and_points(40),
    "10 points": lambda: point_lamps(10),
    "10000 points": lambda: point_lamps(10_000),
    "40 over gloss": lambda: plates_over_gloss(40, 0.15),
}


def build_lit_by(light: str | Callable[[], None], width_px: int = 96, height_px: int = 54) -> bpy.types.Scene:
    """Make the scene in an empty file, with one of LIT_BY or what makes another light."""
    scene = build(Arrangement("sun", "none", "perspective", "none"), width_px, height_px)
    for lamp in [each for each in scene.objects if each.type == "LIGHT"]:
        bpy.data.objects.remove(lamp)
    _boxes()
    (LIT_BY[light] if isinstance(light, str) else light)()
    return scene
