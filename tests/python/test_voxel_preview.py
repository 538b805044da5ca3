# SPDX-License-Identifier: GPL-3.0-or-later
"""What is shown and said of voxels before they are made or drawn: estimates, counts by level, coarse pictures."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import tyndall
from tyndall.voxel_dag import (
    Config,
    VoxelDag,
    estimate,
    exposed_faces,
    extent_of,
    from_coordinates,
    largest_that_fits,
    voxelize,
)


def torus(rings: int = 128, major_m: float = 2.0, minor_m: float = 0.75) -> tuple[np.ndarray, np.ndarray]:
    """A closed surface whose normals lean every way."""
    turn = np.linspace(0.0, 2.0 * np.pi, rings, endpoint=False)
    around, across = np.meshgrid(turn, turn, indexing="ij")
    reach = major_m + minor_m * np.cos(across)
    positions = np.stack([reach * np.cos(around), reach * np.sin(around), minor_m * np.sin(across)], -1).reshape(-1, 3)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(rings), np.arange(rings), indexing="ij"))
    corners = [((i + di) % rings) * rings + (j + dj) % rings for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
    a, b, c, d = corners
    return positions, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])


def scattered(seed: int, count: int = 3000, resolution: int = 64) -> tuple[np.ndarray, VoxelDag]:
    voxels = np.random.default_rng(seed).integers(0, resolution, (count, 3), dtype=np.uint32)
    return voxels, from_coordinates(voxels, Config(resolution=resolution))


# Estimates


@pytest.mark.parametrize("rule", ["thin", "conservative"])
@pytest.mark.parametrize("resolution", [128, 512])
def test_an_estimate_of_a_smooth_surface_is_close(rule: str, resolution: int) -> None:
    """A thin surface has one voxel per column of its main axis: areas say how many. The other rule has rims, too."""
    mesh = torus()
    config = Config(resolution=resolution, rule=rule)
    found = estimate(extent_of(*mesh), config)
    dag = voxelize(*mesh, config)
    assert found.voxel_count == pytest.approx(dag.voxel_count, rel=0.02 if rule == "thin" else 0.35)
    assert found.file_bytes > dag.geometry_bytes


def test_the_bounds_decide_how_large_a_voxel_is() -> None:
    """A cube twice as long as the mesh has a quarter of the voxels on it."""
    mesh = torus()
    near = estimate(extent_of(*mesh), Config(resolution=256))
    wide = Config(resolution=256, bounds_m=[[-5.5, -5.5, -5.5], [5.5, 5.5, 5.5]])
    far = estimate(extent_of(*mesh, wide), wide)
    assert near.voxel_count == pytest.approx(4 * far.voxel_count, rel=1e-4)


def test_what_fits_a_budget_is_voxelized_and_what_does_not_is_refused() -> None:
    """At the highest resolution of which the estimate says that it fits; four times that is refused."""
    mesh = torus()
    config = Config(resolution=131072, memory_budget_bytes=8 << 20)
    fits = largest_that_fits(extent_of(*mesh), config)
    assert fits is not None
    assert fits.resolution in {256, 512, 1024}
    assert voxelize(*mesh, dataclasses.replace(config, resolution=fits.resolution)).voxel_count > 0
    with pytest.raises(tyndall.InvalidInput, match="budget of 8 MiB"):
        voxelize(*mesh, dataclasses.replace(config, resolution=4 * fits.resolution))
    assert largest_that_fits(extent_of(*mesh), Config(memory_budget_bytes=1)) is None


def test_estimates_of_next_to_nothing() -> None:
    """A point, and no triangle at all; a vertex that is not there is named."""
    assert estimate(extent_of([[1.0, 2.0, 3.0]], [[0, 0, 0]]), Config()).voxel_count == 1
    assert estimate(extent_of(np.zeros((0, 3)), np.zeros((0, 3), np.uint32)), Config()).voxel_count == 1
    with pytest.raises(tyndall.InvalidInput, match="vertex 7 of 1"):
        extent_of([[0.0, 0.0, 0.0]], [[0, 0, 7]])


# Counts


def test_levels_count_cubes_that_are_not_empty() -> None:
    """Those of an octree by brute force; distinct ones add up to all nodes, bytes of parts to all bytes."""
    voxels, dag = scattered(1)
    levels = dag.levels()
    assert [counts.side for counts in levels] == [2, 4, 8, 16, 32, 64]
    for counts in levels:
        assert counts.tree_node_count == len(np.unique(voxels // counts.side, axis=0))
    assert sum(counts.node_count for counts in levels) == dag.node_count
    assert sum(dag.bytes_by_part.values()) == dag.geometry_bytes
    assert from_coordinates(np.zeros((0, 3), np.uint32), Config(resolution=64)).levels() == []


# Previews


@pytest.mark.parametrize("level", [0, 3, 5, 6, 9])
def test_a_preview_has_the_cubes_that_hold_voxels(level: int) -> None:
    """Each once; never finer than the voxels are."""
    voxels, dag = scattered(2)
    cubes, found = dag.coarse_cubes(level, most_cubes=10**6)
    assert found == min(level, 6)
    assert len(np.unique(cubes, axis=0)) == len(cubes)
    assert np.array_equal(np.unique(cubes, axis=0), np.unique(voxels >> np.uint32(6 - found), axis=0))


@pytest.mark.parametrize("most_cubes", [1, 8, 500, 2999])
def test_a_preview_of_too_many_cubes_is_coarser(most_cubes: int) -> None:
    """The finest level that has no more; nothing is lost."""
    voxels, dag = scattered(3)
    counts = [len(np.unique(voxels >> np.uint32(6 - level), axis=0)) for level in range(7)]
    cubes, found = dag.coarse_cubes(6, most_cubes)
    assert found == max(level for level in range(7) if counts[level] <= most_cubes)
    assert np.array_equal(np.unique(cubes, axis=0), np.unique(voxels >> np.uint32(6 - found), axis=0))


def test_a_preview_can_be_stopped() -> None:
    progress = tyndall.Progress()
    progress.cancel()
    with pytest.raises(tyndall.Cancelled):
        scattered(4)[1].coarse_cubes(3, 100, progress)


def test_faces_between_cubes_are_left_out() -> None:
    """As many as neighbours are missing; each looks the way its array says, from its own cube."""
    _voxels, dag = scattered(5, count=20_000, resolution=32)
    cubes, _level = dag.coarse_cubes(5, most_cubes=10**6)
    there = set(map(tuple, cubes.tolist()))
    for direction, faces in enumerate(exposed_faces(cubes)):
        axis, sign = direction // 2, 2 * (direction % 2) - 1
        step = np.zeros(3, int)
        step[axis] = sign
        bare = sorted(cube for cube in there if tuple((np.array(cube) + step).tolist()) not in there)
        corners = faces.astype(np.int64)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
        assert (normals == step).all()
        centres = corners.mean(axis=1) - 0.5 * step
        assert sorted(map(tuple, (centres - 0.5).astype(int).tolist())) == bare
