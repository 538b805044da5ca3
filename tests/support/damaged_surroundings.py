# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that ask for what is around a point, and for its triangle: Ambient Occlusion, Bevel, Wireframe."""

from __future__ import annotations

from math import inf, nan

import bpy

from support.agreement_shapes import diffuse
from support.damaged_nodes import ABSURD, NOT_NUMBERS, on_soup, surface_of
from support.damages import Random, Scene, damage

_REACHES = (*ABSURD, 1e-30, 1e10)


def not_a_normal(tree: bpy.types.NodeTree, random: Random) -> bpy.types.NodeSocket:
    """A vector that varies, of which mathematics makes something else than a direction."""
    coordinates, math = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeVectorMath")
    math.operation = str(random.choice(["DIVIDE", "NORMALIZE", "SCALE", "MODULO", "PROJECT"]))
    for socket in math.inputs[1:]:
        if socket.type == "VECTOR":
            socket.default_value = (0.0, 0.0, 0.0)
        else:
            socket.default_value = float(random.choice([0.0, 3e38, -3e38]))
    tree.links.new(coordinates.outputs[int(random.choice([0, 1, 3]))], math.inputs[0])
    return math.outputs[0]


def number_without_end(tree: bpy.types.NodeTree, random: Random) -> bpy.types.NodeSocket:
    """A number that varies, and overflows or has no value somewhere."""
    noise, math = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMath")
    math.operation = str(random.choice(["DIVIDE", "LOGARITHM", "POWER", "SQRT", "MULTIPLY"]))
    math.inputs[1].default_value = float(random.choice([0.0, -1e30, 3e38]))
    tree.links.new(noise.outputs[0], math.inputs[0])
    return math.outputs[0]


def _occlusion(tree: bpy.types.NodeTree, random: Random) -> bpy.types.Node:
    node = tree.nodes.new("ShaderNodeAmbientOcclusion")
    node.samples, node.inside, node.only_local = int(random.choice([1, 128])), *map(bool, random.integers(2, size=2))
    node.inputs["Distance"].default_value = float(random.choice(_REACHES))
    return node


def _bevel(tree: bpy.types.NodeTree, random: Random) -> bpy.types.Node:
    node = tree.nodes.new("ShaderNodeBevel")
    node.samples = int(random.choice([2, 128]))
    node.inputs["Radius"].default_value = float(random.choice(_REACHES))
    return node


def _instances(of: bpy.types.Object, random: Random) -> None:
    """Of no scale, of next to none, mirrored, and vast."""
    collection = bpy.data.collections.new(of.name)
    collection.objects.link(of)
    for scale in ((0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (-1.0, 1.0, 1.0), (-1e-20, -1e-20, -1e-20), (1e12, -1e12, 1e12)):
        made = bpy.data.objects.new(f"{of.name} scaled", None)
        made.instance_type, made.instance_collection = "COLLECTION", collection
        made.scale, made.location = scale, (0.0, float(random.choice([0.0, 0.5])), 0.0)
        bpy.context.scene.collection.objects.link(made)


@damage("ambient occlusion of absurd distances, samples and normals", None)
def _(_scene: Scene, random: Random) -> None:
    for index in range(3):
        material = diffuse((0.5, 0.5, 0.5))
        tree, shader, _output = surface_of(material)
        node = _occlusion(tree, random)
        if index != 0:
            tree.links.new(number_without_end(tree, random), node.inputs["Distance"])
        if index != 1:
            tree.links.new(not_a_normal(tree, random), node.inputs["Normal"])
        tree.links.new(node.outputs["Color"], shader.inputs["Color"])
        tree.links.new(node.outputs["AO"], shader.inputs["Roughness"])
        _instances(on_soup(material, random, f"Occlusion {index}"), random)


@damage("ambient occlusion of a distance and a colour that are not numbers", "Mad Occlusion")
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    node = _occlusion(tree, random)
    node.inputs["Distance"].default_value = float(random.choice(NOT_NUMBERS))
    node.inputs["Color"].default_value = [float(random.choice((nan, inf, 1.0))) for _ in range(4)]
    tree.links.new(node.outputs["Color"], shader.inputs["Color"])
    on_soup(material, random, "Mad Occlusion")


@damage("bevels of absurd radii, samples and normals", None)
def _(_scene: Scene, random: Random) -> None:
    for index in range(3):
        material = diffuse((0.5, 0.5, 0.5))
        tree, shader, _output = surface_of(material)
        node = _bevel(tree, random)
        if index != 0:
            tree.links.new(number_without_end(tree, random), node.inputs["Radius"])
        if index != 1:
            tree.links.new(not_a_normal(tree, random), node.inputs["Normal"])
        tree.links.new(node.outputs[0], shader.inputs["Normal"])
        _instances(on_soup(material, random, f"Bevel {index}"), random)


@damage("a bevel whose radius is not a number", "Mad Bevel")
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    node = _bevel(tree, random)
    node.inputs["Radius"].default_value = float(random.choice(NOT_NUMBERS))
    tree.links.new(node.outputs[0], shader.inputs["Normal"])
    on_soup(material, random, "Mad Bevel")


@damage("bevels, bumps and occlusions that read each other", None)
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, output = surface_of(material)
    first, second, occlusion = _bevel(tree, random), _bevel(tree, random), _occlusion(tree, random)
    first.inputs["Radius"].default_value = second.inputs["Radius"].default_value = 0.3
    bump = tree.nodes.new("ShaderNodeBump")
    bump.inputs["Distance"].default_value = float(random.choice([0.1, 1e30, -1e30]))
    for source, target in (
        (first.outputs[0], second.inputs["Normal"]), (second.outputs[0], occlusion.inputs["Normal"]),
        (occlusion.outputs["AO"], bump.inputs["Height"]), (second.outputs[0], bump.inputs["Normal"]),
        (bump.outputs[0], shader.inputs["Normal"]), (occlusion.outputs["AO"], shader.inputs["Color"]),
        (occlusion.outputs["AO"], output.inputs["Displacement"]),
    ):  # fmt: skip
        tree.links.new(source, target)
    _instances(on_soup(material, random, "Readers"), random)


@damage("wires of no, negative and vast size", None)
def _(_scene: Scene, random: Random) -> None:
    for index in range(4):
        material = diffuse((0.5, 0.5, 0.5))
        tree, shader, _output = surface_of(material)
        node = tree.nodes.new("ShaderNodeWireframe")
        node.use_pixel_size = bool(index % 2)
        node.inputs["Size"].default_value = float(random.choice(ABSURD))
        if index > 1:
            tree.links.new(number_without_end(tree, random), node.inputs["Size"])
        tree.links.new(node.outputs[0], shader.inputs["Color"])
        _instances(on_soup(material, random, f"Wires {index}"), random)


@damage("wires whose size is not a number", "Mad Wires")
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    node = tree.nodes.new("ShaderNodeWireframe")
    node.use_pixel_size = bool(random.integers(2))
    node.inputs["Size"].default_value = float(random.choice(NOT_NUMBERS))
    tree.links.new(node.outputs[0], shader.inputs["Color"])
    on_soup(material, random, "Mad Wires")
