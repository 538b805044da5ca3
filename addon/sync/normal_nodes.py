# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of normals: Fresnel, Layer Weight, Normal Map and Bump, and what closures are given.

A bump's height is read three times, as Cycles compiles it: at the point and at two places beside it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import Code
from tyndall.surface_inputs import (
    BUMP_IS_INVERTED,
    BUMP_IS_VALID_SPECULAR,
    STRENGTH_MIXES_NORMALS,
    NormalSpace,
    PointInput,
)

from . import coordinates
from .domains import Domain, on_surfaces
from .mesh_attributes import tangent_of
from .program import BLACK, WHITE, Value

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .program import Program
    from .value_nodes import ValueReader

_IS_3 = bpy.app.version < (4, 0, 0)
_CLAMPS_ALL = bpy.app.version < (3, 6, 0)  #: Up to 3.5 every normal of a closure is one that a mirror could have.
_STRAIGHT = (0.5, 0.5, 1.0)  #: A map's colour where it bends nothing.
_SPACES = {
    "TANGENT": NormalSpace.TANGENT,
    "OBJECT": NormalSpace.OBJECT,
    "WORLD": NormalSpace.WORLD,
    "BLENDER_OBJECT": NormalSpace.BLENDER_OBJECT,
    "BLENDER_WORLD": NormalSpace.BLENDER_WORLD,
}


def closure_normal(reader: ValueReader, at: Socket | None, *, is_specular: bool = False) -> Value | None:
    """The unit normal of a shader's input as its closure uses it; None where it is the point's own.

    ``is_specular``: of closures for which Cycles turns a normal until a mirror would not look into the surface.
    """
    normal = own_or_linked(reader, at)
    if normal is None or normal == coordinates.point_input(reader.program, PointInput.NORMAL):
        return None
    is_clamped = _CLAMPS_ALL or (is_specular and reader.corrects_bumps)
    space = NormalSpace.VALID_SPECULAR if is_clamped else NormalSpace.UNIT
    return reader.program.operation(Code.NORMAL_MAP, normal, BLACK, BLACK, BLACK, option=int(space))


def own_or_linked(reader: ValueReader, at: Socket | None) -> Value | None:
    """What is linked to a Normal input, as it comes, or what displacement makes of the surface's; None: its own."""
    if at is None or reader.domain is not Domain.SURFACE:
        return None
    return reader.colour(at) if at.is_connected() else reader.displaced_normal


def _normal_input(reader: ValueReader, at: Socket) -> Value:
    linked = own_or_linked(reader, at.input("Normal"))
    return coordinates.point_input(reader.program, PointInput.NORMAL) if linked is None else linked


def _fresnel(reader: ValueReader, at: Socket) -> Value:
    return reader.program.operation(Code.FRESNEL, reader.number(at.input("IOR"), 1.45), _normal_input(reader, at))


def _layer_weight(reader: ValueReader, at: Socket) -> Value:
    is_facing = at.socket.identifier == "Facing"
    blend, normal = reader.number(at.input("Blend"), 0.5), _normal_input(reader, at)
    return reader.program.operation(Code.LAYER_WEIGHT, blend, normal, option=int(is_facing))


def _normal_map(reader: ValueReader, at: Socket) -> Value:
    program, node = reader.program, at.node
    colour, strength = reader.colour(at.input("Color")), reader.number(at.input("Strength"), 1.0)
    if getattr(node, "convention", "OPENGL") == "DIRECTX":
        reader.note("a DirectX normal map is read as one of OpenGL, upside down")
    space = _SPACES[node.space]
    if space is NormalSpace.TANGENT and colour == _STRAIGHT:  # the node's own colour: it asks for no tangents
        return coordinates.point_input(program, PointInput.NORMAL)
    tangent: Value = BLACK
    sign: Value = BLACK
    if space is NormalSpace.TANGENT:
        asked = tangent_of(node.uv_map)
        tangent, sign = coordinates.made(program, asked), coordinates.made_fourth(program, asked)
    selector = STRENGTH_MIXES_NORMALS if _IS_3 else 0
    return program.operation(Code.NORMAL_MAP, colour, strength, tangent, sign, option=int(space), selector=selector)


def read_at_three_places(reader: ValueReader, width: float, read: Callable[[], Value]) -> list[Value]:
    """At the point, and as wide a part of a pixel beside it to the right and above."""
    heights = []
    outer = reader.program.beside
    for shift in range(3):
        reader.program.beside = (shift, width) if shift else None
        heights.append(read())
    reader.program.beside = outer
    return heights


def is_flat(heights: list[Value]) -> bool:
    """What is as high at all places bends no normal."""
    return all(height == heights[0] for height in heights)


def bumped(
    program: Program,
    heights: list[Value],
    strength: Value = WHITE,
    distance: Value = WHITE,
    normal: Value | None = None,
    *,
    width: float,
    is_inverted: bool = False,
) -> Value:
    """A normal, the point's own without another, on what is so high at three places."""
    selector = BUMP_IS_INVERTED if is_inverted else 0
    if _CLAMPS_ALL:
        selector |= BUMP_IS_VALID_SPECULAR
    if normal is None:
        normal = coordinates.point_input(program, PointInput.NORMAL)
    return program.operation(
        Code.BUMP, *heights, strength, distance, normal, selector=selector, value=(width, 0.0, 0.0)
    )


def _bump(reader: ValueReader, at: Socket) -> Value:
    """Within the height of another bump it is as it is at the point."""
    width = reader.constant(at.input("Filter Width"), 1.0) if at.input("Filter Width") else 1.0
    height = at.input("Height")
    normal = _normal_input(reader, at)
    if height is None or not height.is_connected():
        return normal
    width = max(width, 1e-5)
    heights = read_at_three_places(reader, width, lambda: reader.number(height))
    strength, distance = reader.number(at.input("Strength"), 1.0), reader.number(at.input("Distance"), 1.0)
    if is_flat(heights):
        return normal
    return bumped(reader.program, heights, strength, distance, normal, width=width, is_inverted=at.node.invert)


NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "FRESNEL": on_surfaces(_fresnel),
    "LAYER_WEIGHT": on_surfaces(_layer_weight),
    "NORMAL_MAP": on_surfaces(_normal_map),
    "BUMP": on_surfaces(_bump),
}
