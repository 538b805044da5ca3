# SPDX-License-Identifier: GPL-3.0-or-later
"""Picking on the picture: the constraint is where the ray is, and goes where the picked surface goes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from addon import constraint_markers
from addon.engine.view_rays import frame_size_px, place_in_frame
from addon.shader_nodes import use_nodes
from addon.surface_points import anchor_of, follow
from addon.sync.images import ImageReader
from addon.sync.reports import Reports
from addon.sync.transfer_functions import read_transfer_functions
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, cube, empty_scene, light, mesh, plane

#: Of the frame: in the middle the cube, at its foot the floor, above them the sky.
CUBE, FLOOR, SKY = (0.53, 0.52), (0.5, 0.1), (0.5, 0.97)
RANGE_M = 20.0


@pytest.fixture
def function() -> bpy.types.NodeTree:
    """A cube on a floor in a fog box, seen from 8 m; the function's Y is the depth over 20 m."""
    scene = empty_scene(64)
    camera = scene.camera
    camera.data.type, camera.data.clip_end = "PERSP", 100.0
    camera.location, camera.rotation_euler = (1.0, -8.0, 2.0), (1.4, 0.0, 0.1)
    cube()
    plane(z=-1.0, half_side=15.0)
    light("SUN", (0, 0, 5)).rotation_euler = (0.6, 0.3, 0.0)
    bpy.context.view_layer.update()
    bpy.ops.tyndall.add_fog_box()
    bpy.ops.tyndall.transfer_function_new()
    tree = scene.tyndall.shafts.transfer_states[0].function
    axis = tree.tyndall.y
    axis.fits_range, axis.low_m, axis.high_m = False, 0.0, RANGE_M
    bpy.ops.tyndall.transfer_layer_add(kind="DIFFUSION")
    bpy.context.view_layer.update()
    return tree


def pick(place: tuple[float, float], object_name: str = "") -> Any:
    """The new constraint."""
    assert bpy.ops.tyndall.pick_constraint(place=place, object_name=object_name) == {"FINISHED"}
    tree = bpy.context.scene.tyndall.shafts.transfer_states[0].function
    layer = tree.tyndall.layers[0]
    return layer.constraints[layer.active_constraint]


def followed(constraint: Any) -> Vector:
    thing = constraint.tracked_object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return Vector(follow(anchor_of(constraint), thing).world_point)


def seen_at(point: Vector) -> tuple[float, float]:
    """Of the frame, and what a ray through it would pick."""
    across, up, _depth = world_to_camera_view(bpy.context.scene, bpy.context.scene.camera, point)
    return across, up


def depth_m(point: Vector) -> float:
    return -(bpy.context.scene.camera.matrix_world.inverted() @ point).z


def sent_points() -> list[tuple[float, float, float] | None]:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    (weighted,) = read_transfer_functions(bpy.context.scene, depsgraph, ImageReader(), Reports())
    return [constraint.point for constraint in weighted.function.layers[0].constraints]


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_a_ray_goes_through_its_pixel(function: bpy.types.NodeTree, kind: str) -> None:
    """Blender's own projection brings every point of the ray back to where it was picked."""
    camera = bpy.context.scene.camera.data
    camera.type, camera.ortho_scale, camera.shift_x = kind, 7.0, 0.2
    bpy.context.scene.render.resolution_x = 96
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    width_px, height_px = frame_size_px(bpy.context.scene)
    for across, up in ((0.5, 0.5), (0.1, 0.9), (0.8, 0.3)):
        ray = place_in_frame(depsgraph, (across * width_px, up * height_px)).ray()
        assert ray is not None
        origin, direction = ray
        for distance_m in (0.5, 20.0):
            assert seen_at(origin + direction * distance_m) == pytest.approx((across, up), abs=1e-4)


def test_a_constraint_is_where_its_ray_is(function: bpy.types.NodeTree) -> None:
    """Y is the depth of the surface over the range; X, the average visibility, is between shade and light."""
    constraint = pick(CUBE)
    point = followed(constraint)
    assert constraint.tracked_object == bpy.data.objects["Cube"]
    assert seen_at(point) == pytest.approx(CUBE, abs=1e-4)
    assert constraint.position[1] == pytest.approx(depth_m(point) / RANGE_M, abs=1e-4)
    assert 0.0 < constraint.position[0] <= 1.0


def test_the_sky_is_at_the_far_end_and_follows_nothing(function: bpy.types.NodeTree) -> None:
    """The fog box that the ray leaves has no surface."""
    constraint = pick(SKY)
    assert constraint.position[1] == 1.0
    assert (constraint.is_tracked, constraint.tracked_object) == (False, None)


def test_an_object_can_be_picked_behind_another(function: bpy.types.NodeTree) -> None:
    """By its name: the floor behind the cube. One that is not there is named."""
    constraint = pick(CUBE, "Plane")
    assert constraint.tracked_object == bpy.data.objects["Plane"]
    assert followed(constraint).z == pytest.approx(-1.0, abs=1e-5)
    with pytest.raises(RuntimeError, match='Object "Cube" has no surface there'):
        bpy.ops.tyndall.pick_constraint(place=FLOOR, object_name="Cube")


def test_a_fog_box_in_front_is_passed(function: bpy.types.NodeTree) -> None:
    """Seen from outside, too: it has no surface."""
    box = bpy.data.objects["Fog Box"]
    box.scale = (0.5, 0.4, 0.5)
    bpy.context.view_layer.update()
    constraint = pick(CUBE)
    assert constraint.tracked_object == bpy.data.objects["Cube"]


def test_a_picked_point_is_sent_as_a_point_of_the_scene(function: bpy.types.NodeTree) -> None:
    """In world space: the core finds its ray, in each frame anew."""
    point = followed(pick(FLOOR))
    (sent,) = sent_points()
    assert sent == pytest.approx(tuple(point), abs=1e-6)


