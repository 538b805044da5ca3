# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute with numbers and vectors.

Sums, differences and products are the program's own, so that a light's texture may still be told to be linear.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.scene_description import Code
from tyndall.surface_operations import MATH_OPERATIONS, RANGES, VECTOR_OPERATIONS

from .program import BLACK, WHITE, Program, Term, Value

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .value_nodes import ValueReader

_AXES = {"X_AXIS": (1.0, 0.0, 0.0), "Y_AXIS": (0.0, 1.0, 0.0), "Z_AXIS": (0.0, 0.0, 1.0)}
_AROUND, _AROUND_BACK, _BY_ANGLES, _BY_ANGLES_BACK = range(4)  # RotationKind of shading/op_math.hpp


def math_operation(program: Program, name: str, *operands: Value) -> Value:
    """Of numbers, by Blender's name."""
    return program.operation(Code.MATH, *operands, option=MATH_OPERATIONS.index(name))


def vector_operation(program: Program, name: str, *operands: Value) -> Value:
    """Of vectors, by Blender's name."""
    return program.operation(Code.VECTOR_MATH, *operands, option=VECTOR_OPERATIONS.index(name))


def rotated(program: Program, vector: Value, angles: Value, *, is_back: bool = False) -> Value:
    """About x, then y, then z."""
    kind = _BY_ANGLES_BACK if is_back else _BY_ANGLES
    return program.operation(Code.VECTOR_ROTATE, vector, BLACK, angles, option=kind)


def turned(program: Program, vector: Value, axis: Value, angle: Value) -> Value:
    """About an axis, by radians."""
    return program.operation(Code.VECTOR_ROTATE, vector, BLACK, axis, angle, option=_AROUND)


def _arithmetic(program: Program, operation: str, a: Value, b: Value, c: Value) -> Value | None:
    """What a program computes by itself."""
    if operation == "ADD":
        return program.add(a, b)
    if operation == "SUBTRACT":
        return program.subtract(a, b)
    if operation in {"MULTIPLY", "SCALE"}:
        return program.multiply(a, b)
    if operation == "MULTIPLY_ADD":
        return program.add(program.multiply(a, b), c)
    if operation == "DIVIDE" and not isinstance(b, Term):
        one_by_b = tuple(1.0 / channel if channel else 0.0 for channel in b)
        return program.multiply(a, (one_by_b[0], one_by_b[1], one_by_b[2]))
    return None


def _math(reader: ValueReader, at: Socket) -> Value:
    program, operation = reader.program, at.node.operation
    values = [reader.number(socket) for socket in at.inputs()]
    a, b, c = [*values, BLACK, BLACK][:3]
    result = _arithmetic(program, operation, a, b, c)
    if result is None:
        result = math_operation(program, operation, a, b, c)
    return program.clamp(result) if at.node.use_clamp else result


def _vector_math(reader: ValueReader, at: Socket) -> Value:
    program, operation = reader.program, at.node.operation
    a, b, c, scale = (at.input(name) for name in ("Vector", "Vector_001", "Vector_002", "Scale"))
    values = reader.vector(a), reader.vector(b), reader.vector(c)
    if operation in {"SCALE", "REFRACT"}:
        number = reader.number(scale)
        values = (values[0], number, BLACK) if operation == "SCALE" else (values[0], values[1], number)
    result = _arithmetic(program, operation, *values)
    return vector_operation(program, operation, *values) if result is None else result


def _map_range(reader: ValueReader, at: Socket) -> Value:
    node, program = at.node, reader.program
    kind = node.interpolation_type
    if getattr(node, "data_type", "FLOAT") == "FLOAT":
        names = ("Value", "From Min", "From Max", "To Min", "To Max", "Steps")
        operands = [reader.number(at.input(name)) for name in names]
        result = program.operation(Code.MAP_RANGE, *operands, option=RANGES.index(kind), selector=0)
        return math_operation(program, "CLAMP_RANGE", result, operands[3], operands[4]) if node.clamp else result
    names = ("Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Steps_FLOAT3")
    operands = [reader.vector(at.input(name)) for name in names]
    return program.operation(Code.MAP_RANGE, *operands, option=RANGES.index(kind), selector=2 if node.clamp else 1)


def _clamp(reader: ValueReader, at: Socket) -> Value:
    value, low, high = (reader.number(at.input(name)) for name in ("Value", "Min", "Max"))
    is_range = at.node.clamp_type == "RANGE"
    if low == BLACK and high == WHITE:
        return reader.program.clamp(value)
    return math_operation(reader.program, "CLAMP_RANGE" if is_range else "CLAMP_MINMAX", value, low, high)


def _vector_rotate(reader: ValueReader, at: Socket) -> Value:
    node, program = at.node, reader.program
    vector, centre = (reader.vector(at.input(name)) for name in ("Vector", "Center"))
    if node.rotation_type == "EULER_XYZ":
        kind = _BY_ANGLES_BACK if node.invert else _BY_ANGLES
        return program.operation(Code.VECTOR_ROTATE, vector, centre, reader.vector(at.input("Rotation")), option=kind)
    axis = _AXES.get(node.rotation_type) or reader.vector(at.input("Axis"))
    return program.operation(
        Code.VECTOR_ROTATE,
        vector,
        centre,
        axis,
        reader.number(at.input("Angle")),
        option=_AROUND_BACK if node.invert else _AROUND,
    )


def _mapping(reader: ValueReader, at: Socket) -> Value:
    program, kind = reader.program, at.node.vector_type
    vector, rotation, scale = (reader.vector(at.input(name)) for name in ("Vector", "Rotation", "Scale"))
    location = reader.vector(at.input("Location")) if at.input("Location") else BLACK
    if kind == "TEXTURE":
        back = rotated(program, program.subtract(vector, location), rotation, is_back=True)
        return vector_operation(program, "DIVIDE", back, scale)
    if kind == "NORMAL":
        turned = rotated(program, vector_operation(program, "DIVIDE", vector, scale), rotation)
        return vector_operation(program, "NORMALIZE", turned)
    turned = rotated(program, program.multiply(vector, scale), rotation)
    return program.add(turned, location) if kind == "POINT" else turned


def _separate(reader: ValueReader, at: Socket) -> Value:
    outputs = [socket.identifier for socket in at.node.outputs]
    return reader.program.channel(reader.vector(at.inputs()[0]), outputs.index(at.socket.identifier))


def _combine(reader: ValueReader, at: Socket) -> Value:
    return reader.program.combine([reader.number(socket) for socket in at.inputs()])


def _normal(reader: ValueReader, at: Socket) -> Value:
    """A direction of its own, and the cosine of the input to it."""
    program = reader.program
    stored = tuple(at.node.outputs["Normal"].default_value)
    if at.socket.identifier == "Normal":
        return vector_operation(program, "NORMALIZE", stored)
    directions = (reader.vector(at.input("Normal")), stored)
    return vector_operation(
        program, "DOT_PRODUCT", *(vector_operation(program, "NORMALIZE", one) for one in directions)
    )


NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "MATH": _math,
    "VECT_MATH": _vector_math,
    "MAP_RANGE": _map_range,
    "CLAMP": _clamp,
    "VECTOR_ROTATE": _vector_rotate,
    "MAPPING": _mapping,
    "SEPXYZ": _separate,
    "COMBXYZ": _combine,
    "NORMAL": _normal,
}
