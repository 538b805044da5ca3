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
    from collections.abc import Sequence

    from bpy.types import Context, Mesh, Object

_CORNERS = tuple(product((0, 1), repeat=3))
_EDGES = tuple(
    (one, other)
    for one, other in combinations(range(8), 2)
    if sum(a != b for a, b in zip(_CORNERS[one], _CORNERS[other], strict=True)) == 1
)

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


def add_white_material(box: Object) -> None:
    """Leave voxels the colours that they carry, by which renders multiply the material's."""
    material = bpy.data.materials.new(f"{box.name} Colours")
    tree = use_nodes(material)
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.location = (-300, 0)
    diffuse.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    box.data.materials.append(material)


def fit_box(mesh: Mesh, bounds_m: Bounds) -> None:
    """Make its edges those of a cube."""
    mesh.clear_geometry()
    corners = [tuple(bounds_m[at][axis] for axis, at in enumerate(corner)) for corner in _CORNERS]
    mesh.from_pydata(corners, list(_EDGES), [])
    mesh.update()
