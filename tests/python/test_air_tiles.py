# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted volumes in tiles: what is kept comes back, and another resolution shows the same paint."""

from __future__ import annotations

import numpy as np
import pytest

from tyndall import air_tiles
from tyndall.air_tiles import TILE_VOXELS, VOLUME_KINDS

SHAPES = [(1, 1, 1), (16, 16, 16), (17, 5, 40), (33, 48, 64)]


@pytest.mark.parametrize("shape", SHAPES)
def test_tiles_cover_every_voxel_once(shape: tuple[int, int, int]) -> None:
    covered = np.zeros(shape, int)
    for index in range(air_tiles.tile_count(shape)):
        block = covered[air_tiles.tile_block(index, shape)]
        assert max(block.shape) <= TILE_VOXELS
        block += 1
    assert (covered == 1).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_tiles_of_a_block_are_those_that_meet_it(shape: tuple[int, int, int]) -> None:
    """Against a look at every tile, for blocks at random places."""
    random = np.random.default_rng(1)
    for _ in range(20):
        low = [int(random.integers(0, voxels)) for voxels in shape]
        high = [int(random.integers(at + 1, voxels + 1)) for at, voxels in zip(low, shape, strict=True)]
        z, y, x = (slice(*ends) for ends in zip(low, high, strict=True))
        is_in = np.zeros(shape, bool)
        is_in[z, y, x] = True
        count = air_tiles.tile_count(shape)
        met = {index for index in range(count) if is_in[air_tiles.tile_block(index, shape)].any()}
        assert air_tiles.tiles_in((z, y, x), shape) == met


def test_an_empty_block_has_no_tiles() -> None:
    assert air_tiles.tiles_in((slice(3, 3), slice(0, 16), slice(0, 16)), (16, 16, 16)) == set()


@pytest.mark.parametrize("name", VOLUME_KINDS)
def test_what_is_kept_comes_back_exactly(name: str) -> None:
    """Once it is rounded; half floats have 11 bits, and nothing leaves its range."""
    kind = VOLUME_KINDS[name]
    given = np.random.default_rng(2).uniform(kind.lowest - 1.0, kind.highest + 1.0, (16, 7, 3)).astype(np.float32)
    kept = air_tiles.as_kept(given, kind)
    assert kept.min() >= kind.lowest
    assert kept.max() <= kind.highest
    inside = (given > kind.lowest) & (given < kind.highest)
    assert np.abs(kept - given)[inside].max() <= 2.0**-11 * kind.highest
    again = air_tiles.unpacked(air_tiles.packed(kept), kept.shape)
    assert again.tobytes() == kept.tobytes()
    assert air_tiles.as_kept(np.full(1, kind.neutral, np.float32), kind)[0] == kind.neutral


def test_what_is_kept_has_no_zero_byte() -> None:
    """Whatever bytes zlib writes, runs of those that stand for zero included."""
    random = np.random.default_rng(5)
    for _ in range(50):
        given = random.integers(-1, 2, (16, 16, 16)).astype(np.float32) * random.random((16, 16, 1), np.float32)
        kept = air_tiles.packed(given)
        assert b"\x00" not in kept
        assert np.array_equal(air_tiles.unpacked(kept, given.shape), given.astype(np.float16))


def test_a_damaged_tile_is_said_to_be() -> None:
    kept = air_tiles.packed(np.ones((16, 16, 16), np.float32))
    for damaged in (kept[:20], b"", b"x" + kept):
        with pytest.raises(ValueError, match="a tile is damaged"):
            air_tiles.unpacked(damaged, (16, 16, 16))
    with pytest.raises(ValueError, match="has 4096 voxels instead of 16 x 16 x 8"):
        air_tiles.unpacked(kept, (16, 16, 8))


def test_an_even_volume_stays_even_at_any_resolution() -> None:
    """To the bits of what is kept: no border darkens."""
    for name, kind in VOLUME_KINDS.items():
        even = np.full((12, 20, 7), kind.highest / 4.0, np.float32)
        for resolution in ((7, 20, 12), (64, 33, 1), (3, 100, 24)):
            finer = air_tiles.resampled(even, resolution)
            assert finer.shape == resolution[::-1], name
            assert (air_tiles.as_kept(finer, kind) == kind.highest / 4.0).all(), name


def test_a_ramp_stays_a_ramp_at_a_finer_resolution() -> None:
    """Between the outermost centres, along each axis; beyond them it is as there."""
    for axis in range(3):
        shape = [4, 4, 4]
        shape[axis] = 8
        centres = (np.arange(8) + 0.5) / 8
        ramp = np.broadcast_to(np.moveaxis(centres[:, None, None], 0, axis), shape).astype(np.float32)
        resolution = [4, 4, 4]
        resolution[2 - axis] = 24
        finer = np.moveaxis(air_tiles.resampled(ramp, tuple(resolution)), axis, 0)[:, 0, 0]
        expected = np.clip((np.arange(24) + 0.5) / 24, centres[0], centres[-1])
        assert np.abs(finer - expected).max() < 1e-6


def test_the_mean_survives_a_coarser_resolution() -> None:
    """Up to what lies along the border, where the triangle is cut off: of random paint, less than its noise."""
    given = np.random.default_rng(3).random((64, 64, 64), np.float32)
    coarser = air_tiles.resampled(given, (16, 16, 16))
    assert abs(coarser.mean() - given.mean()) < 3.0 * given.std() / np.sqrt(16**3)
    assert coarser.std() < 0.15 * given.std()


def test_the_same_resolution_changes_no_bit() -> None:
    given = np.random.default_rng(4).random((5, 6, 7), np.float32)
    assert air_tiles.resampled(given, (7, 6, 5)).tobytes() == given.tobytes()
