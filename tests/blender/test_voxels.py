# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels in Blender: what of a scene becomes them, the object that stands for them, and their files."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

import tyndall
from addon.sync.voxel_meshes import VoxelMesh
from support.small_scenes import CUBE_CORNERS, add, cube, mesh
from tyndall.blender.voxel_meshes import gather


@pytest.fixture
def bare(scene: bpy.types.Scene) -> bpy.types.Scene:
    """The factory scene without its cube."""
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    return scene


def gathered(*objects: bpy.types.Object) -> VoxelMesh:
    return gather(bpy.context.evaluated_depsgraph_get(), objects)


def corners_of(found: VoxelMesh) -> set[tuple[float, ...]]:
    """Of its triangles, to a micrometre."""
    return set(map(tuple, np.round(found.positions_m[found.triangles].reshape(-1, 3), 6).tolist()))


# What becomes voxels


def test_a_mesh_is_taken_where_it_stands(bare: bpy.types.Scene) -> None:
    """Rotated, scaled, moved; what is not chosen stays out."""
    box = cube()
    box.location, box.scale, box.rotation_euler = (1.0, 2.0, 3.0), (2.0, 1.0, 0.5), (0.0, 0.0, np.pi / 2)
    cube("Other").location = (100.0, 0.0, 0.0)
    found = gathered(box)
    assert found.positions_m.dtype == np.float64
    assert found.triangles.dtype == np.uint32
    assert len(found.triangles) == 12
    assert corners_of(found) == {(1.0 - y, 2.0 + 2.0 * x, 3.0 + 0.5 * z) for x, y, z in CUBE_CORNERS}


def test_modifiers_are_applied(bare: bpy.types.Scene) -> None:
    """What is seen, and not what is edited."""
    box = cube()
    array = box.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (2.0, 0.0, 0.0)
    found = gathered(box)
    assert len(found.triangles) == 36
    assert found.positions_m.max(axis=0).tolist() == pytest.approx([9.0, 1.0, 1.0])


def test_instances_are_applied(bare: bpy.types.Scene) -> None:
    """Of a collection, by an empty that is chosen; the hidden original is not."""
    box = cube("Part")
    part = bpy.data.collections.new("Part")
    part.objects.link(box)
    bpy.context.scene.collection.objects.unlink(box)
    places = [(10.0, 0.0, 0.0), (0.0, 10.0, 0.0)]
    for place in places:
        empty = add("Instance", None, place)
        empty.instance_type, empty.instance_collection = "COLLECTION", part
    empties = [thing for thing in bpy.context.scene.objects if thing.type == "EMPTY"]
    expected = {tuple(np.add(corner, place).tolist()) for corner in CUBE_CORNERS for place in places}
    assert corners_of(gathered(*empties)) == expected
    assert len(gathered(empties[0]).triangles) == 12


def test_a_curve_is_taken_once(bare: bpy.types.Scene) -> None:
    """As the mesh that it evaluates to; the depsgraph lists it twice."""
    bpy.ops.curve.primitive_bezier_circle_add()
    circle = bpy.context.object
    circle.data.bevel_depth = 0.1
    evaluated = circle.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    evaluated.calc_loop_triangles()
    assert len(gathered(circle).triangles) == len(evaluated.loop_triangles) > 100


def test_what_has_no_face_is_named(bare: bpy.types.Scene) -> None:
    """Nothing is chosen, or nothing of it has a surface."""
    with pytest.raises(tyndall.InvalidInput, match='nothing to voxelize: "Camera" has no face'):
        gathered(bpy.data.objects["Camera"])
    with pytest.raises(tyndall.InvalidInput, match="nothing to voxelize: no object"):
        gathered()


def test_a_vertex_that_is_not_finite_is_named(bare: bpy.types.Scene) -> None:
    """With its object: numbers of one long list of triangles would help nobody."""
    cube("Good")
    bad = add("Bad", mesh("Bad", [*CUBE_CORNERS[:3], (float("nan"), 0.0, 0.0)], [(0, 1, 2), (1, 2, 3)]))
    with pytest.raises(tyndall.InvalidInput, match='object "Bad": vertex 3 is at \\[nan'):
        gathered(bpy.data.objects["Good"], bad)
