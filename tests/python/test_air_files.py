# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air as grids: at the voxels' centres it is the air's, and paint comes back as it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tyndall
from tyndall.air_files import baked_density, painted_grids, painted_values, resolution_of
from tyndall.air_tiles import VOLUME_KINDS
from tyndall.baked_air import bake_air
from tyndall.heterogeneity import Heterogeneity, PaintedAir
from tyndall.volumes import SparseGrid, from_dense, read_vdb, to_dense, values_at, write_vdb

RESOLUTION = (9, 16, 20)
#: Of a cube of 4 m around its origin.
LOCAL_FROM_UNIT = np.diag([4.0, 4.0, 4.0, 1.0]) + np.array([[0, 0, 0, -2.0]] * 3 + [[0, 0, 0, 0]])


def paint(name: str, seed: int = 1) -> np.ndarray:
    """(nz, ny, nx) of numbers that half floats hold, in one corner."""
    kind = VOLUME_KINDS[name]
    values = np.full(RESOLUTION[::-1], kind.neutral, np.float32)
    values[:8, :9, :7] = np.random.default_rng(seed).uniform(kind.lowest, kind.highest, (8, 9, 7)).astype(np.float16)
    return values


def painted_air() -> PaintedAir:
    return PaintedAir(
        key="painted",
        world_from_unit=tuple(map(tuple, LOCAL_FROM_UNIT.tolist())),
        amount=paint("amount"),
        intensity=paint("intensity", 2),
    )


def test_painted_air_comes_back_from_a_file_as_it_was(tmp_path: Path) -> None:
    """Bit for bit, also through half floats, which is what a .blend keeps; a volume without paint has no leaves."""
    painted = painted_air()
    for is_half in (False, True):
        write_vdb(tmp_path / "air.vdb", painted_grids(painted, RESOLUTION, LOCAL_FROM_UNIT), is_half=is_half)
        grids = read_vdb(tmp_path / "air.vdb")
        assert list(grids) == ["amount", "level", "intensity"]
        assert len(grids["level"].leaf_origins) == 0
        for name in ("amount", "intensity"):
            assert resolution_of(grids[name], LOCAL_FROM_UNIT) == RESOLUTION
            np.testing.assert_array_equal(
                painted_values(grids[name], RESOLUTION, LOCAL_FROM_UNIT), getattr(painted, name)
            )
        assert not painted_values(grids["level"], RESOLUTION, LOCAL_FROM_UNIT).any()


def test_baked_density_is_the_air_with_its_intensity() -> None:
    """Voxel i of n lies at (i + 0.5) / n of the box."""
    heterogeneity = Heterogeneity(intensity=2.5, painted=painted_air())
    resolution = (12, 8, 10)
    grid = baked_density(heterogeneity, resolution, LOCAL_FROM_UNIT, tyndall.Progress())
    baked = bake_air(heterogeneity, resolution, tyndall.Progress())
    dense, _ = to_dense(grid, ((0, 0, 0), resolution))
    np.testing.assert_array_equal(dense, np.float32(2.5) * baked.transpose(2, 1, 0))
    np.testing.assert_allclose(
        (grid.local_from_index @ [11, 7, 9, 1])[:3], 2.0 - 2.0 / np.array(resolution), rtol=1e-12
    )


def test_a_grid_of_another_program_is_read_where_it_lies() -> None:
    """A field that grows linearly along an oblique direction is the same between its voxels, whatever the grid."""
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    local_from_index = np.eye(4)
    local_from_index[:3, :3], local_from_index[:3, 3] = 0.25 * turn, [0.1, 0.2, -0.3]
    first, shape = (-16, -16, -12), (32, 32, 26)
    index = np.stack(np.meshgrid(*(np.arange(b, b + n) for b, n in zip(first, shape, strict=True)), indexing="ij"), -1)
    slope = np.array([0.05, -0.02, 0.03])
    field = ((index @ local_from_index[:3, :3].T + local_from_index[:3, 3]) @ slope).astype(np.float32)
    grid = from_dense("amount", field, local_from_index, first_index=first)
    assert resolution_of(grid, LOCAL_FROM_UNIT) is None
    values = painted_values(grid, RESOLUTION, LOCAL_FROM_UNIT)
    centres = [(np.arange(n) + 0.5) / n * 4.0 - 2.0 for n in RESOLUTION]
    z, y, x = np.meshgrid(*reversed(centres), indexing="ij")
    # Grid values and weights are rounded to 24 bits, eight products are added.
    assert np.abs(values - (slope[0] * x + slope[1] * y + slope[2] * z)).max() < 8 * 2**-24 * np.abs(field).max()


def test_voxels_are_found_by_their_indices() -> None:
    values = np.random.default_rng(3).random((20, 9, 17), np.float32)
    grid = from_dense("density", np.where(values < 0.3, 0.0, values), np.eye(4), first_index=(-9, 100, -3))
    indices = np.random.default_rng(4).integers((-30, 90, -20), (30, 120, 30), (5000, 3))
    dense, _ = to_dense(grid, ((-30, 90, -20), (30, 120, 30)))
    np.testing.assert_array_equal(values_at(grid, indices), dense[tuple((indices - [-30, 90, -20]).T)])
    empty = SparseGrid(
        name="empty",
        leaf_origins=grid.leaf_origins[:0],
        leaf_values=grid.leaf_values[:0],
        local_from_index=np.eye(4),
        background=0.5,
    )
    assert values_at(empty, indices).tolist() == [0.5] * 5000


def test_air_without_a_box_cannot_be_baked() -> None:
    with pytest.raises(tyndall.InvalidInput, match="there is no painted box"):
        baked_density(Heterogeneity(), (4, 4, 4), LOCAL_FROM_UNIT, tyndall.Progress())
