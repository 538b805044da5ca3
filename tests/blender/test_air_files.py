# SPDX-License-Identifier: GPL-3.0-or-later
"""Air that is baked to a file, shown as a volume, and painted air that comes back from one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import painted_air
from addon.baked_air import baked_volume
from addon.painted_air import VOLUMES, read_volume, write_volume
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.small_scenes import add, empty_scene
from tyndall.air_tiles import VOLUME_KINDS
from tyndall.volumes import from_dense, grid_infos, read_vdb, to_dense, write_vdb

pytestmark = pytest.mark.dealt

RESOLUTION = (20, 16, 12)


@pytest.fixture
def box() -> Iterator[bpy.types.Object]:
    """The painted box of a scene: an Empty of 2 m, turned and stretched, with 20 x 16 x 12 voxels, and some paint."""
    scene = empty_scene()
    painted_air.forget()
    thing = add("Air", None, (1.0, 2.0, 3.0))
    thing.empty_display_type, thing.empty_display_size = "CUBE", 2.0
    thing.rotation_euler, thing.scale = (0.1, 0.2, 0.3), (1.0, 2.0, 0.5)
    thing.tyndall.painted_air.resolution = RESOLUTION
    scene.tyndall.heterogeneity.painted = thing
    scene.tyndall.heterogeneity.is_enabled = True
    bpy.context.view_layer.update()
    for seed, name in enumerate(("amount", "intensity")):
        kind = VOLUME_KINDS[name]
        values = np.full(RESOLUTION[::-1], kind.neutral, np.float32)
        values[3:9, :9, 10:] = np.random.default_rng(seed).uniform(kind.lowest, kind.highest, (6, 9, 10))
        write_volume(thing, name, values)
    return thing


def painted(thing: bpy.types.Object) -> dict[str, np.ndarray | None]:
    """From the tiles alone."""
    painted_air.forget()
    return {name: read_volume(thing, name) for name in VOLUMES}


def assert_same(one: dict[str, np.ndarray | None], other: dict[str, np.ndarray | None]) -> None:
    for name in VOLUMES:
        assert (one[name] is None) == (other[name] is None), name
        if one[name] is not None:
            np.testing.assert_array_equal(one[name], other[name])


def test_painted_air_comes_back_from_its_file(box: bpy.types.Object, tmp_path: Path) -> None:
    """Bit for bit, whatever was painted meanwhile, and at its own resolution."""
    path, before = str(tmp_path / "air.vdb"), painted(box)
    assert bpy.ops.tyndall.bake_air(filepath=path, voxels=24) == {"FINISHED"}
    assert [info.name for info in grid_infos(path)] == ["density", "amount", "level", "intensity"]
    box.tyndall.painted_air.resolution = (5, 6, 7)
    write_volume(box, "amount", None)
    write_volume(box, "level", np.full((7, 6, 5), 2.0, np.float32))
    assert bpy.ops.tyndall.load_painted_air(filepath=path) == {"FINISHED"}
    assert tuple(box.tyndall.painted_air.resolution) == RESOLUTION
    assert_same(painted(box), before)


def test_the_volume_that_shows_it_lies_in_the_box(box: bpy.types.Object, tmp_path: Path) -> None:
    """One volume, however often it is baked; what is baked anew is what it shows."""
    for name, voxels, sizes in (("a.vdb", 16, (8, 16, 4)), ("b.vdb", 32, (16, 32, 8))):
        path = tmp_path / name
        assert bpy.ops.tyndall.bake_air(filepath=str(path), voxels=voxels) == {"FINISHED"}
        bpy.context.view_layer.update()
        thing = baked_volume(box)
        assert [child.type for child in box.children] == ["VOLUME"]
        grid = thing.data.grids["density"]
        assert np.abs(np.diag(np.array(grid.matrix_object))[:3] - 4.0 / np.array(sizes)).max() < 1e-6
    infos = {info.name: info for info in grid_infos(path)}
    (first, last), matrix = infos["density"].bounds, infos["density"].local_from_index
    for index, corner in ((first, -2.0), (last, 2.0)):
        half_voxel = 0.5 * np.diag(matrix)[:3] * np.sign(corner)
        assert np.abs((matrix @ [*index, 1.0])[:3] + half_voxel - corner).max() < 1e-6
    assert np.abs(np.array(thing.matrix_world) - np.array(box.matrix_world)).max() < 1e-6


def test_the_volume_that_shows_it_is_no_medium_of_ours(box: bpy.types.Object, tmp_path: Path) -> None:
    """The texture of the air renders what it shows: it is left out without a report."""
    bpy.ops.tyndall.bake_air(filepath=str(tmp_path / "air.vdb"), voxels=8)
    assert baked_volume(box) is not None
    reports = Reports()
    description = SceneReader().read(bpy.context.evaluated_depsgraph_get(), reports, lambda: None)
    assert not description.instances
    assert not getattr(description, "volumes", ())
    assert not reports.lines()


def test_a_baked_volume_outlives_a_save(box: bpy.types.Object, tmp_path: Path) -> None:
    """By a path relative to the .blend, beside which it goes by itself; the next one beside the first."""
    blend = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    assert bpy.ops.tyndall.bake_air(voxels=8) == {"FINISHED"}
    assert bpy.ops.tyndall.bake_air(voxels=9) == {"FINISHED"}
    assert sorted(path.name for path in tmp_path.glob("*.vdb")) == ["scene_air.vdb", "scene_air_002.vdb"]
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.open_mainfile(filepath=blend)
    thing = baked_volume(bpy.data.objects["Air"])
    assert thing.data.filepath == "//scene_air_002.vdb"
    assert thing.data.grids.load()


def test_a_grid_from_elsewhere_is_resampled_and_clamped(box: bpy.types.Object, tmp_path: Path) -> None:
    """One voxel of 100 m holds all of the box; an amount of 7 is 1."""
    values = np.full((3, 3, 3), 7.0, np.float32)
    matrix = np.diag([100.0, 100.0, 100.0, 1.0])
    write_vdb(tmp_path / "other.vdb", [from_dense("amount", values, matrix, first_index=(-1, -1, -1))])
    before = painted(box)
    assert bpy.ops.tyndall.load_painted_air(filepath=str(tmp_path / "other.vdb")) == {"FINISHED"}
    after = painted(box)
    assert (after["amount"] == 1.0).all()
    assert after["amount"].shape == RESOLUTION[::-1]
    np.testing.assert_array_equal(after["intensity"], before["intensity"])


def test_loading_can_be_undone(box: bpy.types.Object, tmp_path: Path) -> None:
    path = str(tmp_path / "air.vdb")
    bpy.ops.tyndall.bake_air(filepath=path, voxels=8, shows=False)
    name = box.name
    write_volume(box, "amount", None)
    before = painted(box)
    bpy.ops.ed.undo_push(message="Cleared")
    bpy.ops.tyndall.load_painted_air(filepath=path)
    bpy.ops.ed.undo_push(message="Loaded")
    loaded = painted(bpy.data.objects[name])
    assert loaded["amount"] is not None
    bpy.ops.ed.undo()
    assert_same(painted(bpy.data.objects[name]), before)
    bpy.ops.ed.redo()
    assert_same(painted(bpy.data.objects[name]), loaded)


def test_what_cannot_be_written_or_read_is_named_and_changes_nothing(box: bpy.types.Object, tmp_path: Path) -> None:
    before = painted(box)
    with pytest.raises(RuntimeError, match=r"no such folder/air\.vdb: No such file or directory"):
        bpy.ops.tyndall.bake_air(filepath=str(tmp_path / "no such folder/air.vdb"), voxels=8)
    with pytest.raises(RuntimeError, match=r"missing\.vdb: No such file"):
        bpy.ops.tyndall.load_painted_air(filepath=str(tmp_path / "missing.vdb"))
    write_vdb(tmp_path / "smoke.vdb", [from_dense("smoke", np.ones((2, 2, 2), np.float32), np.eye(4))])
    match = r'smoke\.vdb: it has no grid "amount", "level" or "intensity"; it has "smoke"'
    with pytest.raises(RuntimeError, match=match):
        bpy.ops.tyndall.load_painted_air(filepath=str(tmp_path / "smoke.vdb"))
    bpy.ops.tyndall.bake_air(filepath=str(tmp_path / "air.vdb"), voxels=8, shows=False)
    (tmp_path / "broken.vdb").write_bytes((tmp_path / "air.vdb").read_bytes()[:-1000])
    with pytest.raises(RuntimeError, match=r"broken\.vdb: .*; write it again"):
        bpy.ops.tyndall.load_painted_air(filepath=str(tmp_path / "broken.vdb"))
    assert baked_volume(box) is None
    assert_same(painted(box), before)


def test_without_a_box_or_a_texture_there_is_nothing_to_bake(box: bpy.types.Object) -> None:
    bpy.context.scene.tyndall.heterogeneity.is_enabled = False
    assert not bpy.ops.tyndall.bake_air.poll()
    bpy.context.scene.tyndall.heterogeneity.is_enabled = True
    assert bpy.ops.tyndall.bake_air.poll()
    box.scale = (1.0, 0.0, 1.0)
    bpy.context.view_layer.update()
    assert not bpy.ops.tyndall.bake_air.poll()
    bpy.data.objects.remove(box)
    assert not bpy.ops.tyndall.bake_air.poll()
    assert not bpy.ops.tyndall.load_painted_air.poll()
    with pytest.raises(RuntimeError, match=r"poll\(\)"):
        bpy.ops.tyndall.load_painted_air(filepath="air.vdb")


def test_baked_air_is_the_air(box: bpy.types.Object, tmp_path: Path) -> None:
    """Even air, painted: its density is what is painted, where voxels agree."""
    bpy.context.scene.tyndall.heterogeneity.amount = 0.0
    bpy.context.scene.tyndall.heterogeneity.intensity = 0.5
    write_volume(box, "amount", None)
    box.scale = (5.0, 4.0, 3.0)
    bpy.context.view_layer.update()
    bpy.ops.tyndall.bake_air(filepath=str(tmp_path / "air.vdb"), voxels=20)
    density, _ = to_dense(read_vdb(tmp_path / "air.vdb", ["density"])["density"], ((0, 0, 0), RESOLUTION))
    expected = 0.5 * read_volume(box, "intensity").transpose(2, 1, 0)
    # The place of a voxel's centre in the unit cube is rounded to 24 bits, a slope of 1000 per voxel multiplies it.
    assert np.abs(density - expected).max() < 1000 * 20 * 2**-22
