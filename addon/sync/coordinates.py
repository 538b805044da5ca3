# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a surface is looked up: coordinates, directions and spaces as values of its program."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.scene_description import Code
from tyndall.surface_inputs import PointInput

from .mesh_attributes import GENERATED, UNDISPLACED, made_maps

if TYPE_CHECKING:
    from mathutils import Matrix

    from .program import Program, Value

_UV_AS_VECTOR = (1, 0, 0, 0, 1, 0, 0, 0, 0)


def point_input(program: Program, kind: PointInput, *operands: Value, selector: int = 0) -> Value:
    """``program.is_undisplaced``: at the place where the mesh was before its material moved it."""
    if program.is_undisplaced and kind is PointInput.OBJECT_POSITION:
        return made(program, UNDISPLACED)
    if program.is_undisplaced and kind is PointInput.POSITION:
        return program.operation(Code.INPUT, made(program, UNDISPLACED), option=int(PointInput.POINT_TO_WORLD))
    return program.operation(Code.INPUT, *operands, option=int(kind), selector=selector)


def uv(program: Program, name: str = "") -> Value:
    """(u, v, 0) of a UV map; "": the active one."""
    return program.operation(Code.UV, uv_map=program.uv_map_index(name), uv_matrix=_UV_AS_VECTOR)


def made(program: Program, name: str) -> Value:
    """The first three numbers of what a mesh is asked to have, see mesh_attributes.py."""
    first, second = (program.uv_map_index(one) for one in made_maps(name))
    return program.add(
        program.operation(Code.UV, uv_map=first, uv_matrix=_UV_AS_VECTOR),
        program.operation(Code.UV, uv_map=second, uv_matrix=(0, 0, 0, 0, 0, 0, 1, 0, 0)),
    )


def made_fourth(program: Program, name: str) -> Value:
    second = program.uv_map_index(made_maps(name)[1])
    return program.operation(Code.UV, uv_map=second, uv_matrix=(0, 1, 0, 0, 1, 0, 0, 1, 0))


def generated(program: Program) -> Value:
    """From 0 to 1 over the undeformed mesh's texture space."""
    return made(program, GENERATED)


def transformed(program: Program, vector: Value, matrix: Matrix, *, is_direction: bool = False) -> Value:
    """By a 4x4 matrix."""
    rows = [[float(number) for number in row] for row in matrix]
    offset = (0.0, 0.0, 0.0) if is_direction else (rows[0][3], rows[1][3], rows[2][3])
    linear = tuple(rows[row][column] for row in range(3) for column in range(3))
    return program.operation(Code.AFFINE, vector, uv_matrix=linear, value=offset)


def radial_tangent(program: Program, axis: str) -> Value:
    """Around an axis of the texture space, in the surface."""
    rows = {"X": (0, 0, 0, 0, 0, -1, 0, 1, 0), "Y": (0, 0, -1, 0, 0, 0, 1, 0, 0), "Z": (0, -1, 0, 1, 0, 0, 0, 0, 0)}
    from_middle = program.subtract(generated(program), (0.5, 0.5, 0.5))
    around = program.operation(Code.AFFINE, from_middle, uv_matrix=rows[axis], value=(0.0, 0.0, 0.0))
    return point_input(program, PointInput.TANGENT, around)
