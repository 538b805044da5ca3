# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels in Blender: what of a scene becomes them, the object that stands for them, and their files."""

from __future__ import annotations

import itertools
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Vector

import tyndall
from addon import panels
from addon.operators.voxel_files import TYNDALL_OT_import_tdag
from addon.sync.voxel_meshes import VoxelMesh
from addon.voxel_boxes import file_of
from addon.voxel_preview import preview_of
from addon.voxel_reading import counts_of
from support.recording_layout import drawn
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, cube, mesh
from tyndall.blender.voxel_meshes import gather
from tyndall.voxel_dag import Config, from_coordinates, load, voxelize


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


# The operator


@pytest.fixture
def saved(bare: bpy.types.Scene, tmp_path: Path) -> bpy.types.Scene:
    """A file on disk, with a cube of 2 m that is selected, and small voxels."""
    box = cube("Block")
    box.location = (5.0, 0.0, 0.0)
    select(box)
    bare.tyndall.voxelize.resolution = "16"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    return bpy.context.scene


def select(*things: bpy.types.Object) -> None:
    bpy.context.view_layer.update()  # which still lists what was removed
    for other in bpy.context.view_layer.objects:
        other.select_set(other in things)
    bpy.context.view_layer.objects.active = things[0] if things else None


def voxels_in_world(box: bpy.types.Object) -> np.ndarray:
    """Lower and upper corner of all its voxels, (2, 3)."""
    dag = load(file_of(box))
    found = np.concatenate(list(dag.coordinates()))
    size_m = (dag.bounds_m[1] - dag.bounds_m[0]) / dag.resolution
    ends = dag.bounds_m[0] + np.array([found.min(axis=0), found.max(axis=0) + 1]) * size_m
    return np.array([box.matrix_world @ Vector(end) for end in ends])


@pytest.mark.parametrize("rule", ["THIN", "CONSERVATIVE"])
def test_an_object_stands_for_the_voxels_where_the_mesh_was(saved: bpy.types.Scene, rule: str) -> None:
    """Its box is the file's cube; the path is relative; the mesh is hidden, and the new object is active."""
    saved.tyndall.voxelize.rule = rule
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    box = bpy.context.object
    assert box.name == "Block Voxels"
    assert box.tyndall_voxels.path == "//Block_Voxels.tdag"
    assert np.allclose(voxels_in_world(box), [(4.0, -1.0, -1.0), (6.0, 1.0, 1.0)])
    assert np.allclose(sorted(map(tuple, (box.matrix_world @ v.co for v in box.data.vertices))), expected_corners())
    assert len(box.data.edges) == 12
    assert len(box.data.polygons) == 0
    source = bpy.data.objects["Block"]
    assert source.hide_get()
    assert source.hide_render
    dag = load(file_of(box))
    expected = voxelize(*cube_at_origin(), Config(resolution=16, rule=rule.lower()))
    assert np.array_equal(np.concatenate(list(dag.coordinates())), np.concatenate(list(expected.coordinates())))


def expected_corners() -> list[tuple[float, ...]]:
    return sorted((5.0 + x, float(y), float(z)) for x, y, z in CUBE_CORNERS)


def cube_at_origin() -> tuple[np.ndarray, np.ndarray]:
    triangles = [corners for a, b, c, d in CUBE_FACES for corners in ((a, b, c), (a, c, d))]
    return np.array(CUBE_CORNERS, float), np.array(triangles)


def test_a_collection_becomes_voxels_together(saved: bpy.types.Scene) -> None:
    """Whatever is selected; around the middle of all of it."""
    both = bpy.data.collections.new("Both")
    saved.collection.children.link(both)
    other = cube("Other")
    other.location = (-5.0, 0.0, 0.0)
    for thing in (bpy.data.objects["Block"], other):
        both.objects.link(thing)
    select()
    saved.tyndall.voxelize.collection = both
    saved.tyndall.voxelize.hides_sources = False
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    box = bpy.context.object
    assert box.name == "Both Voxels"
    assert tuple(box.location) == (0.0, 0.0, 0.0)
    assert np.allclose(voxels_in_world(box), [(-6.0, -1.0, -1.0), (6.75, 1.25, 1.25)], atol=0.76)
    assert not other.hide_get()


