# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that stand for voxels: files that come in and go out, what the panel says of them, and their preview."""

from __future__ import annotations

import itertools
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Vector

from addon import panels
from addon.amounts import bytes_text
from addon.operators.voxel_files import TYNDALL_OT_import_tdag
from addon.voxel_boxes import file_of
from addon.voxel_preview import preview_of
from addon.voxel_reading import header_of
from support.recording_layout import drawn
from support.voxel_scenes import saved_block, voxels_in_world
from tyndall.volumes import grid_infos
from tyndall.voxel_dag import Config, from_coordinates, load


@pytest.fixture
def saved(tmp_path: Path) -> bpy.types.Scene:
    return saved_block(tmp_path)


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
    assert header_of(path).resolution == 64
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(RuntimeError, match=r"made\.tdag"):
        bpy.ops.tyndall.import_tdag(filepath=str(path))
    with pytest.raises(RuntimeError, match=r"made\.tdag"):
        bpy.ops.tyndall.reload_voxels()


@pytest.fixture
def two_voxels(saved: bpy.types.Scene, tmp_path: Path) -> bpy.types.Object:
    """Of 0.25 m, in opposite corners of a cube of 2 m; red and blue; turned and moved, with a material."""
    colors = np.array([[255, 0, 0], [0, 0, 255]], np.uint8)
    config = Config(resolution=8, bounds_m=[[0, 0, 0], [2, 2, 2]], colors=colors)
    from_coordinates([[0, 0, 0], [7, 7, 7]], config).save(tmp_path / "two.tdag")
    bpy.ops.tyndall.import_tdag(filepath=str(tmp_path / "two.tdag"))
    box = bpy.context.object
    box.location, box.rotation_euler = (1.0, 2.0, 3.0), (0.1, 0.2, 0.3)
    box.data.materials[0] = bpy.data.materials.new("Clay")
    bpy.context.view_layer.update()
    return box


@pytest.mark.parametrize(("level", "side_m"), [(3, 0.25), (2, 0.5), (17, 0.25)])
def test_voxels_become_a_mesh_where_they_are(two_voxels: bpy.types.Object, level: int, side_m: float) -> None:
    """Closed boxes with the box's material and their own colours; coarser ones fill their cubes."""
    assert bpy.ops.tyndall.voxels_to_mesh(level=level) == {"FINISHED"}
    thing = bpy.context.object
    corners = sorted(tuple(vertex.co) for vertex in thing.data.vertices)
    first, second = np.array(list(itertools.product((0.0, side_m), repeat=3))), 2.0 - side_m
    assert np.allclose(corners, sorted(map(tuple, [*first, *(first + second)])))
    assert np.allclose(thing.matrix_world, two_voxels.matrix_world)
    assert [material.name for material in thing.data.materials] == ["Clay"]
    assert len(thing.data.polygons) == 24
    assert not any(polygon.use_smooth for polygon in thing.data.polygons)
    assert not thing.data.validate()
    for polygon in thing.data.polygons:
        middle = np.mean(first, axis=0) + (second if polygon.center.x > 1.0 else 0.0)
        assert polygon.normal.dot(polygon.center - Vector(middle)) > 0.0
        colour = thing.data.color_attributes[0].data[polygon.loop_start].color
        assert tuple(colour) == ((0, 0, 1, 1) if polygon.center.x > 1.0 else (1, 0, 0, 1))


def test_a_smooth_mesh_is_one_of_openvdb(two_voxels: bpy.types.Object) -> None:
    """Rounded, around the same voxels."""
    assert bpy.ops.tyndall.voxels_to_mesh(kind="SMOOTH") == {"FINISHED"}
    data = bpy.context.object.data
    corners = np.array([vertex.co for vertex in data.vertices])
    assert len(corners) > 8
    assert all(polygon.use_smooth for polygon in data.polygons)
    assert (corners.min(axis=0) > -0.1).all()
    assert (corners.max(axis=0) < 2.1).all()
    assert not np.isin(corners, (0.0, 0.25, 1.75, 2.0)).all()


@pytest.mark.parametrize(("kind", "name"), [("FOG", "density"), ("LEVEL SET", "surface")])
def test_voxels_become_a_grid_of_openvdb(two_voxels: bpy.types.Object, tmp_path: Path, kind: str, name: str) -> None:
    """With their colours, beside their own file, unless another is named."""
    assert bpy.ops.tyndall.export_voxels_vdb(kind=kind) == {"FINISHED"}
    assert [info.name for info in grid_infos(tmp_path / "two.vdb")] == [name, "color"]
    bpy.ops.tyndall.export_voxels_vdb(kind=kind, filepath=str(tmp_path / "other"))
    assert (tmp_path / "other.vdb").is_file()


