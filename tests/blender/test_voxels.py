# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxelize to DAG: the object that stands for the voxels, their file, and what is said where it cannot be."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

import tyndall
from addon.operators.voxelize import _plan
from addon.voxel_boxes import file_of
from support.engine_pictures import tyndall_pixels
from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, cube, empty_scene, material, node, plane
from support.voxel_scenes import saved_block, select, voxels_in_world
from tyndall.voxel_dag import Config, extent_of, load, out_of_core, voxelize


@pytest.fixture
def saved(tmp_path: Path) -> bpy.types.Scene:
    return saved_block(tmp_path)


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


def test_voxels_keep_the_colours_and_normals_of_the_surface(saved: bpy.types.Scene) -> None:
    """Of each face its own; without them, the file has none."""
    block = bpy.data.objects["Block"]
    for colour in ((1, 0, 0, 1), (0, 0, 1, 1)):
        made = material("Paint", lambda new, _, c=colour: node(new, "ShaderNodeBsdfDiffuse", Color=c).outputs[0])
        block.data.materials.append(made)
    block.data.polygons[5].material_index = 1  # the top
    saved.tyndall.voxelize.has_normals = True
    bpy.ops.tyndall.voxelize()
    dag = load(file_of(bpy.context.object))
    middles = [[8, 8, 15], [8, 8, 0], [0, 8, 8], [15, 8, 8]]
    assert dag.colors_at(middles).tolist() == [[0, 0, 255], [255, 0, 0], [255, 0, 0], [255, 0, 0]]
    assert np.allclose(dag.normals_at(middles), [[0, 0, 1], [0, 0, -1], [-1, 0, 0], [1, 0, 0]], atol=0.02)
    saved.tyndall.voxelize.has_colors = saved.tyndall.voxelize.has_normals = False
    block.hide_set(False)
    select(block)
    bpy.ops.tyndall.voxelize()
    dag = load(file_of(bpy.context.object))
    assert not dag.has_colors
    assert not dag.has_normals
    assert [made.name for made in bpy.context.object.data.materials] == ["Paint"]


def test_coloured_voxels_look_as_what_they_stand_for(tmp_path: Path) -> None:
    """Their colours are those of the surface, and not multiplied by its material once more."""
    scene = empty_scene()
    paint = material("Paint", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.2, 0.4, 0.6, 1)).outputs[0])
    flat = plane(material=paint)
    sun = bpy.data.lights.new("Sun", "SUN")
    add("Sun", sun, location=(0, 0, 5))
    before = tyndall_pixels(scene)[..., :3]
    select(flat)
    scene.tyndall.voxelize.resolution, scene.tyndall.voxelize.path = "64", str(tmp_path / "flat.tdag")
    bpy.ops.tyndall.voxelize()
    assert before.min() > 0.05
    assert np.allclose(tyndall_pixels(scene)[..., :3], before, rtol=0.02)


def test_a_solid_is_filled(saved: bpy.types.Scene) -> None:
    """All of the cube; an open mesh is refused."""
    saved.tyndall.voxelize.is_solid = True
    bpy.ops.tyndall.voxelize()
    assert load(file_of(bpy.context.object)).voxel_count == 16**3
    flat = plane()
    select(flat)
    with pytest.raises(RuntimeError, match="edge"):
        bpy.ops.tyndall.voxelize()


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
    settings.resolution, settings.memory_budget_mib, settings.is_solid = "131072", 16, True
    with pytest.raises(RuntimeError, match=r"of which \d+ fit the budget: allow more memory or choose a smaller"):
        bpy.ops.tyndall.voxelize()
    settings.resolution, settings.memory_budget_mib, settings.is_solid = "16", 4096, False
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


@pytest.mark.dealt
def test_what_is_beyond_the_memory_is_made_in_parts(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """The same file, byte for byte; the parts are gone. A solid is refused, with what would fit."""
    settings = saved.tyndall.voxelize
    settings.resolution, settings.hides_sources = "1024", False
    files = []
    for budget_mib in (4096, 64):
        settings.memory_budget_mib = budget_mib
        select(bpy.data.objects["Block"])
        assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
        files.append(file_of(bpy.context.object))
    assert files[0].read_bytes() == files[1].read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "Block_Voxels.tdag",
        "Block_Voxels_002.tdag",
        "scene.blend",
    ]


@pytest.mark.parametrize("is_solid", [False, True])
@pytest.mark.parametrize(("budget_mib", "is_in_parts"), [(4096, False), (4, True)])
def test_the_dialog_says_how_it_is_made(
    saved: bpy.types.Scene, budget_mib: int, *, is_in_parts: bool, is_solid: bool
) -> None:
    """Before it begins."""
    settings = saved.tyndall.voxelize
    settings.is_solid = is_solid
    settings.resolution, settings.has_colors, settings.memory_budget_mib = "1024", False, budget_mib
    plan = _plan(extent_of(*cube_at_origin()), settings)
    assert plan.is_in_parts == is_in_parts
    assert ("in parts" in plan.says) == is_in_parts


def test_a_run_that_was_stopped_goes_on_from_its_parts(
    saved: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They lie beside where the file goes, under the same name as long as there is none."""
    settings = saved.tyndall.voxelize
    settings.resolution, settings.has_colors, settings.memory_budget_mib = "1024", False, 4
    select(bpy.data.objects["Block"])

    def stopped(native: object, _path: Path, progress: tyndall.Progress) -> None:
        native.make_part(0, progress)
        raise tyndall.Cancelled

    class Stopping:
        def __init__(self, native: object) -> None:
            self.finish = lambda path, progress: stopped(native, path, progress)

    whole = out_of_core.parts_of
    monkeypatch.setattr(out_of_core, "parts_of", lambda *given, **named: Stopping(whole(*given, **named)))
    assert bpy.ops.tyndall.voxelize() == {"CANCELLED"}
    (part,) = [path for path in tmp_path.rglob("*") if path.is_file() and path.name != "scene.blend"]
    time_ns = part.stat().st_mtime_ns
    monkeypatch.setattr(
        out_of_core,
        "parts_of",
        lambda *given, **named: (times.append(part.stat().st_mtime_ns), whole(*given, **named))[1],
    )
    times: list[int] = []
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    assert times == [time_ns]
    assert not part.exists()


def test_an_unsaved_file_asks_where_the_voxels_go(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Nobody would look for them in the folder that Blender was started in."""
    select(bpy.data.objects["Cube"])
    scene.tyndall.voxelize.resolution = "16"
    with pytest.raises(RuntimeError, match=r"Save the \.blend first, or choose a file"):
        bpy.ops.tyndall.voxelize()
    scene.tyndall.voxelize.path = str(tmp_path / "voxels.tdag")
    bpy.ops.tyndall.voxelize()
    assert bpy.context.object.tyndall_voxels.path == str(tmp_path / "voxels.tdag")
