# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors in the node tree of a light: where its picture is read, as ratios of linear forms of one direction.

What a light's shader sees of the shading point is the direction towards it, and what Cycles makes of that; measured in
3.4.1, 4.5.15 and 5.0.1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import TYPE_CHECKING

import bpy
import numpy as np

from .texture_nodes import mapping_matrix

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .node_graph import Socket
    from .value_nodes import ValueReader

_IS_BLENDER_4 = bpy.app.version >= (4, 0, 0)


class CannotBeRead(Exception):  # noqa: N818  said to the artist, not raised to a caller
    """A vector that is no ratio of linear forms of a direction; the message names the node."""


class Start(Enum):
    """What a vector is made from."""

    DIRECTION = auto()  #: In which the light leaves.
    NORMAL = auto()  #: Of the emitter there: of a light without a size the direction.
    SPHERE = auto()  #: Longitude and latitude of the normal, x and y of the forms.


class Frame(Enum):
    """The axes that a vector has its components along."""

    WORLD = auto()
    LIGHT = auto()  #: As points turn.
    LIGHT_NORMALS = auto()  #: As Cycles turns normals: by the transpose, whatever the scale.

    def axes_from_world(self, world_from_light: NDArray[np.float64]) -> NDArray[np.float64]:
        """(3, 3) of (3, 3)."""
        if self is Frame.WORLD:
            return np.eye(3)
        return world_from_light.T if self is Frame.LIGHT_NORMALS else np.linalg.pinv(world_from_light)


@dataclass(frozen=True)
class Origin:
    """One output of a node that says where the light goes."""

    start: Start
    frame: Frame = Frame.WORLD


@dataclass(frozen=True)
class Ratio:
    """A number of the shader: ``above @ (x, y, z, 1)`` over ``below @ (x, y, z, 1)``."""

    above: NDArray[np.float64]  #: (4,)
    below: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))  #: (4,)

    @property
    def is_constant(self) -> bool:
        return not self.above[:3].any() and not self.below[:3].any()

    @property
    def value(self) -> float:
        return float(self.above[3] / self.below[3]) if self.below[3] else 0.0

    def scaled(self, factor: float) -> Ratio:
        return Ratio(self.above * factor, self.below)

    def numerator(self, below: NDArray[np.float64]) -> NDArray[np.float64]:
        """Over this denominator. Raises CannotBeRead where it has another."""
        if self.is_constant:
            return self.value * below
        if not np.allclose(self.below, below):
            raise CannotBeRead("coordinates with different divisors")
        return self.above


def constant(value: float) -> Ratio:
    return Ratio(np.array([0.0, 0.0, 0.0, value]))


@dataclass(frozen=True)
class Vector:
    """Three ratios of forms of one origin; of none, where all are constant."""

    ratios: tuple[Ratio, Ratio, Ratio]
    origin: Origin | None = None


def read_vector(reader: ValueReader, light: bpy.types.Light, at: Socket) -> Vector:
    """``at`` is an input. Raises CannotBeRead."""
    return _VectorReader(reader, light).vector(at)


def spot_coordinates(cone_rad: float) -> Vector:
    """The picture fills the cone, as 4.0 and later have it."""
    half_cotangent = 0.5 / math.tan(cone_rad / 2.0)
    depth = np.array([0.0, 0.0, -1.0, 0.0])
    u, v = (Ratio(half_cotangent * np.eye(4)[axis] + 0.5 * depth, depth) for axis in range(2))
    return Vector((u, v, constant(0.0)), Origin(Start.DIRECTION, Frame.LIGHT))


def uv_of_light(light: bpy.types.Light, label: str) -> Vector:
    """The UV output of Texture Coordinate, and what an image node reads that has no vector. Raises CannotBeRead."""
    if light.type == "SUN":
        raise CannotBeRead(f"{label} sees no position on a sun: use its gobo")
    if not _IS_BLENDER_4:
        return Vector((constant(0.0), constant(0.0), constant(0.0)))
    if light.type == "SPOT":
        return spot_coordinates(light.spot_size)
    return Vector(_identity(2), Origin(Start.SPHERE, Frame.LIGHT))


def _identity(count: int) -> tuple[Ratio, Ratio, Ratio]:
    """The origin's own first components; 0 for the others."""
    x, y, z = (Ratio(np.eye(4)[axis]) if axis < count else constant(0.0) for axis in range(3))
    return x, y, z


