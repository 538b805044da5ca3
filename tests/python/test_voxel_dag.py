# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as voxels, from Python: counts that a closed form knows, the same voxels by every way, and what is refused."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import tyndall
from support.full_disk import largest_file
from tyndall.voxel_dag import Config, VoxelDag, from_coordinates, load, voxelize

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


@pytest.mark.parametrize("resolution", [4, 8, 64, 131072])
def test_voxels_in_any_order_come_back_in_mortons(resolution: int) -> None:
    voxels = np.random.default_rng(resolution).integers(0, resolution, (3000, 3))
    dag = from_coordinates(np.concatenate([voxels, voxels[:500]]), Config(resolution=resolution))
    wanted = np.unique(voxels, axis=0)
    assert dag.voxel_count == len(wanted)
    assert np.array_equal(all_of(dag), wanted[np.argsort(morton(wanted))])
    distance_m, voxel, normal = dag.trace(wanted[:1] + 0.5, [[0, 0, 1]])
    assert (distance_m[0], voxel[0].tolist(), normal[0].tolist()) == (0.0, wanted[0].tolist(), [0, 0, 0])
    for wrong, culprit in ((resolution, str(resolution)), (-1, "-1")):
        with pytest.raises(tyndall.InvalidInput, match=culprit):
            from_coordinates([[0, wrong, 0]], Config(resolution=resolution))


def test_voxels_of_a_mesh_and_the_same_by_their_coordinates_are_one_file(tmp_path: Path) -> None:
    config = Config(resolution=128, bounds_m=[[-4, -4, -4], [4, 4, 4]])
    dag = voxelize(*soup(200, 11), config)
    from_coordinates(all_of(dag)[::-1], config).save(tmp_path / "a.tdag")
    dag.save(tmp_path / "b.tdag")
    assert (tmp_path / "a.tdag").read_bytes() == (tmp_path / "b.tdag").read_bytes()


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


def test_a_budget_that_does_not_suffice_says_what_would_fit() -> None:
    mesh = soup(50, 10)
    with pytest.raises(tyndall.InvalidInput, match=r"a resolution of (\d+) would fit") as refusal:
        voxelize(*mesh, Config(resolution=4096, memory_budget_bytes=1 << 21))
    fitting = int(str(refusal.value).split("a resolution of ")[2].split()[0])
    assert voxelize(*mesh, Config(resolution=fitting)).voxel_count > 0
    assert 64 <= fitting < 4096


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


def first_voxels(is_set: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Distances by asking each voxel: where the ray is within it along all three axes at once; inf where nowhere."""
    lower = np.argwhere(is_set)[None]
    with np.errstate(divide="ignore"):
        ends = np.stack([(lower + side - origins[:, None]) / directions[:, None] for side in (0, 1)])
    near, far = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
    entered = np.where((near < far) & (far > 0), np.maximum(near, 0), np.inf)
    return entered.min(axis=1)


def test_rays_meet_the_voxel_that_asking_each_one_finds() -> None:
    bounds = np.array([[-4.0, -4, -4], [4, 4, 4]])
    dag = voxelize(*soup(400, 6), Config(resolution=32, bounds_m=bounds))
    is_set = np.zeros((32, 32, 32), bool)
    is_set[tuple(all_of(dag).T)] = True
    random = np.random.default_rng(7)
    origins, directions = random.uniform(-6, 6, (400, 3)), random.normal(size=(400, 3))
    distance_m, voxels, normals = dag.trace(origins, directions)
    lengths = np.linalg.norm(directions, axis=1)
    wanted_m = first_voxels(is_set, (origins + 4) * 4, directions * 4) * lengths
    assert 0.2 < np.isfinite(wanted_m).mean() < 0.95
    np.testing.assert_allclose(distance_m, wanted_m, rtol=1e-12, atol=1e-12)
    is_hit = np.isfinite(distance_m)
    assert is_set[tuple(voxels[is_hit].T)].all()
    began_outside = is_hit & (distance_m > 0)
    assert np.array_equal(np.abs(normals[began_outside]).sum(axis=1), np.ones(began_outside.sum()))
    assert (np.einsum("ij,ij->i", normals[began_outside], directions[began_outside]) < 0).all()
    assert not normals[distance_m == 0].any()
    points = (origins + distance_m[:, None] * directions / lengths[:, None])[began_outside]
    face = ((points + 4) * 4 - voxels[began_outside] - 0.5) * np.abs(normals[began_outside])
    np.testing.assert_allclose(face, 0.5 * normals[began_outside], atol=1e-9)


def test_a_file_gives_everything_back(tmp_path: Path) -> None:
    mesh = soup(200, 8)
    dag = voxelize(*mesh, Config(resolution=256))
    dag.save(tmp_path / "a.tdag")
    again = load(tmp_path / "a.tdag")
    assert np.array_equal(all_of(again), all_of(dag))
    for name in ("resolution", "voxel_count", "node_count", "geometry_bytes"):
        assert getattr(again, name) == getattr(dag, name)
    assert np.array_equal(again.bounds_m, dag.bounds_m)
    np.testing.assert_allclose(dag.bounds_m[0], mesh[0].min(axis=0), rtol=1e-15)
    assert dag.bounds_m[1].max() - dag.bounds_m[0].max() <= np.ptp(mesh[0], axis=0).max() * (1 + 1e-15)
    assert (tmp_path / "a.tdag").stat().st_size < dag.geometry_bytes + 4096


def test_a_full_disk_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    path = tmp_path / "a.tdag"
    small, large = (voxelize(*soup(200, 9), Config(resolution=resolution)) for resolution in (16, 256))
    small.save(path)
    with largest_file(1 << 14), pytest.raises(tyndall.IoError, match=r"a\.tdag: .*room"):
        large.save(path)
    assert load(path).resolution == 16
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.tdag"]
    with pytest.raises(tyndall.IoError, match=r"missing\.tdag"):
        load(tmp_path / "missing.tdag")


def test_a_cancelled_call_stops() -> None:
    progress = tyndall.Progress()
    progress.cancel()
    with pytest.raises(tyndall.Cancelled):
        voxelize(*soup(1000, 5), Config(resolution=1024), progress)


def test_a_level_of_a_file_is_its_cubes_whether_they_lie_apart_or_not(tmp_path: Path) -> None:
    voxels = np.argwhere(np.linalg.norm(np.indices((128, 128, 128)) - 63.5, axis=0).round() == 60)
    dag = from_coordinates(voxels, Config(resolution=128))
    dag.save(tmp_path / "ball.tdag")
    for level in (2, 3, 6):  # the last one takes too much to lie apart
        coarse = load(tmp_path / "ball.tdag", level=level)
        assert coarse.resolution == 2**level
        cubes = {tuple(cube) for part in coarse.coordinates() for cube in part}
        assert cubes == {tuple(cube) for cube in voxels // 2 ** (7 - level)}
    with pytest.raises(tyndall.InvalidInput, match="level is 1"):
        load(tmp_path / "ball.tdag", level=1)
