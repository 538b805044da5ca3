# SPDX-License-Identifier: GPL-3.0-or-later
"""The plane that is painted on: it faces the view, and slides through the box."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import bpy
import pytest
from mathutils import Euler, Matrix, Vector

from addon.air_plane import AirPlane, Ray, axes_of, normal_of
from addon.painted_air import world_from_unit
from support.painted_box import painted_box


@pytest.fixture
def box() -> bpy.types.Object:
    return painted_box()


def view_from(*, rotation: tuple[float, float, float], eye: Vector | None = None) -> Any:
    """What the plane reads of a 3D view."""
    turn = Euler(rotation).to_quaternion()
    camera = Matrix.Translation(eye or Vector((0.0, 0.0, 10.0))) @ turn.to_matrix().to_4x4()
    return SimpleNamespace(view_rotation=turn, view_matrix=camera.inverted(), is_perspective=eye is not None)


def plane_of(box: bpy.types.Object) -> AirPlane:
    return AirPlane(Matrix(world_from_unit(box)))


@pytest.mark.parametrize("rotation", [(0.0, 0.0, 0.0), (math.pi / 2, 0.0, 0.0), (1.1, 0.2, 0.7)])
def test_the_plane_faces_the_view_and_stays_in_the_box(
    box: bpy.types.Object, rotation: tuple[float, float, float]
) -> None:
    """It slides from one end of the box to the other, and no further."""
    view, plane = view_from(rotation=rotation), plane_of(box)
    assert plane.depth_in_box(view) == pytest.approx(0.5)
    plane.slide(view, 1000)
    assert plane.depth_in_box(view) == pytest.approx(1.0, abs=1e-5)
    plane.slide(view, -20)
    assert plane.depth_in_box(view) == pytest.approx(0.5, abs=1e-5)
    plane.slide(view, -1000)
    assert plane.depth_in_box(view) == pytest.approx(0.0, abs=1e-5)


def test_the_plane_cuts_the_box_in_a_polygon(box: bpy.types.Object) -> None:
    """A square from the front, a hexagon along the diagonal; its grid ends on its rim."""
    front = view_from(rotation=(math.pi / 2, 0.0, 0.0))
    plane = plane_of(box)
    corners = plane.outline(front)
    assert (
        sorted((round(abs(x), 5), round(abs(y), 5), round(abs(z), 5)) for x, y, z in corners) == [(2.0, 0.0, 2.0)] * 4
    )
    diagonal = view_from(rotation=(math.atan(math.sqrt(2.0)), 0.0, math.pi / 4))
    corners = plane.outline(diagonal)
    assert len(corners) == 6
    sides = [(one - other).length for one, other in zip(corners, corners[1:] + corners[:1], strict=True)]
    assert sides == pytest.approx([2.0 * math.sqrt(2.0)] * 6, rel=1e-5)
    lines = list(plane.grid(diagonal))
    assert len(lines) == 30
    for end in (end for line in lines for end in line):
        assert max(map(abs, end)) == pytest.approx(2.0, rel=1e-5)
        assert end.dot(normal_of(diagonal)) == pytest.approx(0.0, abs=1e-5)


def test_a_viewer_within_the_box_has_the_plane_before_them(box: bpy.types.Object) -> None:
    view = view_from(rotation=(0.0, 0.0, 0.0), eye=Vector((0.0, 0.0, -0.5)))
    plane = plane_of(box)
    assert plane.keep_in(view)
    assert -2.0 <= plane.point.z < -0.5
    behind = view_from(rotation=(0.0, 0.0, 0.0), eye=Vector((0.0, 0.0, -3.0)))
    assert not plane.keep_in(behind)


def test_a_place_on_the_plane_is_under_the_mouse(box: bpy.types.Object) -> None:
    """The ray through it meets the plane there; one that looks away meets nothing."""
    view = view_from(rotation=(1.1, 0.2, 0.7), eye=Vector((3.0, -6.0, 4.0)))
    plane = plane_of(box)
    across, up, normal = axes_of(view)
    place = plane.point + across * 0.3 - up * 0.7
    eye = Vector((3.0, -6.0, 4.0))
    met = plane.meet(view, Ray(origin=eye, direction=(place - eye).normalized()))
    assert (met - place).length < 1e-5
    assert plane.meet(view, Ray(origin=eye, direction=-normal)) is None


def test_the_plane_goes_where_its_box_goes(box: bpy.types.Object) -> None:
    """At the same place within it."""
    plane = plane_of(box)
    plane.point = Vector((1.0, -1.0, 0.5))
    box.location, box.scale = (5.0, 0.0, 0.0), (2.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    plane.follow(Matrix(world_from_unit(box)))
    assert tuple(plane.point) == pytest.approx((7.0, -1.0, 0.5), abs=1e-5)
