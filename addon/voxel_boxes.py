# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that stand for the voxels of a file: the edges of the file's cube, which no engine but Tyndall draws.

A mesh, not an Empty: it has material slots, and a box that views frame and snapping finds. Without a face it is nothing
to other engines.
"""

from __future__ import annotations

from itertools import combinations, product
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from .shader_nodes import use_nodes

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from bpy.types import Context, Mesh, Node, NodeSocket, Object

    from .sync.voxel_colours import Glow

_CORNERS = tuple(product((0, 1), repeat=3))
_EDGES = tuple(
    (one, other)
    for one, other in combinations(range(8), 2)
    if sum(a != b for a, b in zip(_CORNERS[one], _CORNERS[other], strict=True)) == 1
)

#: What materials read of voxels by a Color Attribute and by an Attribute node.
COLOURS, EMISSION = "Color", "emission"

#: Of a Principled BSDF, by the channel that it takes.
_INPUT_OF_CHANNEL = {
    "roughness": "Roughness",
    "metallic": "Metallic",
    "reflectance": "Specular" if bpy.app.version < (4, 0, 0) else "Specular IOR Level",
}

#: Lower and upper corner.
Bounds = "Sequence[Sequence[float]]"


def is_voxel_box(thing: Object | None) -> bool:
    return thing is not None and bool(thing.tyndall_voxels.path)


def file_of(thing: Object) -> Path:
    """Of a voxel box."""
    return Path(bpy.path.abspath(thing.tyndall_voxels.path, library=thing.library))


def add_voxel_box(context: Context, name: str, path: str, bounds_m: Bounds, location: Sequence[float]) -> Object:
    """The file's cube lies in the object's own space."""
    mesh = bpy.data.meshes.new(name)
    fit_box(mesh, bounds_m)
    box = bpy.data.objects.new(name, mesh)
    box.location = location
    box.tyndall_voxels.path = path
    context.collection.objects.link(box)
    context.view_layer.update()  # a script may render at once: the box is where it is
    return box


def add_own_material(box: Object, channels: Collection[str], glow: Glow | None = None) -> None:
    """Show what voxels carry: colours, gloss, metal, and emission times ``glow``; None: times the surface's colours.

    Without channels of gloss they are diffuse; of those that are not there a Principled BSDF has its own.
    """
    material = bpy.data.materials.new(f"{box.name} Colours")
    tree = use_nodes(material)
    tree.nodes.clear()

    def new(kind: str, column: int, row: int) -> Node:
        node = tree.nodes.new(kind)
        node.location = (220 * column, -200 * row)
        return node

    def channel(name: str, column: int, row: int) -> NodeSocket:
        node = new("ShaderNodeAttribute", column, row)
        node.attribute_name = name
        return node.outputs["Fac"]

    colours = new("ShaderNodeVertexColor", 1, 0)
    colours.layer_name = COLOURS
    if kept := [name for name in _INPUT_OF_CHANNEL if name in channels]:
        shader = new("ShaderNodeBsdfPrincipled", 2, 0)
        for row, name in enumerate(kept, start=1):
            tree.links.new(channel(name, 1, row), shader.inputs[_INPUT_OF_CHANNEL[name]])
    else:
        shader = new("ShaderNodeBsdfDiffuse", 2, 0)
    if glow is None or glow.hue is not None:
        tree.links.new(colours.outputs["Color"], shader.inputs[0])
    else:
        is_dark, surface_colour = new("ShaderNodeMath", 0, 1), new("ShaderNodeVectorMath", 1, -1)
        is_dark.operation, is_dark.inputs[1].default_value = "LESS_THAN", 0.5 / 255.0
        surface_colour.operation = "SCALE"
        tree.links.new(channel(EMISSION, -1, 1), is_dark.inputs[0])
        tree.links.new(is_dark.outputs[0], surface_colour.inputs["Scale"])
        tree.links.new(colours.outputs["Color"], surface_colour.inputs[0])
        tree.links.new(surface_colour.outputs[0], shader.inputs[0])
    surface = shader.outputs[0]
    if EMISSION in channels and (glow is None or glow.strength > 0.0):
        row = len(kept) + 1
        brightness, emission, both = (
            new("ShaderNodeMath", 2, row),
            new("ShaderNodeEmission", 3, 1),
            new("ShaderNodeAddShader", 4, 0),
        )
        if glow is None or glow.hue is None:
            tree.links.new(colours.outputs["Color"], emission.inputs["Color"])
        else:
            emission.inputs["Color"].default_value = (*glow.hue, 1.0)
        brightness.label, brightness.operation = "Brightness", "MULTIPLY"
        brightness.inputs[1].default_value = 1.0 if glow is None else glow.strength
        tree.links.new(channel(EMISSION, 1, row), brightness.inputs[0])
        tree.links.new(brightness.outputs[0], emission.inputs["Strength"])
        tree.links.new(surface, both.inputs[0])
        tree.links.new(emission.outputs[0], both.inputs[1])
        surface = both.outputs[0]
    tree.links.new(surface, new("ShaderNodeOutputMaterial", 5, 0).inputs["Surface"])
    box.data.materials.append(material)


def fit_box(mesh: Mesh, bounds_m: Bounds) -> None:
    """Make its edges those of a cube."""
    mesh.clear_geometry()
    corners = [tuple(bounds_m[at][axis] for axis, at in enumerate(corner)) for corner in _CORNERS]
    mesh.from_pydata(corners, list(_EDGES), [])
    mesh.update()
