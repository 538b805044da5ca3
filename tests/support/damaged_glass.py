# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass that bends what is seen through it, of absurd indices, colours, normals and shapes."""

from __future__ import annotations

from math import nan

import bpy
import numpy as np

from support.agreement_shapes import diffuse
from support.damaged_nodes import ABSURD, NOT_NUMBERS, node_of, on_soup, spoil, surface_of
from support.damaged_surroundings import not_a_normal, number_without_end
from support.damages import Random, Scene, damage, mesh_object

_BENDING = ("ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction", "ShaderNodeBsdfPrincipled")
_INDICES = (0.0, -1.0, 1.0, 1e30, 1e-30, -1e30, 1.0 + 1e-7, 1.45)
_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
_BESIDE = (1.6, 0.4, 1.4)


def bend(scene: Scene, depth: int = 64) -> None:
    """Mirrors and refraction, as deep as they go."""
    indirect = scene.tyndall.indirect
    indirect.has_mirrors = indirect.has_refraction = True
    indirect.mirror_depth = indirect.refraction_depth = depth
    indirect.mirror_roughness = 1.0


def glass(random: Random, kinds: tuple[str, ...] = _BENDING) -> tuple[bpy.types.Material, bpy.types.Node]:
    """A polished shader that transmits, and its material."""
    material = diffuse((0.5, 0.5, 0.5))
    tree, _shader, output = surface_of(material)
    shader = node_of(tree, kinds, random)
    shader.inputs["Roughness"].default_value = 0.0
    for name in ("Transmission", "Transmission Weight"):
        if name in shader.inputs:
            shader.inputs[name].default_value = 1.0
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material, shader


def closed(name: str, material: bpy.types.Material, side: float = 0.8) -> bpy.types.Object:
    """A block of it, beside the sound cube."""
    corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    made = mesh_object(name, np.array(corners, np.float32) * np.float32(side), _FACES)
    made.location = _BESIDE
    made.data.materials.append(material)
    material.name = name
    return made


@damage("glass that bends, of absurd indices", None)
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    for index, kind in enumerate(_BENDING):
        material, shader = glass(random, (kind,))
        tree = material.node_tree
        if index == 0:
            tree.links.new(number_without_end(tree, random), shader.inputs["IOR"])
        else:
            value = tree.nodes.new("ShaderNodeValue")
            value.outputs[0].default_value = float(random.choice(_INDICES))
            tree.links.new(value.outputs[0], shader.inputs["IOR"])
        closed(f"Index {index}", material, 0.5 + 0.3 * index)


@damage("glass that bends, of indices that are not numbers", "Mad Index")
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    material, shader = glass(random)
    shader.inputs["IOR"].default_value = float(random.choice(NOT_NUMBERS))
    closed("Mad Index", material)


@damage("glass that gives more light than it gets", None)
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    material, shader = glass(random, _BENDING[:1] if random.integers(2) else _BENDING)
    name = "Base Color" if "Base Color" in shader.inputs else "Color"
    shader.inputs[name].default_value = [float(random.choice([2.0, 1e10, 1e30]))] * 3 + [1.0]
    shader.inputs["IOR"].default_value = float(random.choice([1.5, 3.0]))
    closed("Gain", material)


@damage("glass within glass within itself, all at one place", None)
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    for index in range(6):
        material, shader = glass(random)
        shader.inputs["IOR"].default_value = float(random.choice([1.1, 1.45, 0.7]))
        closed(f"Nested {index}", material, 0.8 if index < 4 else 0.8 - 0.1 * index)


@damage("glass of open, flat, torn and inverted meshes", None)
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    material, shader = glass(random)
    shader.inputs["IOR"].default_value = float(random.choice([1.45, 0.5]))
    on_soup(material, random, "Torn Glass")
    flat = closed("Flat Glass", material)
    flat.scale = (1.0, float(random.choice([0.0, 1e-30, -1.0])), 1.0)
    half = closed("Open Glass", material)
    half.data.clear_geometry()
    half.data.from_pydata([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0.5, 0, 0.5), (0.5, 0, 0.5)], [], [(0, 1, 2), (0, 2, 3)])


@damage("glass of normals that are none, with fog in it", None)
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    for index in range(2):
        material, shader = glass(random)
        tree = material.node_tree
        normal = tree.nodes.new("ShaderNodeNormalMap")
        spoil(normal, random, (*ABSURD, *NOT_NUMBERS), 1.0)
        if index:
            tree.links.new(not_a_normal(tree, random), normal.inputs["Color"])
        tree.links.new(normal.outputs[0], shader.inputs["Normal"])
        fog, output = tree.nodes.new("ShaderNodeVolumeScatter"), surface_of_output(tree)
        fog.inputs["Density"].default_value = float(random.choice([0.1, 1e6, 0.0]))
        tree.links.new(fog.outputs[0], output.inputs["Volume"])
        closed(f"Foggy Glass {index}", material, 0.8 - 0.2 * index)


def surface_of_output(tree: bpy.types.NodeTree) -> bpy.types.Node:
    """The output of a material."""
    return next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")


@damage("a camera in glass, mirrors around it", None, "camera")
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    material, shader = glass(random)
    shader.inputs["IOR"].default_value = float(random.choice([1.45, 0.0, 1e30]))
    closed("Around", material, float(random.choice([0.5, 0.0, 1e6]))).location = scene.camera.location
    mirror = diffuse((1.0, 1.0, 1.0))
    tree, _shader, output = surface_of(mirror)
    glossy = tree.nodes.new("ShaderNodeBsdfGlossy" if hasattr(bpy.types, "ShaderNodeBsdfGlossy") else _GLOSSY_NOW)
    glossy.inputs["Roughness"].default_value = 0.0
    glossy.inputs["Color"].default_value = [float(random.choice([1.0, 4.0, 1e30]))] * 3 + [1.0]
    tree.links.new(glossy.outputs[0], output.inputs["Surface"])
    closed("Mirrors", mirror, 20.0).location = scene.camera.location


_GLOSSY_NOW = "ShaderNodeBsdfAnisotropic"


@damage("glass whose parameters are all absurd", None)
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    for index in range(3):
        material, shader = glass(random)
        spoil(shader, random, ABSURD, 0.5)
        closed(f"Absurd Glass {index}", material, 0.4 + 0.3 * index)


@damage("glass of colours that are not numbers", "Mad Glass")
def _(scene: Scene, random: Random) -> None:
    bend(scene)
    material, shader = glass(random)
    next(it for it in shader.inputs if it.type == "RGBA").default_value = (1.0, nan, 1.0, 1.0)
    closed("Mad Glass", material)
