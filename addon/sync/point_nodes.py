# SPDX-License-Identifier: GPL-3.0-or-later
"""What Point Info tells of the points of a cloud. All is 0 elsewhere, as in Cycles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from tyndall.scene_description import Code, point_maps
from tyndall.surface_inputs import PointInput

from .coordinates import point_input
from .hair_nodes import hair_vector
from .math_nodes import vector_operation
from .program import Value, grey

if TYPE_CHECKING:
    from .program import Program


def point_position(program: Program) -> Value:
    """Of the point that a sphere of a point cloud is, in the world; elsewhere 0."""
    xy, zr, random = point_maps()
    centre = point_input(program, PointInput.POINT_TO_WORLD, hair_vector(program, xy, zr))
    is_point = program.operation(Code.UV, uv_map=program.uv_map_index(random), uv_matrix=(0, 1, 0) * 3)
    return program.multiply(is_point, centre)


def point_radius(program: Program) -> Value:
    """In the world, under an uneven scale as Cycles has it from 4.0 on, and before of what is drawn more than once."""
    zr = program.uv_map_index(point_maps()[1])
    radius = program.operation(Code.UV, uv_map=zr, uv_matrix=(0, 1, 0) * 3)
    along_all_axes = program.multiply(radius, grey(1.0 / math.sqrt(3.0)))
    scaled = point_input(program, PointInput.DIRECTION_TO_WORLD, along_all_axes)
    return vector_operation(program, "LENGTH", scaled)


def point_random(program: Program) -> Value:
    """By its place in the cloud."""
    random = program.uv_map_index(point_maps()[2])
    return program.operation(Code.UV, uv_map=random, uv_matrix=(1, 0, 0) * 3)
