# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids and arrays as voxels: those that a rule takes, where they lie, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tyndall
from tyndall.volumes import SparseGrid, from_dense, write_vdb
from tyndall.voxel_dag import Config, VoxelDag, from_array, from_coordinates, import_vdb


def all_of(dag: VoxelDag) -> np.ndarray:
    return np.concatenate([*dag.coordinates(), np.zeros((0, 3), np.uint32)])


def as_array(dag: VoxelDag, shape: tuple[int, ...]) -> np.ndarray:
    is_set = np.zeros(shape, bool)
    is_set[tuple(all_of(dag).T)] = True
    return is_set


def cubes(voxel_m: float, first_m: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    matrix = np.diag([voxel_m, voxel_m, voxel_m, 1.0])
    matrix[:3, 3] = first_m
    return matrix


def grid_of(
    values: np.ndarray, *, background: float = 0.0, first_index: tuple[int, int, int] = (0, 0, 0)
) -> SparseGrid:
    return from_dense("density", values, cubes(1.0), first_index=first_index, background=background)


@pytest.mark.parametrize("shape", [(1, 1, 1), (8, 8, 8), (9, 16, 7), (33, 5, 70), (2, 0, 3)])
def test_a_voxel_is_set_where_the_array_says_so(shape: tuple[int, ...]) -> None:
    random = np.random.default_rng(1)
    is_set = random.random(shape) < 0.3
    dag = from_array(is_set, voxel_size_m=0.25, lower_m=(1, 2, 3))
    assert np.array_equal(as_array(dag, shape), is_set)
    assert dag.voxel_count == is_set.sum()
    assert dag.resolution >= max(8, *shape)
    assert dag.resolution < 2 * max(8, *shape)
    assert np.array_equal(dag.bounds_m, [[1, 2, 3], np.array([1, 2, 3]) + dag.resolution * 0.25])


def test_a_threshold_takes_what_reaches_it_and_a_stack_of_slices_is_turned_by_a_view() -> None:
    random = np.random.default_rng(2)
    slices = random.integers(-1000, 1000, (11, 12, 13)).astype(np.int16)  # z, y, x, as scanners count
    slices[3, 4, 5] = 300
    dag = from_array(slices.transpose(2, 1, 0), threshold=300)
    assert dag.contains([[5, 4, 3]]).all()
    assert np.array_equal(as_array(dag, (13, 12, 11)), slices.T >= 300)
    values = random.random((4, 4, 4)).astype(np.float32)
    values[1, 2, 3] = np.nan
    assert not from_array(values, threshold=-1).contains([[1, 2, 3]])[0]
    assert from_array(values, threshold=-1).voxel_count == 63


def test_an_array_and_its_coordinates_are_one_file(tmp_path: Path) -> None:
    is_set = np.random.default_rng(3).random((64, 50, 64)) < 0.1
    from_array(is_set).save(tmp_path / "a.tdag")
    from_coordinates(np.argwhere(is_set), Config(resolution=64)).save(tmp_path / "b.tdag")
    assert (tmp_path / "a.tdag").read_bytes() == (tmp_path / "b.tdag").read_bytes()


def test_a_wrong_array_is_named() -> None:
    for values, changes, culprit in (
        (np.zeros((2, 2), bool), {}, r"shape \(2, 2\)"),
        (np.zeros((2, 2, 2)), {}, "give a threshold"),
        (np.array([[["a"]]]), {"threshold": 1}, "not numbers"),
        (np.zeros((1, 1, 140000), bool), {}, "131072"),
        (np.zeros((2, 2, 2), bool), {"voxel_size_m": 0}, "voxel_size_m"),
        (np.zeros((2, 2, 2), bool), {"lower_m": (0, np.nan, 0)}, "lower_m"),
        (np.zeros((2, 2, 2), bool), {"config": Config(symmetry="all")}, "all"),
        (np.zeros((2, 2, 2), bool), {"config": Config(colors=[[1, 2, 3]])}, "use from_coordinates"),
        (np.zeros((2, 2, 2), bool), {"colors": np.zeros((2, 2, 3), np.uint8)}, r"not \(2, 2, 2, 3\)"),
    ):
        with pytest.raises(tyndall.InvalidInput, match=culprit):
            from_array(values, **changes)


@pytest.mark.parametrize("first_index", [(0, 0, 0), (-13, 5, 1000)])
def test_dense_voxels_of_a_grid_lie_where_the_grid_has_them(tmp_path: Path, first_index: tuple[int, int, int]) -> None:
    random = np.random.default_rng(4)
    values = random.random((20, 30, 10)).astype(np.float32)
    values[3, 3, 3] = 0.75
    values[4, 4, 4] = np.nan
    grid = from_dense("fire", values, cubes(0.5, (10, -20, 30)), first_index=first_index)
    write_vdb(tmp_path / "a.vdb", [grid])
    dag = import_vdb(tmp_path / "a.vdb", threshold=0.75)
    lower_m = np.add(first_index, -0.5) * 0.5 + (10, -20, 30)  # of the array's first voxel
    moved = np.round((dag.bounds_m[0] - lower_m) / 0.5).astype(int)
    found = np.zeros(values.shape, bool)
    found[tuple((all_of(dag).astype(int) + moved).T)] = True
    with np.errstate(invalid="ignore"):
        assert np.array_equal(found, values >= 0.75)
    np.testing.assert_allclose(np.ptp(dag.bounds_m, axis=0), dag.resolution * 0.5)
    np.testing.assert_allclose((dag.bounds_m[0] - lower_m) / 0.5, moved, atol=1e-9)


def test_inside_is_what_is_not_above_0_and_surface_what_has_a_face_towards_the_rest(tmp_path: Path) -> None:
    centres = np.indices((40, 40, 40)).T - 19.5
    distance = (np.linalg.norm(centres, axis=-1) - 15.2).astype(np.float32)
    distance[20, 20, 39] = 0.0
    write_vdb(tmp_path / "a.vdb", [grid_of(np.clip(distance, -3, 3), background=3.0)])
    is_inside = distance <= 0
    inside = import_vdb(tmp_path / "a.vdb", "density", rule="inside")
    assert np.array_equal(as_array(inside, (64, 64, 64))[:40, :40, :40], is_inside)
    padded = np.pad(is_inside, 1)
    is_deep = is_inside.copy()
    for axis in range(3):
        for step in (-1, 1):
            is_deep &= np.roll(padded, step, axis)[1:-1, 1:-1, 1:-1]
    surface = import_vdb(tmp_path / "a.vdb", rule="surface")
    assert np.array_equal(as_array(surface, (64, 64, 64))[:40, :40, :40], is_inside & ~is_deep)
    assert 0 < surface.voxel_count < inside.voxel_count / 2
    thick = import_vdb(tmp_path / "a.vdb", rule="inside", threshold=-2)
    assert thick.voxel_count == (distance <= -2).sum()


def test_a_grid_without_voxels_by_the_rule_is_empty(tmp_path: Path) -> None:
    write_vdb(tmp_path / "a.vdb", [grid_of(np.full((8, 8, 8), 0.25))])
    assert import_vdb(tmp_path / "a.vdb").voxel_count == 0


def test_a_wrong_grid_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.vdb"
    write_vdb(path, [grid_of(np.ones((8, 8, 8)))])
    for changes, culprit in (
        ({"grid": "heat"}, r'no grid "heat"; it has: "density"'),
        ({"rule": "thin"}, "rule is 'thin'"),
        ({"rule": "inside"}, "all of space"),
        ({"threshold": np.inf}, "threshold is inf"),
        ({"threshold": -1.0}, "all of space"),
        ({"config": Config(memory_budget_bytes=100)}, "limit of"),
    ):
        with pytest.raises(tyndall.InvalidInput, match=culprit):
            import_vdb(path, **changes)
    far = np.array([[0, 0, 0], [1 << 17, 0, 0]], np.int32)
    turned = cubes(1.0)
    turned[:2, :2] = [[0, -1], [1, 0]]
    stretched = np.diag([1.0, 1.0, 1.1, 1.0])
    for grid, culprit in (
        (
            SparseGrid(
                name="far", leaf_origins=far, leaf_values=np.ones((2, 8, 8, 8), np.float32), local_from_index=cubes(1)
            ),
            "131080",
        ),
        (from_dense("turned", np.ones((8, 8, 8)), turned), '"turned": its voxels are turned'),
        (from_dense("stretched", np.ones((8, 8, 8)), stretched), '"stretched": its voxels are turned or no cubes'),
    ):
        write_vdb(path, [grid])
        with pytest.raises(tyndall.InvalidInput, match=culprit):
            import_vdb(path)
    write_vdb(path, [from_dense(name, np.ones((8, 8, 8)), cubes(1)) for name in ("a", "b")])
    with pytest.raises(tyndall.InvalidInput, match='say which grid to read; it has: "a", "b"'):
        import_vdb(path)
    assert import_vdb(path, "b").voxel_count == 512
    with pytest.raises(tyndall.IoError, match=r"missing\.vdb"):
        import_vdb(tmp_path / "missing.vdb")
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(tyndall.IoError, match=r"a\.vdb"):
        import_vdb(path, "b")