def test_files_are_not_written_over_unless_one_is_chosen(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """A second run gets a number; a chosen path is taken, with the suffix that it lacks."""
    saved.tyndall.voxelize.hides_sources = False
    for _ in range(2):
        select(bpy.data.objects["Block"])
        bpy.ops.tyndall.voxelize()
    saved.tyndall.voxelize.path = "//chosen"
    for _ in range(2):
        select(bpy.data.objects["Block"])
        bpy.ops.tyndall.voxelize()
    names = {"Block_Voxels.tdag", "Block_Voxels_002.tdag", "chosen.tdag"}
    assert {path.name for path in tmp_path.glob("*.tdag")} == names


def test_what_cannot_be_done_is_said_and_nothing_is_left(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """Nothing selected, nothing with faces, vertices without end, no room, no folder."""
    settings = saved.tyndall.voxelize
    things = len(bpy.data.objects)
    select()
    with pytest.raises(RuntimeError, match="Select what becomes voxels"):
        bpy.ops.tyndall.voxelize()
    select(bpy.data.objects["Camera"])
    with pytest.raises(RuntimeError, match='"Camera" has no face'):
        bpy.ops.tyndall.voxelize()
    block = bpy.data.objects["Block"]
    select(block)
    settings.resolution, settings.memory_budget_mib = "131072", 16
    with pytest.raises(RuntimeError, match=r"the budget is 16 MiB; this would fit: Resolution \d+"):
        bpy.ops.tyndall.voxelize()
    settings.resolution, settings.memory_budget_mib = "16", 4096
    (tmp_path / "taken").write_text("a file, and no folder")
    settings.path = "//taken/voxels.tdag"
    with pytest.raises(RuntimeError, match=r"taken: no folder to write to \(File exists\)"):
        bpy.ops.tyndall.voxelize()
    settings.path = ""
    corners = np.array(CUBE_CORNERS, np.float32)
    corners[2, 0] = np.nan
    block.data.vertices.foreach_set("co", corners.ravel())
    block.data.update()
    with pytest.raises(RuntimeError, match='object "Block": vertex 2'):
        bpy.ops.tyndall.voxelize()
    assert not list(tmp_path.glob("*.tdag"))
    assert len(bpy.data.objects) == things


def test_an_unsaved_file_asks_where_the_voxels_go(bare: bpy.types.Scene, tmp_path: Path) -> None:
    """Nobody would look for them in the folder that Blender was started in."""
    select(cube())
    bare.tyndall.voxelize.resolution = "16"
    with pytest.raises(RuntimeError, match=r"Save the \.blend first, or choose a file"):
        bpy.ops.tyndall.voxelize()
    bare.tyndall.voxelize.path = str(tmp_path / "voxels.tdag")
    bpy.ops.tyndall.voxelize()
    assert bpy.context.object.tyndall_voxels.path == str(tmp_path / "voxels.tdag")


# Files


def proposed_import() -> Path:
    """What the file browser begins with."""
    return TYNDALL_OT_import_tdag.default_path(None, bpy.context)


def test_a_file_is_imported_and_read_anew(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """An object with the file's cube; after the file has changed, with its new one. A damaged file is named."""
    path = tmp_path / "made.tdag"
    assert proposed_import() == tmp_path / "voxels.tdag"
    voxels = [[0, 0, 0], [15, 15, 15]]
    from_coordinates(voxels, Config(resolution=16, bounds_m=[[1, 2, 3], [2, 3, 4]])).save(path)
    assert proposed_import() == path
    assert bpy.ops.tyndall.import_tdag(filepath=str(path)) == {"FINISHED"}
    box = bpy.context.object
    assert (box.name, box.tyndall_voxels.path) == ("made", "//made.tdag")
    assert np.allclose(voxels_in_world(box), [(1, 2, 3), (2, 3, 4)])
    from_coordinates(voxels, Config(resolution=64, bounds_m=[[0, 0, 0], [8, 8, 8]])).save(path)
    assert bpy.ops.tyndall.reload_voxels() == {"FINISHED"}
    assert np.allclose(sorted(tuple(v.co) for v in box.data.vertices), sorted(itertools.product((0, 8), repeat=3)))
    assert counts_of(path).resolution == 64
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(RuntimeError, match=r"made\.tdag"):
        bpy.ops.tyndall.import_tdag(filepath=str(path))
    with pytest.raises(RuntimeError, match=r"made\.tdag"):
        bpy.ops.tyndall.reload_voxels()


# Panels and previews


def test_the_panel_says_what_a_file_holds(saved: bpy.types.Scene) -> None:
    """Voxels, nodes, bytes of the parts and all of them, against an octree and raw; a row for each level."""
    bpy.ops.tyndall.voxelize()
    dag = load(file_of(bpy.context.object))
    shown = " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_box))
    for text in ("Resolution 16", f"Voxels {dag.voxel_count:,}", f"Distinct nodes {dag.node_count}"):
        assert text in shown
    shown = " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_bytes))
    octree = 4 * sum(level.tree_node_count for level in dag.levels())
    for name, ratio in (("An octree, 4 bytes per node", octree), ("Raw, a bit per voxel of the cube", 16**3 / 8)):
        assert f"{name} {ratio / dag.geometry_bytes:.3g} x" in shown.replace("  ", " ")
    assert f"All {dag.geometry_bytes} B" in shown
    shown = drawn(panels.voxels.TYNDALL_PT_voxel_levels)
    assert [shown[row] for row in (1, 4, 7)] == ["16", "8", "4"]


def test_the_panel_says_what_is_wrong_with_a_file(saved: bpy.types.Scene) -> None:
    """One that is gone is named."""
    bpy.ops.tyndall.voxelize()
    file_of(bpy.context.object).unlink()
    for panel in (panels.voxels.TYNDALL_PT_voxel_box, panels.voxels.TYNDALL_PT_voxel_bytes):
        assert "Block_Voxels.tdag" in " ".join(drawn(panel)).replace(" ", "")


@pytest.mark.parametrize("style", ["POINTS", "BLOCKS"])
def test_a_preview_lies_where_the_voxels_lie(saved: bpy.types.Scene, style: str) -> None:
    """Points in the middle of voxels, blocks to their ends; as coarse as asked."""
    bpy.ops.tyndall.voxelize()
    box = bpy.context.object
    box.tyndall_voxels.preview, box.tyndall_voxels.preview_level = style, 3
    found = preview_of(box)
    corners = np.concatenate([part.reshape(-1, 3) for part in found.parts_m])
    inset = 0.125 if style == "POINTS" else 0.0
    assert np.allclose([corners.min(axis=0), corners.max(axis=0)], [[-1 + inset] * 3, [1 - inset] * 3])
    if style == "POINTS":
        assert len(corners) == 8**3 - 6**3
    else:
        assert [len(part) for part in found.parts_m] == [8 * 8 + 6 * 6] * 6
