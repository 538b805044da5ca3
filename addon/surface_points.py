# SPDX-License-Identifier: GPL-3.0-or-later
"""Points that stay on a surface while it moves and deforms: object, triangle, weights of its corners.

Triangles are those of the evaluated mesh. Where their number has changed, since a modifier was added, say, the point is
held by its place in the object's space instead. So is a point on an instance, in the space of what instances it.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mathutils import Vector
from mathutils.geometry import closest_point_on_tri
from mathutils.interpolate import poly_3d_calc

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Mesh, MeshLoopTriangle, Object

    from .properties.transfer_layers import TyndallTransferConstraint


@dataclass(frozen=True, kw_only=True)
class Anchor:
    """Where on an object's surface a point is."""

    triangle_index: int
    triangle_count: int  #: Of the whole mesh, when the point was set; 0: the point is fixed in the object's space.
    weights: tuple[float, float, float]
    local_point: tuple[float, float, float]  #: In the object's space, then.


@dataclass(frozen=True, kw_only=True)
class Followed:
    """Where an anchored point is now."""

    world_point: tuple[float, float, float]
    is_by_place: bool = False  #: The mesh has other triangles than it had.


def anchor_at(thing: Object, polygon_index: int, local_point: Vector) -> Anchor:
    """``thing`` is evaluated; the polygon and the point on it are what ``Object.ray_cast`` returns."""
    with _triangulated(thing) as mesh:
        triangles = [triangle for triangle in mesh.loop_triangles if triangle.polygon_index == polygon_index]

        def distance(triangle: MeshLoopTriangle) -> float:
            return (closest_point_on_tri(local_point, *_corners(mesh, triangle)) - local_point).length

        triangle = min(triangles or mesh.loop_triangles, key=distance)
        weights = poly_3d_calc(_corners(mesh, triangle), local_point)
        return Anchor(
            triangle_index=triangle.index,
            triangle_count=len(mesh.loop_triangles),
            weights=tuple(weights),
            local_point=tuple(local_point),
        )


def anchor_in(thing: Object, world_point: Vector) -> Anchor:
    """Fixed in the space of an object, which is evaluated, and need not have a surface."""
    local_point = thing.matrix_world.inverted_safe() @ world_point
    return Anchor(triangle_index=0, triangle_count=0, weights=(0.0, 0.0, 0.0), local_point=tuple(local_point))


def anchor_of(constraint: TyndallTransferConstraint) -> Anchor:
    """Where a constraint says that it is."""
    return Anchor(
        triangle_index=constraint.triangle_index,
        triangle_count=constraint.triangle_count,
        weights=tuple(constraint.triangle_weights),
        local_point=tuple(constraint.local_point),
    )


def follow(anchor: Anchor, thing: Object) -> Followed | None:
    """``thing`` is evaluated. None: it has no surface any more."""
    if anchor.triangle_count == 0:
        return Followed(world_point=tuple(thing.matrix_world @ Vector(anchor.local_point)))
    try:
        with _triangulated(thing) as mesh:
            if len(mesh.loop_triangles) == anchor.triangle_count:
                corners = _corners(mesh, mesh.loop_triangles[anchor.triangle_index])
                local_point = sum((at * weight for at, weight in zip(corners, anchor.weights, strict=True)), Vector())
                return Followed(world_point=tuple(thing.matrix_world @ local_point))
        is_found, local_point, _normal, _polygon = thing.closest_point_on_mesh(anchor.local_point)
    except (RuntimeError, IndexError):  # it is no mesh, or the anchor was set by a script that has miscounted
        return None
    return Followed(world_point=tuple(thing.matrix_world @ local_point), is_by_place=True) if is_found else None


@contextmanager
def _triangulated(thing: Object) -> Iterator[Mesh]:
    """The mesh as it is drawn: ``data`` may be coarser in a window that subdivides on its graphics card."""
    mesh = thing.to_mesh()
    try:
        mesh.calc_loop_triangles()
        yield mesh
    finally:
        thing.to_mesh_clear()


def _corners(mesh: Mesh, triangle: MeshLoopTriangle) -> list[Vector]:
    return [mesh.vertices[index].co for index in triangle.vertices]
