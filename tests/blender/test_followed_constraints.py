# SPDX-License-Identifier: GPL-3.0-or-later
"""Constraints of a transfer function that follow a surface."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import pytest

from addon.surface_points import anchor_at
from support.transfer_scene import add_layers, read, sent


def track(function: bpy.types.NodeTree, thing: bpy.types.Object, local_point: tuple[float, float, float]) -> Any:
    """A constraint on the object's surface, as picking makes it."""
    add_layers("DIFFUSION")
    bpy.ops.tyndall.transfer_constraint_add()
    constraint = function.tyndall.layers[0].constraints[0]
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    is_found, point, _normal, polygon = evaluated.closest_point_on_mesh(local_point)
    assert is_found
    anchor = anchor_at(evaluated, polygon, point)
    constraint.is_tracked, constraint.tracked_object = True, thing
    constraint.triangle_index, constraint.triangle_count = anchor.triangle_index, anchor.triangle_count
    constraint.triangle_weights, constraint.local_point = anchor.weights, anchor.local_point
    return constraint


def followed() -> tuple[float, float, float] | None:
    return sent().layers[0].constraints[0].point


POINT = (0.3, -0.6, 1.0)


def test_a_constraint_follows_its_object(function: bpy.types.NodeTree) -> None:
    """Moved, turned and scaled: in world space."""
    box = bpy.data.objects["Cube"]
    track(function, box, POINT)
    assert followed() == pytest.approx(POINT, abs=1e-6)
    box.location, box.rotation_euler, box.scale = (1, 2, 3), (0.4, 0.5, 0.6), (1, 2, 0.5)
    bpy.context.view_layer.update()
    assert followed() == pytest.approx(
        tuple(box.matrix_world @ bpy.context.scene.cursor.location.__class__(POINT)), abs=1e-5
    )


def test_a_constraint_follows_a_deformed_surface(function: bpy.types.NodeTree) -> None:
    """A shape key pulls the top of the cube up by one metre on one side: the point rises by its share."""
    box = bpy.data.objects["Cube"]
    box.shape_key_add(name="Basis")
    key = box.shape_key_add(name="Tilt")
    for corner in key.data:
        if corner.co.z > 0.0 and corner.co.x > 0.0:
            corner.co.z += 1.0
    key.value = 0.0
    bpy.context.view_layer.update()
    track(function, box, POINT)
    key.value = 1.0
    bpy.context.view_layer.update()
    assert followed() == pytest.approx((0.3, -0.6, 1.0 + 0.65), abs=1e-5)
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=11)
    bpy.context.scene.frame_set(11)
    assert followed() == pytest.approx((0.3, -0.6, 1.65), abs=1e-5)


def test_a_subdivided_surface_holds_its_constraint_by_place(function: bpy.types.NodeTree) -> None:
    """The triangle is another one now: one line says so."""
    box = bpy.data.objects["Cube"]
    track(function, box, POINT)
    modifier = box.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type, modifier.levels, modifier.show_viewport = "SIMPLE", 1, True
    box.location.x = 5.0
    bpy.context.view_layer.update()
    ((weighted,), lines) = read()
    assert weighted.function.layers[0].constraints[0].point == pytest.approx((5.3, -0.6, 1.0), abs=1e-5)
    culprit = 'Transfer function "Transfer Function", layer "Diffusion", constraint "Colour"'
    assert lines == (f'{culprit}: object "Cube" has other triangles than when it was picked: followed by its place',)


def test_a_tracked_constraint_survives_save_and_reload(function: bpy.types.NodeTree, tmp_path: Path) -> None:
    track(function, bpy.data.objects["Cube"], POINT)
    path = str(tmp_path / "tracked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.data.objects["Cube"].location.z = 2.0
    bpy.context.view_layer.update()
    assert followed() == pytest.approx((0.3, -0.6, 3.0), abs=1e-6)


def _delete(thing: bpy.types.Object) -> None:
    bpy.data.objects.remove(thing)


def _unlink(thing: bpy.types.Object) -> None:
    bpy.context.scene.collection.objects.unlink(thing)


def _empty_mesh(thing: bpy.types.Object) -> None:
    thing.data.clear_geometry()


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (_delete, "its object is not set, or deleted"),
        (_unlink, 'its object "Cube" is not in the scene'),
        (_empty_mesh, 'its object "Cube" has no surface any more'),
    ],
)
def test_a_constraint_whose_surface_is_gone_stays_where_it_was_picked(
    function: bpy.types.NodeTree, damage: Callable[[bpy.types.Object], None], reason: str
) -> None:
    """One line names function, layer, constraint and culprit; the layer is used."""
    constraint = track(function, bpy.data.objects["Cube"], POINT)
    constraint.position = (0.25, 0.75)
    damage(bpy.data.objects["Cube"])
    bpy.context.view_layer.update()
    ((weighted,), lines) = read()
    (made,) = weighted.function.layers[0].constraints
    assert (made.position, made.point) == ((0.25, 0.75), None)
    culprit = 'Transfer function "Transfer Function", layer "Diffusion", constraint "Colour"'
    assert lines == (f"{culprit}: stays where it was picked: {reason}",)
