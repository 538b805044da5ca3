# SPDX-License-Identifier: GPL-3.0-or-later
"""The plane that is painted on: it faces the view, and slides through the box along the view.

Based on: Kol, dissertation, TU Delft 2018, 5.4.3. The plane turns with the view around the point that it goes through.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import atan2
from typing import TYPE_CHECKING

from mathutils import Matrix, Vector

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Region, RegionView3D

#: Of the box's extent along the view: what the plane slides at once.
_STEP = 1.0 / 40.0
#: So much of the box, at least, is before the plane: at the camera itself everything would be at one point.
_NEAREST = 0.02
_GRID_LINES = 16


@dataclass(frozen=True, kw_only=True)
class Ray:
    """What is seen under a place of a region."""

    origin: Vector
    direction: Vector


def ray_under(region: Region, x: float, y: float) -> Ray:
    """Of pixels from the region's left and bottom."""
    from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

    place = (x, y)
    return Ray(
        origin=region_2d_to_origin_3d(region, region.data, place),
        direction=region_2d_to_vector_3d(region, region.data, place),
    )


class AirPlane:
    """Through ``point``, in the world; across whatever way one looks."""

    def __init__(self, world_from_unit: Matrix) -> None:
        self._world_from_unit = world_from_unit
        self.point: Vector = world_from_unit @ Vector((0.5, 0.5, 0.5))

    def follow(self, world_from_unit: Matrix) -> None:
        """Stay where it is in a box that was moved or scaled."""
        if world_from_unit != self._world_from_unit:
            self.point = world_from_unit @ (self._world_from_unit.inverted() @ self.point)
            self._world_from_unit = world_from_unit

    def keep_in(self, view: RegionView3D) -> bool:
        """Slide it back into the part of the box that the view sees. False: it sees none."""
        normal = normal_of(view)
        nearest, farthest = self._extent(normal)
        if view.is_perspective:
            eye = view.view_matrix.inverted().translation
            nearest = max(nearest, eye.dot(normal) + _NEAREST * (farthest - nearest))
        if nearest >= farthest:
            return False
        depth = self.point.dot(normal)
        self.point += normal * (min(max(depth, nearest), farthest) - depth)
        return True

    def slide(self, view: RegionView3D, steps: int) -> None:
        """Away from the viewer, for positive steps."""
        normal = normal_of(view)
        nearest, farthest = self._extent(normal)
        self.point += normal * (steps * _STEP * (farthest - nearest))
        self.keep_in(view)

    def depth_in_box(self, view: RegionView3D) -> float:
        """From 0, where the box begins along the view, to 1 at its end."""
        normal = normal_of(view)
        nearest, farthest = self._extent(normal)
        return (self.point.dot(normal) - nearest) / (farthest - nearest)

    def meet(self, view: RegionView3D, ray: Ray) -> Vector | None:
        """Where a ray goes through it; None: it does so behind the viewer."""
        normal = normal_of(view)
        along = ray.direction.dot(normal)
        way = (self.point - ray.origin).dot(normal) / along if along > 0.0 else -1.0
        return ray.origin + ray.direction * way if way > 0.0 or not view.is_perspective else None

    def outline(self, view: RegionView3D) -> list[Vector]:
        """Its cut through the box: corners of a convex polygon in their order; none where they do not meet."""
        across, up, normal = axes_of(view)
        crossings = list(self._crossings(normal))
        centre = sum(crossings, Vector()) / max(1, len(crossings))
        return sorted(crossings, key=lambda point: atan2((point - centre).dot(up), (point - centre).dot(across)))

    def grid(self, view: RegionView3D) -> Iterator[tuple[Vector, Vector]]:
        """Lines over the cut, from rim to rim: along the view's right, then along its up."""
        corners = self.outline(view)
        if len(corners) < 3:  # noqa: PLR2004
            return
        across, up, _normal = axes_of(view)
        for along, over in ((across, up), (up, across)):
            places = [corner.dot(over) for corner in corners]
            low, high = min(places), max(places)
            for line in range(1, _GRID_LINES):
                level = low + (high - low) * line / _GRID_LINES
                ends = [
                    one.lerp(other, (level - at) / (to - at))
                    for one, other, at, to in zip(
                        corners, corners[1:] + corners[:1], places, places[1:] + places[:1], strict=True
                    )
                    if (at < level) != (to < level)
                ]
                if len(ends) == 2:  # noqa: PLR2004
                    yield min(ends, key=along.dot), max(ends, key=along.dot)

    def _corners(self) -> list[Vector]:
        return [self._world_from_unit @ Vector(corner) for corner in product((0.0, 1.0), repeat=3)]

    def _extent(self, normal: Vector) -> tuple[float, float]:
        """Where the box begins and ends along a direction."""
        depths = [corner.dot(normal) for corner in self._corners()]
        return min(depths), max(depths)

    def _crossings(self, normal: Vector) -> Iterator[Vector]:
        """Of the box's edges."""
        corners = self._corners()
        heights = [(corner - self.point).dot(normal) for corner in corners]
        for one, other in product(range(8), repeat=2):
            is_edge = one < other and (one ^ other) in {1, 2, 4}
            if is_edge and (heights[one] < 0.0) != (heights[other] < 0.0):
                yield corners[one].lerp(corners[other], heights[one] / (heights[one] - heights[other]))


def normal_of(view: RegionView3D) -> Vector:
    """Away from the viewer."""
    return view.view_rotation @ Vector((0.0, 0.0, -1.0))


def axes_of(view: RegionView3D) -> tuple[Vector, Vector, Vector]:
    """To the right, up, and away from the viewer: unit vectors."""
    return view.view_rotation @ Vector((1.0, 0.0, 0.0)), view.view_rotation @ Vector((0.0, 1.0, 0.0)), normal_of(view)
