# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material displaces its surface by, drawn as the bump that Cycles makes of it.

Based on: Cycles, whose materials displace by a bump unless they are told to move the mesh.
Differs:  a mesh that ought to be moved is bumped, too, with a note.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.surface_inputs import PointInput

from .coordinates import point_input
from .math_nodes import vector_operation
from .normal_nodes import bumped, is_flat, read_at_three_places
from .program import Value

if TYPE_CHECKING:
    from .node_graph import Socket
    from .program import Program
    from .value_nodes import ValueReader

_FILTER_WIDTH = 0.1 if bpy.app.version >= (4, 4, 0) else 1.0  #: Of Cycles' bumps that are no nodes, in pixels.


def displaced_normal(reader: ValueReader, material: bpy.types.Material, at: Socket | None) -> Value | None:
    """``at`` is the Displacement input of an output node. None: the surface keeps its normals."""
    if at is None or not at.is_connected():
        return None
    method = getattr(material, "displacement_method", None)  # from 4.1 on; before, where Cycles is on
    method = method or getattr(getattr(material, "cycles", None), "displacement_method", "BUMP")
    if method != "BUMP":
        reader.note("displacement is drawn as a bump, its mesh stays where it is")
    heights = read_at_three_places(reader, _FILTER_WIDTH, lambda: _height(reader, at))
    return None if is_flat(heights) else bumped(reader.program, heights, width=_FILTER_WIDTH)


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


def _of_displacement(reader: ValueReader, at: Socket) -> Value:
    program, normal_input = reader.program, at.input("Normal")
    height = program.subtract(reader.number(at.input("Height")), reader.number(at.input("Midlevel"), 0.5))
    height = program.multiply(height, reader.number(at.input("Scale"), 1.0))
    is_linked = normal_input is not None and normal_input.is_connected()
    normal = reader.colour(normal_input) if is_linked else point_input(program, PointInput.NORMAL)
    if at.node.space == "OBJECT":
        return program.multiply(height, _along_in_object(program, normal))
    return program.multiply(height, _along(program, normal)) if is_linked else height


def _of_vector_displacement(reader: ValueReader, at: Socket) -> Value:
    program, space = reader.program, at.node.space
    moved = program.subtract(reader.colour(at.input("Vector")), reader.number(at.input("Midlevel")))
    moved = program.multiply(moved, reader.number(at.input("Scale"), 1.0))
    if space == "TANGENT":  # of the object; x goes along the tangent, y along the normal
        along = _along_in_object(program, point_input(program, PointInput.NORMAL))
        return program.multiply(program.channel(moved, 1), along)
    if space == "OBJECT":
        moved = point_input(program, PointInput.DIRECTION_TO_WORLD, moved)
    return _along(program, moved)
