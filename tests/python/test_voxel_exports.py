# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxel DAGs as meshes and as OpenVDB files: closed, outward, as much as there are voxels, and back."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest

import tyndall
from support.full_disk import largest_file
from tyndall.volumes import grid_infos, read_vdb, to_dense
from tyndall.voxel_dag import Config, VoxelDag, from_coordinates, import_vdb

BOUNDS_M = np.array([[-4.0, 8.0, 0.5], [4.0, 16.0, 8.5]])


def ball(resolution: int, radius: float, *, shell_only: bool = False) -> VoxelDag:
    """Voxels whose centres lie within a ball about the cube's middle."""
    centres = np.arange(resolution) + 0.5 - resolution / 2
    distance = np.sqrt((np.stack(np.meshgrid(centres, centres, centres, indexing="ij")) ** 2).sum(axis=0))
    is_set = distance <= radius
    if shell_only:
        is_set &= distance > radius - 1.5
    return from_coordinates(np.argwhere(is_set), Config(resolution=resolution, bounds_m=BOUNDS_M))


def scattered(resolution: int, count: int, seed: int) -> VoxelDag:
    voxels = np.random.default_rng(seed).integers(0, resolution, (count, 3))
    return from_coordinates(voxels, Config(resolution=resolution, bounds_m=BOUNDS_M))


def all_of(dag: VoxelDag) -> np.ndarray:
    return np.concatenate([*dag.coordinates(), np.zeros((0, 3), np.uint32)])


