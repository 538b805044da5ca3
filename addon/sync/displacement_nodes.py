# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material displaces its surface by: a bump, or a mesh that moves, or both, as Cycles makes them.

Based on: blender/cycles v4.5.0, src/kernel/svm/displace.h; and src/scene/shader_graph.cpp, which makes the bump.
Differs:  where it does both, Cycles bumps in the object's space: under a scale that is not 1 it bends normals by
          another amount than this one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import Displacement
from tyndall.surface_inputs import PointInput

from .coordinates import made, made_fourth, point_input
from .domains import on_surfaces
from .math_nodes import vector_operation
from .mesh_attributes import tangent_of
from .normal_nodes import bumped, is_flat, read_at_three_places
from .program import BLACK, Value

if TYPE_CHECKING:
    from .domains import Evaluate
    from .node_graph import Socket
    from .program import Program
    from .value_nodes import ValueReader

_FILTER_WIDTH = 0.1 if bpy.app.version >= (4, 4, 0) else 1.0  #: Of Cycles' bumps that are no nodes, in pixels.


def displaced_normal(reader: ValueReader, material: bpy.types.Material, at: Socket | None) -> Value | None:
    """``at`` is the Displacement input of an output node. None: the surface keeps its normals."""
    if at is None or not at.is_connected():
        return None
    method = _method(material)
    if method == "DISPLACEMENT":
        return None
    reader.program.is_undisplaced = method == "BOTH"
    heights = read_at_three_places(reader, _FILTER_WIDTH, lambda: _height(reader, at))
    reader.program.is_undisplaced = False
    return None if is_flat(heights) else bumped(reader.program, heights, width=_FILTER_WIDTH)


def read_displacement(reader: ValueReader, material: bpy.types.Material, at: Socket | None) -> Displacement | None:
    """What moves the material's meshes; None: nothing does."""
    method = _method(material)
    if method == "BUMP" or at is None or not at.is_connected():
        return None
    program = reader.program.material(material.name, (BLACK, BLACK, reader.colour(at)))
    return Displacement(program=program, keeps_normals=method == "BOTH")


def _method(material: bpy.types.Material) -> str:
    method = getattr(material, "displacement_method", None)  # from 4.1 on; before, where Cycles is on
    return str(method or getattr(getattr(material, "cycles", None), "displacement_method", "BUMP"))


def _moved_by(reader: ValueReader, source: Socket) -> Value:
    """Where to and how far, in the world: what other nodes get, as those that mix displacements."""
    program = reader.program
    if source.node.type == "DISPLACEMENT":
        normal_input = source.input("Normal")
        is_linked = normal_input is not None and normal_input.is_connected()
        normal = reader.colour(normal_input) if is_linked else point_input(program, PointInput.NORMAL)
        if source.node.space == "OBJECT":
            normal = point_input(program, PointInput.NORMAL_TO_OBJECT, normal)
            normal = point_input(program, PointInput.DIRECTION_TO_WORLD, normal)
        return program.multiply(normal, _height_of_displacement(reader, source))
    moved = _vector_of_displacement(reader, source)
    if source.node.space == "TANGENT":
        moved = _along_tangents(program, moved)
    return moved if source.node.space == "WORLD" else point_input(program, PointInput.DIRECTION_TO_WORLD, moved)


def _along_tangents(program: Program, moved: Value) -> Value:
    """In the object: x along the tangent of the active UV map, y along the normal, z across both."""
    asked = tangent_of("")
    tangent = made(program, asked)
    normal = point_input(program, PointInput.NORMAL_TO_OBJECT, point_input(program, PointInput.NORMAL))
    across = vector_operation(program, "NORMALIZE", vector_operation(program, "CROSS_PRODUCT", normal, tangent))
    across = program.multiply(across, made_fourth(program, asked))
    along = (program.multiply(axis, program.channel(moved, i)) for i, axis in enumerate((tangent, normal, across)))
    x, y, z = along
    return program.add(program.add(x, y), z)


def _height(reader: ValueReader, at: Socket) -> Value:
    """How far along the surface's normal."""
    source = at.source()
    if source.node.type == "DISPLACEMENT":
        return _of_displacement(reader, source)
    if source.node.type == "VECTOR_DISPLACEMENT":
        return _of_vector_displacement(reader, source)
    return _along(reader.program, reader.colour(at))


def _along(program: Program, moved: Value) -> Value:
    return vector_operation(program, "DOT_PRODUCT", moved, point_input(program, PointInput.NORMAL))


def _along_in_object(program: Program, normal: Value) -> Value:
    """How far along the surface's normal one unit along another goes in the object's space."""
    normal = point_input(program, PointInput.NORMAL_TO_OBJECT, normal)
    return _along(program, point_input(program, PointInput.DIRECTION_TO_WORLD, normal))


def _height_of_displacement(reader: ValueReader, at: Socket) -> Value:
    height = reader.program.subtract(reader.number(at.input("Height")), reader.number(at.input("Midlevel"), 0.5))
    return reader.program.multiply(height, reader.number(at.input("Scale"), 1.0))


def _vector_of_displacement(reader: ValueReader, at: Socket) -> Value:
    moved = reader.program.subtract(reader.colour(at.input("Vector")), reader.number(at.input("Midlevel")))
    return reader.program.multiply(moved, reader.number(at.input("Scale"), 1.0))


def _of_displacement(reader: ValueReader, at: Socket) -> Value:
    program, normal_input = reader.program, at.input("Normal")
    height = _height_of_displacement(reader, at)
    is_linked = normal_input is not None and normal_input.is_connected()
    normal = reader.colour(normal_input) if is_linked else point_input(program, PointInput.NORMAL)
    if at.node.space == "OBJECT":
        return program.multiply(height, _along_in_object(program, normal))
    return program.multiply(height, _along(program, normal)) if is_linked else height


def _of_vector_displacement(reader: ValueReader, at: Socket) -> Value:
    program, space = reader.program, at.node.space
    moved = _vector_of_displacement(reader, at)
    if space == "TANGENT":  # of the object; x goes along the tangent, y along the normal
        along = _along_in_object(program, point_input(program, PointInput.NORMAL))
        return program.multiply(program.channel(moved, 1), along)
    if space == "OBJECT":
        moved = point_input(program, PointInput.DIRECTION_TO_WORLD, moved)
    return _along(program, moved)


NODES: dict[str, Evaluate] = {
    "DISPLACEMENT": on_surfaces(_moved_by),
    "VECTOR_DISPLACEMENT": on_surfaces(_moved_by),
}
