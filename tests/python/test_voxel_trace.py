# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through voxel DAGs: levels of detail, cones and occlusion, against asking each cube of voxels."""

from __future__ import annotations

import numpy as np
import pytest

import tyndall
from tyndall.voxel_dag import Config, VoxelDag, from_coordinates

RESOLUTION = 32
BOUNDS = [[-4.0, -4, -4], [4, 4, 4]]  # 4 voxels per metre


def sparse_dag() -> tuple[VoxelDag, np.ndarray]:
    voxels = np.unique(np.random.default_rng(1).integers(0, RESOLUTION, (800, 3)), axis=0)
    return from_coordinates(voxels, Config(resolution=RESOLUTION, bounds_m=BOUNDS)), voxels


def assorted_rays(count: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(2)
    return random.uniform(-6, 6, (count, 3)), random.normal(size=(count, 3)) * random.uniform(0.1, 10, (count, 1))


def entries_m(lower_m: np.ndarray, width_m: float, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Where rays, (k,), enter cubes, (n,): (k, n); infinite where they do not pass through the inside."""
    ways = directions / np.linalg.norm(directions, axis=1)[:, None]
    ends = np.stack([(lower_m[None] + side - origins[:, None]) / ways[:, None] for side in (0, width_m)])
    near, far = np.maximum(ends.min(axis=0).max(axis=-1), 0), ends.max(axis=0).min(axis=-1)
    return np.where(near < far, near, np.inf)


@pytest.mark.parametrize("level", [1, 2, 3, 4, 5])
def test_a_level_is_hit_where_its_cubes_have_any_voxel(level: int) -> None:
    dag, voxels = sparse_dag()
    origins, directions = assorted_rays(300)
    width = RESOLUTION >> level
    cubes = np.unique(voxels // width, axis=0) * width
    wanted_m = entries_m(cubes / 4 - 4, width / 4, origins, directions).min(axis=1)
    distance_m, voxel, normal = dag.trace(origins, directions, level)
    np.testing.assert_allclose(distance_m, wanted_m, rtol=1e-12, atol=1e-12)
    is_hit = np.isfinite(distance_m)
    assert 10 < is_hit.sum() < 290
    assert (voxel[is_hit][:, None] == cubes).all(axis=-1).any(axis=1).all()
    assert np.array_equal(np.abs(normal).sum(axis=1), is_hit & (distance_m > 0))


def test_the_finest_level_is_the_voxels_and_others_are_refused() -> None:
    dag, _ = sparse_dag()
    rays = assorted_rays(100)
    for ours, plain in zip(dag.trace(*rays, 5), dag.trace(*rays), strict=True):
        assert np.array_equal(ours, plain)
    for level in (0, 6, -1, 1.5):
        with pytest.raises(tyndall.InvalidInput, match=f"level is {level}"):
            dag.trace(*rays, level)


def test_a_cone_stops_at_the_first_cube_that_is_no_wider() -> None:
    dag, voxels = sparse_dag()
    origins, directions = assorted_rays(300)
    spread = np.random.default_rng(3).uniform(0, 0.6, 300)
    wanted_m = np.full(300, np.inf)
    is_open = np.ones((300, len(voxels)), bool)  # no cube around this voxel has been hit whole
    for width in (16, 8, 4, 2, 1):
        entry_m = entries_m(voxels // width * width / 4 - 4, width / 4, origins, directions)
        ends = is_open & ((width / 4 <= spread[:, None] * entry_m) | (width == 1)) & np.isfinite(entry_m)
        wanted_m = np.minimum(wanted_m, np.where(ends, entry_m, np.inf).min(axis=1))
        is_open &= ~ends
    distance_m, _, _ = dag.trace(origins, directions, spread=spread)
    np.testing.assert_allclose(distance_m, wanted_m, rtol=1e-12, atol=1e-12)
    assert (distance_m < dag.trace(origins, directions)[0]).sum() > 10
    one = dag.trace(origins, directions, spread=0.3)
    for ours, same in zip(one, dag.trace(origins, directions, spread=np.full(300, 0.3)), strict=True):
        assert np.array_equal(ours, same)


def test_what_begins_before_the_end_occludes() -> None:
    dag, _ = sparse_dag()
    origins, directions = assorted_rays(500)
    distance_m = dag.trace(origins, directions)[0]
    assert np.array_equal(dag.occluded(origins, directions), np.isfinite(distance_m))
    for end_m in (3.0, np.random.default_rng(4).uniform(0, 12, 500)):
        is_occluded = dag.occluded(origins, directions, end_m)
        assert np.array_equal(is_occluded, distance_m < end_m)
        assert 0 < is_occluded.sum() < np.isfinite(distance_m).sum()
    for wrong in (np.zeros(3), "far"):
        with pytest.raises(tyndall.InvalidInput, match="end_m"):
            dag.occluded(origins, directions, wrong)
    assert dag.occluded(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)


def test_normals_of_a_sphere_that_rays_hit_look_back_along_them() -> None:
    at = np.stack(np.meshgrid(*[np.arange(64)] * 3, indexing="ij"), -1).reshape(-1, 3)
    voxels = at[np.abs(np.linalg.norm(at + 0.5 - 32, axis=1) - 24) < 0.7]
    dag = from_coordinates(voxels, Config(resolution=64))
    origins = np.random.default_rng(5).normal(size=(500, 3))
    origins = 32 + 60 * origins / np.linalg.norm(origins, axis=1)[:, None]
    _, voxel, _ = dag.trace(origins, 32 - origins)
    outward = voxel + 0.5 - 32
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    normals = dag.smooth_normals(voxel, 4, 32 - origins)
    assert normals.dtype == np.float32
    degrees = np.degrees(np.arccos(np.clip((normals * outward).sum(axis=1), -1, 1)))
    assert degrees.max() < 11
    assert degrees.mean() < 4
    assert np.array_equal(np.abs(dag.smooth_normals(voxel, 4)), np.abs(normals))
    assert not dag.smooth_normals([[0, 0, 0]]).any()
    for radius in (0, 17):
        with pytest.raises(tyndall.InvalidInput, match=f"radius is {radius}"):
            dag.smooth_normals(voxel, radius)
    with pytest.raises(tyndall.InvalidInput, match="500 coordinates, but 2 directions"):
        dag.smooth_normals(voxel, 4, [[1, 0, 0], [0, 1, 0]])
