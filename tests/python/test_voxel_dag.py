# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as voxels, from Python: counts that a closed form knows, the same voxels by every way, and what is refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import tyndall
from tyndall.voxel_dag import Config, VoxelDag, voxelize

CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
#: Two triangles per face, by the corners of CUBE.
CUBE_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
CUBE_TRIANGLES = np.array([corners for a, b, c, d in CUBE_FACES for corners in ((a, b, c), (a, c, d))])


def soup(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles anywhere, of any size."""
    random = np.random.default_rng(seed)
    middles = random.uniform(-3, 3, (count, 1, 3))
    corners = middles + random.normal(size=(count, 3, 3)) * np.exp(random.normal(size=(count, 1, 1)) - 1.5)
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def all_of(dag: VoxelDag) -> np.ndarray:
    parts = list(dag.coordinates())
    return np.concatenate(parts) if parts else np.zeros((0, 3), np.uint32)


def morton(voxels: np.ndarray) -> np.ndarray:
    codes = np.zeros(len(voxels), np.uint64)
    for bit in range(17):
        for axis in range(3):
            codes |= (voxels[:, axis].astype(np.uint64) >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return codes


@pytest.mark.parametrize("resolution", [4, 16, 64, 256])
def test_a_cube_that_fills_the_bounds_is_a_shell_of_one_voxel(resolution: int) -> None:
    """What lies on an upper face belongs to the last voxels."""
    dag = voxelize(CUBE, CUBE_TRIANGLES, Config(resolution=resolution, rule="conservative"))
    voxels = all_of(dag)
    assert dag.resolution == resolution
    assert dag.voxel_count == len(voxels) == resolution**3 - (resolution - 2) ** 3
    assert ((voxels == 0) | (voxels == resolution - 1)).any(axis=1).all()


@pytest.mark.parametrize("rule", ["thin", "conservative"])
@pytest.mark.parametrize("symmetry", ["none", "reflections", "cube"])
def test_coordinates_are_what_is_contained_once_each_in_mortons_order(rule: str, symmetry: str) -> None:
    dag = voxelize(*soup(200, 1), Config(resolution=128, rule=rule, symmetry=symmetry))
    voxels = all_of(dag)
    assert dag.voxel_count == len(voxels) > 5_000
    assert (np.diff(morton(voxels).astype(np.int64)) > 0).all()
    assert dag.contains(voxels).all()
    asked = np.random.default_rng(2).integers(0, 128, (50_000, 3))
    is_set = np.zeros((128, 128, 128), bool)
    is_set[tuple(voxels.T)] = True
    assert np.array_equal(dag.contains(asked), is_set[tuple(asked.T)])


def test_every_symmetry_stores_the_same_voxels_in_fewer_nodes() -> None:
    mesh = soup(300, 3)
    dags = [voxelize(*mesh, Config(resolution=256, symmetry=symmetry)) for symmetry in ("none", "reflections", "cube")]
    assert np.array_equal(all_of(dags[0]), all_of(dags[1]))
    assert np.array_equal(all_of(dags[0]), all_of(dags[2]))
    assert dags[0].node_count > dags[1].node_count > dags[2].node_count
    assert dags[0].geometry_bytes > dags[2].geometry_bytes


def test_conservative_holds_thin_and_neither_depends_on_the_order_or_the_type_of_numbers() -> None:
    positions, triangles = soup(200, 4)
    positions = positions.astype(np.float32)
    bounds = [[-4, -4, -4], [4, 4, 4]]
    thin = voxelize(positions, triangles, Config(resolution=128, bounds_m=bounds))
    assert (
        voxelize(positions, triangles, Config(resolution=128, bounds_m=bounds, rule="conservative"))
        .contains(all_of(thin))
        .all()
    )
    again = voxelize(
        positions.astype(np.float64), triangles[::-1].astype(np.int64), Config(resolution=128, bounds_m=bounds)
    )
    assert np.array_equal(all_of(again), all_of(thin))


def test_a_mesh_outside_of_the_bounds_leaves_nothing_and_nothing_is_contained_beyond_them() -> None:
    nothing = voxelize(CUBE, CUBE_TRIANGLES, Config(resolution=16, bounds_m=[[5, 5, 5], [6, 6, 6]]))
    assert nothing.voxel_count == nothing.node_count == len(all_of(nothing)) == 0
    dag = voxelize(CUBE, CUBE_TRIANGLES, Config(resolution=16))
    assert dag.contains([[0, 0, 0], [16, 0, 0], [2**32 - 1, 0, 0]]).tolist() == [True, False, False]
    assert dag.contains(np.zeros((0, 3), np.uint32)).shape == (0,)


@pytest.mark.parametrize(
    ("changes", "culprit"),
    [
        ({"resolution": 100}, "100"),
        ({"resolution": 2**18}, "262144"),
        ({"resolution": -4}, "-4"),
        ({"resolution": 64.0}, "64.0"),
        ({"rule": "fat"}, "fat"),
        ({"symmetry": "all"}, "all"),
        ({"bounds_m": [[0, 0, 0], [1, 2, 1]]}, "not those of a cube"),
        ({"bounds_m": [[0, 0, 0], [0, 0, 0]]}, "not those of a cube"),
        ({"bounds_m": [[0, 0, np.nan], [1, 1, 1]]}, "not two corners"),
        ({"memory_budget_bytes": 100}, "budget"),
    ],
)
def test_a_wrong_setting_is_named(changes: dict[str, object], culprit: str) -> None:
    with pytest.raises(tyndall.InvalidInput, match=culprit):
        voxelize(CUBE, CUBE_TRIANGLES, Config(**{"resolution": 64} | changes))


def test_a_wrong_mesh_is_named() -> None:
    config = Config(resolution=64)
    damaged = CUBE.copy()
    damaged[5, 1] = np.nan
    with pytest.raises(tyndall.InvalidInput, match="5"):
        voxelize(damaged, CUBE_TRIANGLES, config)
    with pytest.raises(tyndall.InvalidInput, match="triangle 3"):
        voxelize(CUBE, np.where(np.arange(12)[:, None] == 3, 8, CUBE_TRIANGLES), config)
    with pytest.raises(tyndall.InvalidInput, match="row 0"):
        voxelize(CUBE, CUBE_TRIANGLES - 1, config)
    with pytest.raises(tyndall.InvalidInput, match="shape"):
        voxelize(CUBE[:, :2], CUBE_TRIANGLES, config)
    with pytest.raises(tyndall.InvalidInput, match="whole numbers"):
        voxelize(CUBE, CUBE_TRIANGLES.astype(float), config)


def test_a_mesh_without_triangles_is_refused() -> None:
    for bounds in (None, [[0, 0, 0], [1, 1, 1]]):
        with pytest.raises(tyndall.InvalidInput, match="no triangles"):
            voxelize(CUBE, [], Config(resolution=64, bounds_m=bounds))


def test_a_cancelled_call_stops() -> None:
    progress = tyndall.Progress()
    progress.cancel()
    with pytest.raises(tyndall.Cancelled):
        voxelize(*soup(1000, 5), Config(resolution=1024), progress)
