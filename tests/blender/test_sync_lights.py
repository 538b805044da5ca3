# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sync makes of lamps."""

from __future__ import annotations

import bpy
import pytest
from mathutils import Matrix

from support.small_scenes import (
    add,
    empty_scene,
    light,
    read,
)
from tyndall.scene_description import LightBody, LitKinds


def test_what_a_light_does_not_do() -> None:
    empty_scene()
    lamp = light("POINT", (0, 0, 2))
    lamp.visible_diffuse = False
    lamp.data.tyndall.scatters_in_media = False
    (described,) = read().lights
    assert described.lights_surfaces == LitKinds(diffuse=False, glossy=True, transmission=True)
    assert not described.scatters_in_media


# Seen to fail: a portal of a room was its brightest lamp.
def test_a_portal_is_no_light() -> None:
    empty_scene()
    portal = light("AREA", (0, 0, 2))
    portal.data.cycles.is_portal = True
    assert read().lights == ()
    portal.data.type = "POINT"  # of which Cycles does not look at the switch
    assert len(read().lights) == 1


def test_area_lights_have_their_shape_and_spread() -> None:
    empty_scene()
    lamp = light("AREA", (0, 0, 2), shape="ELLIPSE", size=2.0, size_y=0.5, spread=1.0)
    lamp.visible_camera = False
    description = read()
    (described,) = description.lights
    assert described.size_m == (2.0, 0.5)
    assert described.is_ellipse
    assert described.spread_rad == pytest.approx(1.0)
    assert not description.reports
    lamp.data.shape = "SQUARE"
    (described,) = read().lights
    assert described.size_m == (2.0, 2.0)
    assert not described.is_ellipse


def test_what_an_area_light_cannot_be_is_said_in_one_line() -> None:
    """Cameras would see it in Cycles, and a parent shears it. One without an area is left out."""
    empty_scene()
    lamp = light("AREA", (0, 0, 2))
    lamp.visible_camera = True
    parent = add("Parent", None)
    lamp.parent = parent
    lamp.matrix_parent_inverse = Matrix(((1, 0.5, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
    description = read()
    assert len(description.lights) == 1
    (line,) = description.reports
    assert line.startswith('Light "Area"')
    assert all(word in line for word in ("cameras", "shears"))
    lamp.data.size = 0.0
    description = read()
    assert not description.lights
    assert "no area" in description.reports[0]


def test_soft_falloff_is_the_disc_of_blender_3() -> None:
    empty_scene()
    lamp = light("POINT", (0, 0, 2))
    assert read().lights[0].body == LightBody.FACING_DISC
    if bpy.app.version >= (4, 1, 0):
        lamp.data.use_soft_falloff = False
        assert read().lights[0].body == LightBody.SPHERE


def test_instanced_lights_shine_each_from_its_place() -> None:
    empty_scene()
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    collection = bpy.data.collections.new("Street")
    collection.objects.link(lamp)
    for index in range(3):
        instancer = add(f"Post {index}", None, location=(index, 0, 0))
        instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
    assert sorted(described.world_from_light[0, 3] for described in read().lights) == [0, 1, 2]