class _VectorReader:
    def __init__(self, reader: ValueReader, light: bpy.types.Light) -> None:
        self._reader = reader
        self._light = light
        self._origin: Origin | None = None

    def vector(self, at: Socket) -> Vector:
        ratios = self._read(at)
        return Vector(ratios, self._origin)

    def _start(self, vector: Vector) -> tuple[Ratio, Ratio, Ratio]:
        """One picture has one place: vectors from two different outputs do not add up."""
        if self._origin is not None and vector.origin is not None and self._origin != vector.origin:
            raise CannotBeRead("a vector made from two outputs")
        self._origin = vector.origin or self._origin
        return vector.ratios

    def _read(self, at: Socket) -> tuple[Ratio, Ratio, Ratio]:
        """An input as a vector."""
        source = at.source()
        if not source.socket.is_output:
            own = self._reader.constant_colour(at)
            return constant(own[0]), constant(own[1]), constant(own[2])
        node = source.node
        if node.type == "MAPPING" and node.vector_type != "NORMAL":
            return self._mapped(np.array(mapping_matrix(self._reader, source)), self._read(source.input("Vector")))
        if node.type == "COMBXYZ":
            x, y, z = (self._number(socket) for socket in source.inputs())
            return x, y, z
        if node.type == "VECT_MATH":
            return self._vector_math(source)
        if node.type in {"TEX_COORD", "NEW_GEOMETRY", "UVMAP"}:
            return self._start(self._output(source))
        if source.socket.type in {"VALUE", "INT"}:
            number = self._number(at)
            return number, number, number
        raise CannotBeRead(node.bl_label)

    def _output(self, source: Socket) -> Vector:
        name = source.socket.identifier
        is_coordinate = source.node.type == "TEX_COORD"
        label = f"{source.node.bl_label} {source.socket.name}"
        if source.node.type == "UVMAP" or (is_coordinate and name == "UV"):
            return uv_of_light(self._light, label)
        if self._light.type == "SUN":
            raise CannotBeRead(f"{label} sees no position on a sun: use its gobo")
        if is_coordinate and name == "Normal":
            return Vector(_identity(3), Origin(Start.NORMAL, Frame.LIGHT_NORMALS))
        if not is_coordinate and name in {"Normal", "True Normal"}:
            return Vector(_identity(3), Origin(Start.NORMAL))
        if not is_coordinate and name == "Incoming":
            return Vector(_identity(3), Origin(Start.DIRECTION))
        if not is_coordinate and name == "Parametric":
            if _IS_BLENDER_4:
                return uv_of_light(self._light, label)
            first = Ratio(np.array([-1.0, -1.0, 0.0, 1.0]))  # barycentric: 1 - u - v, and u
            return Vector((first, Ratio(np.eye(4)[0]), constant(0.0)), Origin(Start.SPHERE))
        raise CannotBeRead(label)

    def _number(self, at: Socket) -> Ratio:
        """An input as a number."""
        source = at.source()
        if source.socket.is_output:
            node = source.node
            if node.type in {"SEPXYZ", "SEPRGB", "SEPARATE_COLOR"}:
                names = [socket.identifier for socket in node.outputs]
                return self._read(source.inputs()[0])[names.index(source.socket.identifier)]
            if node.type == "MATH":
                return self._math(source)
            if source.socket.type == "VECTOR":
                return _sum(*(part.scaled(1.0 / 3.0) for part in self._read(at)))
        return constant(self._reader.constant(at))

    def _math(self, at: Socket) -> Ratio:
        values = [self._number(socket) for socket in at.inputs()]
        result = _COMBINED.get(at.node.operation)
        if result is not None and not at.node.use_clamp:
            return result(*values[: _OPERANDS.get(at.node.operation, 2)])
        if all(value.is_constant for value in values):
            return constant(self._reader.constant(at))
        raise CannotBeRead(f"{at.node.bl_label} {at.node.operation.replace('_', ' ').lower()}")

    def _vector_math(self, at: Socket) -> tuple[Ratio, Ratio, Ratio]:
        operation = at.node.operation
        inputs = at.inputs()
        if operation == "SCALE":
            factor = self._number(inputs[-1])
            x, y, z = (_product(part, factor) for part in self._read(inputs[0]))
            return x, y, z
        if operation not in _COMBINED:
            raise CannotBeRead(f"{at.node.bl_label} {operation.replace('_', ' ').lower()}")
        operands = [self._read(socket) for socket in inputs[: _OPERANDS.get(operation, 2)]]
        x, y, z = (_COMBINED[operation](*parts) for parts in zip(*operands, strict=True))
        return x, y, z

    def _mapped(self, matrix: NDArray[np.float64], parts: tuple[Ratio, Ratio, Ratio]) -> tuple[Ratio, Ratio, Ratio]:
        x, y, z = (
            _sum(*(part.scaled(matrix[row, column]) for column, part in enumerate(parts)), constant(matrix[row, 3]))
            for row in range(3)
        )
        return x, y, z


def _sum(*parts: Ratio) -> Ratio:
    """Over one denominator, which all parts that count must share, or be constant."""
    varying = [part for part in parts if not part.is_constant and part.above.any()]
    below = varying[0].below if varying else constant(1.0).below
    if not all(np.allclose(part.below, below) for part in varying):
        raise CannotBeRead("a sum of different quotients")
    above = sum((part.above for part in varying), np.zeros(4))
    rest = sum(part.value for part in parts if part.is_constant)
    return Ratio(above + rest * below, below)


def _product(a: Ratio, b: Ratio) -> Ratio:
    if a.is_constant:
        a, b = b, a
    if not b.is_constant:
        raise CannotBeRead("a product of two coordinates")
    return a.scaled(b.value)


def _quotient(a: Ratio, b: Ratio) -> Ratio:
    if b.is_constant:
        return a.scaled(1.0 / b.value if b.value else 0.0)
    if a.is_constant:
        return Ratio(a.value * b.below, b.above)
    if not np.allclose(a.below, b.below):
        raise CannotBeRead("a quotient of quotients")
    return Ratio(a.above, b.above)


_COMBINED: dict[str, Callable[..., Ratio]] = {
    "ADD": _sum,
    "SUBTRACT": lambda a, b: _sum(a, b.scaled(-1.0)),
    "MULTIPLY": _product,
    "DIVIDE": _quotient,
    "MULTIPLY_ADD": lambda a, b, c: _sum(_product(a, b), c),
}
_OPERANDS = {"MULTIPLY_ADD": 3}
