# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of damages that tests/support/damaged_scenes.py draws from, and what several of them are made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from support.agreement_shapes import diffuse

Random = np.random.Generator
Scene = bpy.types.Scene


@dataclass(frozen=True)
class Damage:
    """One thing that is wrong."""

    name: str
    apply: Callable[[Scene, Random], None]
    culprits: tuple[str, ...] = ()  #: Names that reports, or the error, must contain; none: nothing to report.
    of: str = "object"  #: What it is about: two damages of the same kind never meet, except objects and meshes.


DAMAGES: list[Damage] = []


def damage(
    name: str, culprits: str | tuple[str, ...] | None = None, of: str = "object"
) -> Callable[..., Callable[..., None]]:
    """Enter a function into the list."""

    def enter(
        function: Callable[[Scene, Random], None],
    ) -> Callable[[Scene, Random], None]:
        names = (culprits,) if isinstance(culprits, str) else culprits or ()
        DAMAGES.append(Damage(name, function, names, of))
        return function

    return enter


def mesh_object(name: str, points: np.ndarray, faces: list[tuple[int, ...]]) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0.0, 0.0, 0.0)] * len(points), [], faces)
    mesh.vertices.foreach_set("co", np.asarray(points, np.float32).ravel())  # from_pydata would refuse some of them
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def soup(random: Random, triangles: int = 40) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    points = random.normal(size=(triangles * 3, 3)).astype(np.float32) * 0.4 + (
        1.4,
        1.5,
        2.2,
    )
    return points.astype(np.float32), [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(triangles)]


def spoiled_soup(name: str, random: Random, value: float) -> bpy.types.Object:
    points, faces = soup(random)
    points[random.random(points.shape) < random.choice([0.002, 0.1, 1.0])] = value
    points[0, 0] = value
    return mesh_object(name, points, faces)


def textured(image: bpy.types.Image | None) -> bpy.types.Material:
    material = diffuse((0.5, 0.5, 0.5))
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    surface = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    material.node_tree.links.new(texture.outputs[0], surface.inputs[0])
    return material


def light_object(name: str, kind: str, location: tuple[float, float, float] = (1.5, 0.0, 3.0)) -> bpy.types.Object:
    made = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
    made.location = location
    bpy.context.scene.collection.objects.link(made)
    return made