def volume_of(positions_m: np.ndarray, triangles: np.ndarray) -> float:
    """By the divergence theorem, about a corner of the cube."""
    a, b, c = (positions_m[triangles[:, corner]] - BOUNDS_M[0] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def is_balanced(triangles: np.ndarray) -> bool:
    """Whether each edge is passed as often one way as the other."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    ways = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    _, edge = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    return not np.bincount(edge.ravel(), ways).any()


@pytest.mark.parametrize("dag", [ball(32, 13.3), scattered(16, 900, 1), scattered(256, 500, 2)])
def test_boxes_are_closed_and_hold_exactly_the_voxels(dag: VoxelDag) -> None:
    voxel_m = 8.0 / dag.resolution  # a power of two: positions are exact
    positions_m, triangles, _ = dag.to_mesh()
    assert volume_of(positions_m, triangles) == dag.voxel_count * voxel_m**3
    assert is_balanced(triangles)
    assert len(np.unique(positions_m, axis=0)) == len(positions_m)
    voxels = all_of(dag).astype(np.int64)
    steps = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.int64)
    beyond = (voxels[:, None] + steps).reshape(-1, 3)
    is_outside = (beyond < 0).any(axis=1)
    open_faces = is_outside.sum() + (~dag.contains(beyond[~is_outside])).sum()
    assert len(triangles) == 2 * open_faces


@pytest.mark.parametrize("level", [3, 4, 5])
def test_boxes_of_a_level_are_the_cubes_that_have_any_voxel(level: int) -> None:
    dag = ball(64, 29.5, shell_only=True)
    positions_m, triangles, _ = dag.to_mesh(level=level)
    cubes = np.unique(all_of(dag) >> (6 - level), axis=0)
    assert volume_of(positions_m, triangles) == len(cubes) * (8.0 / 2**level) ** 3


@pytest.mark.parametrize("level", [6, 5, 2])
def test_boxes_have_the_colours_of_their_voxels_on_each_face(level: int) -> None:
    random = np.random.default_rng(6)
    voxels = np.unique(random.integers(0, 64, (3000, 3)), axis=0)
    colors = random.integers(0, 256, voxels.shape).astype(np.uint8)
    dag = from_coordinates(voxels, Config(resolution=64, colors=colors))
    side = 64 >> level
    positions_m, triangles, found = dag.to_mesh(level=level)
    assert found is not None
    pairs = triangles.reshape(-1, 6)
    corners = positions_m[pairs]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    within = np.floor((lower + upper) / 2 - normals * side / 2).astype(np.int64)  # the cube's middle
    assert np.array_equal(found[::2], found[1::2])
    set_within = within // side * side
    wanted = dag.colors_at(set_within, level)
    assert np.array_equal(found[::2], wanted)
    if side == 1:
        by_place = {tuple(voxel): tuple(color) for voxel, color in zip(voxels.tolist(), colors.tolist(), strict=True)}
        assert [by_place[tuple(voxel)] for voxel in within.tolist()] == [tuple(color) for color in found[::2].tolist()]
    assert from_coordinates(voxels, Config(resolution=64)).to_mesh().colors is None


@pytest.mark.parametrize("level", [6, 4])
def test_boxes_have_the_channels_of_their_voxels(level: int) -> None:
    """In a cube that is no unit one, where each voxel's colour says which it is."""
    random = np.random.default_rng(7)
    voxels = np.unique(random.integers(0, 64, (2000, 3)), axis=0)
    channels = {name: random.integers(0, 256, len(voxels)).astype(np.uint8) for name in ("emission", "roughness")}
    bounds_m = ((-3.0, 1.0, 2.0), (0.2, 4.2, 5.2))
    colors = (4 * voxels).astype(np.uint8)
    dag = from_coordinates(voxels, Config(resolution=64, bounds_m=bounds_m, colors=colors, channels=channels))
    mesh = dag.to_mesh(level=level)
    found = dag.box_channels(mesh, level=level)
    assert set(found) == set(channels)
    assert all(values.shape == (len(mesh.triangles),) for values in found.values())
    if level == 6:
        assert mesh.colors is not None
        for name in channels:
            assert np.array_equal(found[name], dag.channel_at(name, mesh.colors // 4))
    of_level = {name: set(dag.channel_at(name, voxels, level).tolist()) for name in channels}
    assert all(set(found[name].tolist()) <= of_level[name] for name in channels)
    assert ball(16, 5.0).box_channels(ball(16, 5.0).to_mesh()) == {}


def test_a_smooth_mesh_is_closed_looks_outward_and_keeps_to_the_surface() -> None:
    dag = ball(64, 25.0)
    positions_m, triangles, _ = dag.to_mesh("smooth")
    voxel_m = 8.0 / 64
    assert is_balanced(triangles)
    assert volume_of(positions_m, triangles) == pytest.approx(dag.voxel_count * voxel_m**3, rel=0.01)
    radii = np.linalg.norm(positions_m - BOUNDS_M.mean(axis=0), axis=1) / voxel_m
    assert np.abs(radii - 25.0).max() < 1.0
    a, b, c = (positions_m[triangles[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    outward = np.einsum("ij,ij->i", normals, a - BOUNDS_M.mean(axis=0)) / np.linalg.norm(normals, axis=1) / 25 / voxel_m
    assert np.median(outward) > 0.95
    assert (outward > 0).mean() > 0.999


@pytest.mark.parametrize("kind", ["fog", "level set"])
@pytest.mark.parametrize(
    "dag", [ball(32, 13.3), scattered(16, 900, 3), ball(64, 25, shell_only=True), scattered(256, 99, 4)]
)
def test_a_grid_of_either_kind_gives_the_voxels_back_where_they_are(
    kind: Literal["fog", "level set"], dag: VoxelDag, tmp_path: Path
) -> None:
    dag.to_vdb(tmp_path / "a.vdb", kind)
    (info,) = grid_infos(tmp_path / "a.vdb")
    assert (info.name, info.grid_class) == (("density", "fog volume") if kind == "fog" else ("surface", "level set"))
    read = import_vdb(tmp_path / "a.vdb")
    voxel_m = 8.0 / dag.resolution
    assert (np.ptp(read.bounds_m, axis=0) / read.resolution == voxel_m).all()
    moved = (read.bounds_m[0] - BOUNDS_M[0]) / voxel_m
    assert np.array_equal(all_of(read).astype(np.int64) + moved.astype(np.int64), all_of(dag)[order_of(dag, moved)])


def order_of(dag: VoxelDag, moved: np.ndarray) -> np.ndarray:
    """The Morton order of voxels that are counted from another corner."""
    voxels = all_of(dag).astype(np.int64) - moved.astype(np.int64)
    codes = np.zeros(len(voxels), np.uint64)
    for bit in range(9):
        for axis in range(3):
            codes |= (voxels[:, axis].astype(np.uint64) >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return np.argsort(codes)


def test_fog_is_1_where_a_voxel_is_set_and_a_level_set_is_negative_there_alone(tmp_path: Path) -> None:
    dag = ball(32, 11.0)
    is_set = np.zeros((32, 32, 32), bool)
    is_set[tuple(all_of(dag).T)] = True
    dag.to_vdb(tmp_path / "fog.vdb", name="smoke")
    fog, _ = to_dense(read_vdb(tmp_path / "fog.vdb")["smoke"], ((0, 0, 0), (32, 32, 32)))
    assert np.array_equal(fog, is_set.astype(np.float32))
    dag.to_vdb(tmp_path / "set.vdb", "level set")
    distance, _ = to_dense(read_vdb(tmp_path / "set.vdb")["surface"], ((0, 0, 0), (32, 32, 32)))
    assert np.array_equal(distance < 0, is_set)
    true_distance_m = (np.linalg.norm(np.indices((32, 32, 32)).T + 0.5 - 16, axis=-1).T - 11.0) * 8.0 / 32
    near = np.abs(true_distance_m) < 0.25
    assert np.abs(distance - true_distance_m)[near].max() < 0.25  # a voxel
    assert np.corrcoef(distance[near], true_distance_m[near])[0, 1] > 0.9


def test_nothing_becomes_an_empty_mesh_and_an_empty_grid(tmp_path: Path) -> None:
    nothing = from_coordinates(np.zeros((0, 3), np.int64), Config(resolution=16, bounds_m=BOUNDS_M))
    for kind in ("boxes", "smooth"):
        positions_m, triangles, _ = nothing.to_mesh(kind)
        assert positions_m.shape == triangles.shape == (0, 3)
    for kind in ("fog", "level set"):
        nothing.to_vdb(tmp_path / "a.vdb", kind)
        assert grid_infos(tmp_path / "a.vdb")[0].active_voxel_count == 0


def test_what_does_not_fit_is_refused_before_it_is_made_and_a_wrong_word_is_named(tmp_path: Path) -> None:
    dag = ball(64, 25.0)
    with pytest.raises(tyndall.InvalidInput, match=r"squares, and takes some .*coarser level"):
        dag.to_mesh(memory_budget_bytes=1 << 19)
    with pytest.raises(tyndall.InvalidInput, match=r"unpacked.*coarser level"):
        dag.to_mesh(memory_budget_bytes=1 << 10)
    for call in (
        lambda **budget: dag.to_mesh("smooth", **budget),
        lambda **budget: dag.to_vdb(tmp_path / "a", **budget),
    ):
        with pytest.raises(tyndall.InvalidInput, match=r"a grid of these voxels takes some .* GB"):
            call(memory_budget_bytes=1 << 19)
    with pytest.raises(tyndall.InvalidInput, match="fewer than 4"):
        dag.to_mesh(level=1)
    with pytest.raises(tyndall.InvalidInput, match="level is -1"):
        dag.to_mesh(level=-1)
    with pytest.raises(tyndall.InvalidInput, match="'round'"):
        dag.to_mesh("round")  # type: ignore[arg-type]
    with pytest.raises(tyndall.InvalidInput, match="'solid'"):
        dag.to_vdb(tmp_path / "a", "solid")  # type: ignore[arg-type]
    cancelled = tyndall.Progress()
    cancelled.cancel()
    for kind in ("boxes", "smooth"):
        with pytest.raises(tyndall.Cancelled):
            dag.to_mesh(kind, progress=cancelled)
    with pytest.raises(tyndall.Cancelled):
        dag.to_vdb(tmp_path / "a", progress=cancelled)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_leaves_the_grid_that_was_there(tmp_path: Path) -> None:
    path = tmp_path / "a.vdb"
    ball(8, 3.0).to_vdb(path)
    before = path.read_bytes()
    with largest_file(1 << 12), pytest.raises(tyndall.IoError, match=r"a\.vdb: .*room"):
        scattered(256, 3000, 5).to_vdb(path, "level set")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
