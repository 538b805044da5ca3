# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of voxels into OpenVDB files, and out of them: bytes as sRGB encodes them there, linear vectors here."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

import tyndall
from tyndall.volumes import from_dense, grid_infos, read_vdb, to_dense, write_vdb
from tyndall.voxel_dag import Config, VoxelDag, from_coordinates, import_vdb
from tyndall.voxel_dag.grid_colors import colored

Kind = Literal["fog", "level set"]
LOWER_M = np.array([-4.0, 8.0, 0.5])


def painted(resolution: int = 64, count: int = 4000, seed: int = 1) -> VoxelDag:
    """Voxels here and there, of which some fill a leaf, in random colours."""
    random = np.random.default_rng(seed)
    voxels = random.integers(0, resolution, (count, 3))
    voxels = np.unique(np.concatenate([voxels, np.indices((8, 8, 8)).reshape(3, -1).T + 16]), axis=0)
    colors = random.integers(0, 256, voxels.shape).astype(np.uint8)
    bounds_m = np.array([LOWER_M, LOWER_M + 8.0])
    return from_coordinates(voxels, Config(resolution=resolution, bounds_m=bounds_m, colors=colors))


def colours_of(dag: VoxelDag, lower_m: np.ndarray) -> dict[tuple[int, ...], tuple[int, ...]]:
    """By the voxel's place from a corner."""
    voxel_m = float(np.ptp(dag.bounds_m, axis=0)[0]) / dag.resolution
    moved = np.round((dag.bounds_m[0] - lower_m) / voxel_m).astype(np.int64)
    return {
        tuple(voxel + moved): tuple(color)
        for some in dag.coordinates()
        for voxel, color in zip(some.astype(np.int64), dag.colors_at(some).tolist(), strict=True)
    }


def linear(byte: float) -> float:
    """IEC 61966-2-1."""
    encoded = byte / 255
    return encoded / 12.92 if encoded <= 0.04045 else math.pow((encoded + 0.055) / 1.055, 2.4)


@pytest.mark.parametrize("kind", ["fog", "level set"])
def test_colours_come_back_to_the_bit(kind: Kind, tmp_path: Path) -> None:
    dag = painted()
    dag.to_vdb(tmp_path / "a.vdb", kind)
    read = import_vdb(tmp_path / "a.vdb", color_grid="color")
    assert colours_of(read, LOWER_M) == colours_of(dag, LOWER_M)
    assert not import_vdb(tmp_path / "a.vdb", "density" if kind == "fog" else "surface").has_colors


def test_a_file_has_linear_vectors_where_a_voxel_is_set_alone(tmp_path: Path) -> None:
    dag = painted(seed=2)
    dag.to_vdb(tmp_path / "a.vdb", color_name="Cd")
    infos = {info.name: info for info in grid_infos(tmp_path / "a.vdb")}
    assert list(infos) == ["density", "Cd"]
    assert infos["Cd"].value_type == "vec3s"
    assert infos["Cd"].active_voxel_count == infos["density"].active_voxel_count == dag.voxel_count
    grids = read_vdb(tmp_path / "a.vdb", ["Cd"])
    found = [to_dense(grids[f"Cd.{axis}"], ((0, 0, 0), (64, 64, 64)))[0] for axis in "xyz"]
    wanted = np.zeros((3, 64, 64, 64))
    for voxel, color in colours_of(dag, LOWER_M).items():
        wanted[(slice(None), *voxel)] = [linear(channel) for channel in color]
    np.testing.assert_allclose(found, wanted, rtol=1e-6)
    dag.to_vdb(tmp_path / "b.vdb", color_name="")
    assert [info.name for info in grid_infos(tmp_path / "b.vdb")] == ["density"]


@pytest.mark.parametrize("level", [5, 3])
def test_coarse_cubes_have_their_mean_colours(level: int, tmp_path: Path) -> None:
    dag = painted(seed=3)
    dag.to_vdb(tmp_path / "a.vdb", level=level)
    read = import_vdb(tmp_path / "a.vdb", color_grid="color")
    side = dag.resolution >> level
    cubes = np.unique(np.concatenate(list(dag.coordinates())) // side, axis=0)
    means = dag.colors_at(cubes * side, level)
    found = colours_of(read, LOWER_M)
    assert found == {tuple(cube): tuple(color) for cube, color in zip(cubes.tolist(), means.tolist(), strict=True)}


def test_colours_are_looked_up_where_they_lie_and_clamped() -> None:
    """Also where the leaves of the colours are others than those of the voxels, at indices below 0."""
    random = np.random.default_rng(4)
    linear_red = random.random((20, 30, 10)).astype(np.float32) * 1.5 - 0.25
    linear_red[5, 6, 7] = np.nan
    first_index = (-13, 5, -40)
    channels = [
        from_dense("red", linear_red, np.eye(4), first_index=first_index, background=0.5),
        from_dense("green", np.zeros((1, 1, 1), np.float32), np.eye(4), first_index=(1 << 20, 0, 0)),
        from_dense("blue", np.zeros((0, 0, 0), np.float32), np.eye(4), background=2.0),
    ]
    first = np.array([-16, 0, -40], np.int64)
    voxels, colors = colored(
        from_coordinates(random.integers(0, 32, (5000, 3)), Config(resolution=32)), channels, first
    )
    places = voxels.astype(np.int64) + first - first_index
    is_within = ((places >= 0) & (places < linear_red.shape)).all(axis=1)
    assert 0 < is_within.sum() < len(voxels)
    wanted = np.full(len(voxels), np.float32(0.5))
    wanted[is_within] = np.clip(np.nan_to_num(linear_red[tuple(places[is_within].T)]), 0.0, 1.0)
    half_a_byte = [linear(byte + 0.5) for byte in range(255)]
    assert np.array_equal(colors[:, 0], np.searchsorted(half_a_byte, wanted))
    assert (colors[:, 1] == 0).all()
    assert (colors[:, 2] == 255).all()


def test_wrong_colours_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.vdb"
    dag = painted(seed=5)
    with pytest.raises(tyndall.InvalidInput, match="two of this name"):
        dag.to_vdb(path, color_name="density")
    with pytest.raises(tyndall.InvalidInput, match=r"and their colours take some .* leave the colours out"):
        dag.to_vdb(path, memory_budget_bytes=8192 * 600)
    assert list(tmp_path.iterdir()) == []
    dag.to_vdb(path)
    for changes, culprit in (
        ({"color_grid": "Cd"}, r'no grid "Cd"; it has: "density", "color"'),
        ({"grid": "density", "color_grid": "density"}, r'"density": it holds float, no colours'),
        ({"color_grid": "color", "grid": "color"}, r'"color": it holds vec3s, not one number'),
        ({"color_grid": "color", "config": Config(memory_budget_bytes=1 << 20)}, "limit of|colours of"),
    ):
        with pytest.raises(tyndall.InvalidInput, match=culprit):
            import_vdb(path, **changes)
    elsewhere = [from_dense(axis, np.ones((8, 8, 8)), np.eye(4)) for axis in "xyz"]
    with monkeypatch.context() as patch:
        patch.setattr("tyndall.voxel_dag.grids.read_colors", lambda *_: elsewhere)
        with pytest.raises(tyndall.InvalidInput, match='"density": its colours, "color", lie elsewhere'):
            import_vdb(path, color_grid="color")
    write_vdb(path, [from_dense("density", np.ones((8, 8, 8)), np.eye(4))])
    with pytest.raises(tyndall.InvalidInput, match='no grid "color"'):
        import_vdb(path, color_grid="color")