def test_picks_return_where_they_were_placed_after_a_reload(function: bpy.types.NodeTree, tmp_path: Path) -> None:
    """Their surface points are the same, and their rays have the same parameters."""
    for place in (CUBE, FLOOR):
        pick(place)
    before = [tuple(constraint.position) for constraint in function.tyndall.layers[0].constraints]
    points = sent_points()
    path = str(tmp_path / "picked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert sent_points() == points
    again = [tuple(pick(seen_at(Vector(point))).position) for point in points]
    for one, other in zip(before, again, strict=True):
        assert one == pytest.approx(other, abs=1e-3)


def test_a_pick_follows_a_deformed_mesh(function: bpy.types.NodeTree) -> None:
    """A cube that a shape key doubles about its middle: the point is twice as far from there."""
    box = bpy.data.objects["Cube"]
    box.shape_key_add(name="Basis")
    key = box.shape_key_add(name="Large")
    key.value = 0.0
    for corner in key.data:
        corner.co *= 2.0
    bpy.context.view_layer.update()
    constraint = pick(CUBE)
    before = followed(constraint)
    key.value = 1.0
    bpy.context.view_layer.update()
    assert tuple(followed(constraint)) == pytest.approx(tuple(2.0 * before), abs=1e-5)
    assert sent_points()[0] == pytest.approx(tuple(2.0 * before), abs=1e-5)


def test_a_point_on_an_instance_follows_what_instances_it(function: bpy.types.NodeTree) -> None:
    """As a whole: of two that instance the same leaf, the one that was met."""
    twig = bpy.data.collections.new("Twig")
    twig.objects.link(bpy.data.objects.new("Leaf", mesh("Leaf", CUBE_CORNERS, CUBE_FACES)))
    for name, location in (("Near", (0.0, -3.0, 0.5)), ("Aside", (6.0, -3.0, 0.5))):
        empty = add(name, None, location)
        empty.instance_type, empty.instance_collection = "COLLECTION", twig
    bpy.context.view_layer.update()
    constraint = pick(CUBE)
    near = bpy.data.objects["Near"]
    assert constraint.tracked_object == near
    before = followed(constraint)
    assert seen_at(before) == pytest.approx(CUBE, abs=1e-4)
    near.location.z += 1.0
    bpy.context.view_layer.update()
    assert tuple(followed(constraint) - before) == pytest.approx((0.0, 0.0, 1.0), abs=1e-5)
    assert sent_points()[0] == pytest.approx(tuple(followed(constraint)), abs=1e-6)


def test_a_new_constraint_has_the_colour_of_the_active_one(function: bpy.types.NodeTree) -> None:
    """To pick several of a colour; the first is white."""
    assert tuple(pick(CUBE).colour) == (1.0, 1.0, 1.0, 1.0)
    function.tyndall.layers[0].constraints[0].colour = (1.0, 0.0, 0.0, 0.5)
    assert tuple(pick(FLOOR).colour) == (1.0, 0.0, 0.0, 0.5)


def test_a_pick_that_cannot_be_made_says_why(function: bpy.types.NodeTree) -> None:
    """No camera, no mask, no diffusion layer: nothing is added."""
    camera = bpy.context.scene.camera
    bpy.context.scene.camera = None
    with pytest.raises(RuntimeError, match="the scene has no camera"):
        bpy.ops.tyndall.pick_constraint(place=CUBE)
    bpy.context.scene.camera = camera
    function.tyndall.x.axis = "MASK"
    with pytest.raises(RuntimeError, match="its x axis has no mask image"):
        bpy.ops.tyndall.pick_constraint(place=CUBE)
    assert len(function.tyndall.layers[0].constraints) == 0
    function.tyndall.layers[0].kind = "SOLID"
    assert not bpy.ops.tyndall.pick_constraint.poll()


def test_a_pick_is_undone_and_redone(function: bpy.types.NodeTree) -> None:
    bpy.context.preferences.edit.use_global_undo = True
    pick(FLOOR)

    def state() -> list[tuple[Any, ...]]:
        layer = bpy.context.scene.tyndall.shafts.transfer_states[0].function.tyndall.layers[0]
        return [(one.name, tuple(one.position), one.tracked_object.name) for one in layer.constraints]

    before = state()
    bpy.ops.ed.undo_push(message="before")
    pick(CUBE)
    after = state()
    bpy.ops.ed.undo_push(message="pick")
    bpy.ops.ed.undo()
    assert state() == before
    bpy.ops.ed.redo()
    assert state() == after
    assert len(after) == 2


def test_markers_are_where_the_surfaces_are(function: bpy.types.NodeTree) -> None:
    """Of the active layer, and of what follows a surface; they are found anew when anything changes."""
    layer = function.tyndall.layers[0]
    pick(CUBE), pick(SKY)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    points = dict(constraint_markers.points_of(layer, depsgraph))
    assert list(points) == [0]
    assert points[0] == pytest.approx(tuple(followed(layer.constraints[0])), abs=1e-6)
    bpy.data.objects["Cube"].location.z += 1.0
    bpy.context.view_layer.update()
    moved = constraint_markers.points_of(layer, bpy.context.evaluated_depsgraph_get())
    assert Vector(moved[0]) - Vector(points[0]) == Vector((0.0, 0.0, 1.0))


def test_a_surface_with_glass_before_it_is_not_a_medium(function: bpy.types.NodeTree) -> None:
    """What has a surface is picked, whatever it is made of."""
    material = bpy.data.materials.new("Glass")
    use_nodes(material)
    bpy.data.objects["Cube"].data.materials.append(material)
    assert pick(CUBE).tracked_object == bpy.data.objects["Cube"]