def test_a_magicavoxel_file_goes_out_and_comes_in(two_voxels: bpy.types.Object, tmp_path: Path) -> None:
    """With its colours; a damaged one is named, and no file is made of it."""
    assert bpy.ops.tyndall.export_voxels_vox() == {"FINISHED"}
    assert bpy.ops.tyndall.import_vox(filepath=str(tmp_path / "two.vox"), voxel_size_m=0.25) == {"FINISHED"}
    box = bpy.context.object
    assert box.tyndall_voxels.path == "//two_002.tdag"
    dag = load(file_of(box))
    voxels = np.concatenate(list(dag.coordinates()))
    assert dag.colors_at(voxels).tolist() == [[255, 0, 0], [0, 0, 255]]
    assert np.ptp(voxels_in_world(box), axis=0) == pytest.approx([2.0, 2.0, 2.0])
    (tmp_path / "two.vox").write_bytes((tmp_path / "two.vox").read_bytes()[:50])
    with pytest.raises(RuntimeError, match=r"two\.vox"):
        bpy.ops.tyndall.import_vox(filepath=str(tmp_path / "two.vox"))
    assert len(list(tmp_path.glob("*.tdag"))) == 2


# Panels and previews


def test_the_panel_says_what_a_file_holds(saved: bpy.types.Scene) -> None:
    """Voxels, nodes, bytes of the parts and all of them, against an octree and raw; a row for each level."""
    bpy.ops.tyndall.voxelize()
    dag = load(file_of(bpy.context.object))
    shown = " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_box))
    for text in ("Resolution 16", f"Voxels {dag.voxel_count:,}", f"Distinct nodes {dag.node_count}"):
        assert text in shown
    of_bytes = " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_bytes))
    assert f"All {bytes_text(dag.geometry_bytes + dag.attribute_bytes)}" in of_bytes
    of_levels = drawn(panels.voxels.TYNDALL_PT_voxel_levels)
    assert [of_levels[row] for row in (1, 4, 7)] == ["16", "8", "4"]
    octree = 4 * sum(level.tree_node_count for level in dag.levels())
    for name, ratio, shown in (
        ("An octree, 4 bytes per node", octree, " ".join(of_levels)),
        ("Raw, a bit per voxel of the cube", 16**3 / 8, of_bytes),
    ):
        assert f"{name} {ratio / dag.geometry_bytes:.3g} x" in shown.replace("  ", " ")


def test_the_panel_says_what_is_wrong_with_a_file(saved: bpy.types.Scene) -> None:
    """One that is gone is named."""
    bpy.ops.tyndall.voxelize()
    file_of(bpy.context.object).unlink()
    for panel in (panels.voxels.TYNDALL_PT_voxel_box, panels.voxels.TYNDALL_PT_voxel_bytes):
        assert "Block_Voxels.tdag" in " ".join(drawn(panel)).replace(" ", "")


def test_a_preview_reads_no_more_of_a_large_file_than_it_shows(saved: bpy.types.Scene, tmp_path: Path) -> None:
    """Where all behind the topmost levels is damaged, these are shown with their colours; finer ones are refused."""
    path = tmp_path / "noise.tdag"
    voxels = np.random.default_rng(3).integers(0, 256, (50_000, 3))
    dag = from_coordinates(voxels, Config(resolution=256, colors=voxels.astype(np.uint8)))
    dag.save(path)
    bpy.ops.tyndall.import_tdag(filepath=str(path))
    box = bpy.context.object
    content = bytearray(path.read_bytes())
    content[-200_000:] = bytes(200_000)
    path.write_bytes(content)
    box.tyndall_voxels.preview, box.tyndall_voxels.preview_level = "POINTS", 3
    found = preview_of(box)
    cubes, _level = dag.coarse_cubes(3, 10**6)
    assert len(found.parts_m[0]) == len(cubes) == 8**3
    assert np.array_equal(found.colours[0], dag.colors_at(cubes * 32, level=3))
    assert f"Voxels {dag.voxel_count:,}" in " ".join(drawn(panels.voxels.TYNDALL_PT_voxel_box))
    box.tyndall_voxels.preview_level = 7
    assert "noise.tdag" in str(preview_of(box))
    with pytest.raises(RuntimeError, match=r"noise\.tdag"):
        bpy.ops.tyndall.reload_voxels()


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


@pytest.mark.parametrize("style", ["POINTS", "BLOCKS"])
def test_a_preview_has_the_mean_colours_of_its_level(saved: bpy.types.Scene, tmp_path: Path, style: str) -> None:
    """Of red and blue in one cube, as light; green is alone in another one. Without colours it has the object's."""
    voxels = [[0, 0, 0], [1, 1, 0], [7, 7, 7]]
    colors = np.array([[255, 0, 0], [0, 0, 255], [0, 255, 0]], np.uint8)
    made = from_coordinates(voxels, Config(resolution=8, colors=colors))
    bare = from_coordinates(voxels, Config(resolution=8))
    for dag, name in ((made, "made.tdag"), (bare, "bare.tdag")):
        dag.save(tmp_path / name)
        bpy.ops.tyndall.import_tdag(filepath=str(tmp_path / name))
        box = bpy.context.object
        box.tyndall_voxels.preview, box.tyndall_voxels.preview_level = style, 2
        found = preview_of(box)
        assert (found.colours is None) == (dag is bare)
        for part_m, colours in zip(found.parts_m, found.colours or [], strict=dag is made):
            is_far = part_m.reshape(len(colours), -1).mean(axis=1) > 4.0
            assert is_far.tolist() == [False, True]
            assert np.abs(colours.astype(int) - [[188, 0, 188], [0, 255, 0]]).max() <= 1
