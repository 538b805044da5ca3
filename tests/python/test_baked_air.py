# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting and noise baked into one volume: the air is the same, and then needs no noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tyndall import Cancelled, InvalidInput, Progress
from tyndall.baked_air import bake_air
from tyndall.heterogeneity import AirNoise, Heterogeneity, PaintedAir

#: 12 m x 6 m x 3 m, far from the origin.
BOX = ((12.0, 0.0, 0.0, 1000.0), (0.0, 6.0, 0.0, -500.0), (0.0, 0.0, 3.0, 7.0), (0.0, 0.0, 0.0, 1.0))
RESOLUTION = (24, 12, 6)
SHAPE = RESOLUTION[::-1]


def painted(**volumes: NDArray[np.float32]) -> PaintedAir:
    return PaintedAir(key=repr(sorted(volumes)), world_from_unit=BOX, **volumes)


def air(**changes: object) -> Heterogeneity:
    """Noise whose texels are an eighth of a metre: finer than the voxels of half a metre by two levels."""
    defaults = {"noise": AirNoise(scale_m=1.0, resolution=64, seed=3), "painted": painted()}
    return Heterogeneity(**(defaults | changes))


def bake(heterogeneity: Heterogeneity) -> NDArray[np.float32]:
    return bake_air(heterogeneity, RESOLUTION, Progress())


def random_volume(low: float, high: float, seed: int) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(low, high, SHAPE).astype(np.float32)


def test_air_without_texture_is_what_is_painted_into_its_intensity() -> None:
    """Exactly: voxels' centres are the samples. The scene's own intensity stays out of it."""
    intensity = random_volume(0.0, 3.0, 1)
    baked = bake(air(amount=0.0, intensity=5.0, painted=painted(intensity=intensity)))
    assert baked.shape == SHAPE
    assert np.abs(baked - intensity).max() < 1e-5


def test_noise_keeps_the_light() -> None:
    """Its mean is 1 up to what so few voxels leave of its deviation."""
    baked = bake(air())
    assert baked.std() > 0.1
    assert abs(baked.mean() - 1.0) < 0.1


def test_the_blend_is_that_of_the_air() -> None:
    """I (a N + 1 - a), with N of what is baked at full amount."""
    noise = bake(air())
    amount, intensity = random_volume(-1.0, 0.0, 2), random_volume(0.0, 2.0, 3)
    baked = bake(air(painted=painted(amount=amount, intensity=intensity)))
    a = 1.0 + amount
    assert np.abs(baked - intensity * (a * noise + 1.0 - a)).max() < 1e-4


def test_a_softer_level_is_smoother() -> None:
    deviations = [bake(air(level=level)).std() for level in (0.0, 2.0, 3.0, 4.0)]
    assert deviations[0] == pytest.approx(deviations[1])  # the voxels themselves ask for level 2
    assert deviations[1] > 1.2 * deviations[2] > 1.2 * deviations[3]


def test_baked_air_bakes_to_itself() -> None:
    """As intensity, with amount -1: no noise is left, and the wind moves nothing."""
    first = bake(air(painted=painted(amount=random_volume(-0.5, 0.0, 4))))
    even = np.full(SHAPE, -1.0, np.float32)
    again = bake(air(moved_m=(3.0, 2.0, 1.0), painted=painted(amount=even, intensity=first)))
    assert np.abs(again - first).max() < 1e-5


def test_the_wind_of_the_moment_is_baked_in() -> None:
    """By a voxel along x: the same numbers, a voxel further."""
    still, moved = bake(air()), bake(air(moved_m=(0.5, 0.0, 0.0)))
    assert np.abs(moved[..., 1:] - still[..., :-1]).max() < 1e-3


def test_what_cannot_be_baked_is_named() -> None:
    with pytest.raises(InvalidInput, match="no painted box"):
        bake(air(painted=None))
    flat = replace(painted(), world_from_unit=(*BOX[:2], (0.0, 0.0, 0.0, 7.0), BOX[3]))
    with pytest.raises(InvalidInput, match="flat"):
        bake(air(painted=flat))
    with pytest.raises(InvalidInput, match="0 x 12 x 6 voxels"):
        bake_air(air(), (0, 12, 6), Progress())
    cancelled = Progress()
    cancelled.cancel()
    with pytest.raises(Cancelled):
        bake_air(air(), RESOLUTION, cancelled)
