# SPDX-License-Identifier: GPL-3.0-or-later
"""Moments of a shutter: all samples are dealt out, and what they see weighs what the shutter lets through."""

from __future__ import annotations

import numpy as np
import pytest

from tyndall.shutter_times import CURVE_INTERVALS, moments


@pytest.mark.parametrize(("samples", "most"), [(16, 16), (16, 5), (3, 16), (1, 16), (100, 32), (7, 1)])
def test_every_sample_has_its_moment(samples: int, most: int) -> None:
    found = moments(samples, most)
    assert len(found) == min(samples, most)
    assert [moment.first_sample for moment in found[1:]] == list(
        np.cumsum([moment.sample_count for moment in found])[:-1]
    )
    assert sum(moment.sample_count for moment in found) == samples
    counts = [moment.sample_count for moment in found]
    assert max(counts) - min(counts) <= 1
    # The mean time of all samples is the middle, whatever the number of moments.
    assert np.average([moment.time for moment in found], weights=counts) == pytest.approx(0.5)


CURVES = {
    "constant": np.ones_like,
    "opening": lambda t: t,
    "closing": lambda t: 1 - t,
    "round": lambda t: np.sqrt(np.maximum(1 - (2 * t - 1) ** 2, 0)),
    "late": lambda t: (t > 0.75).astype(float),
    "below zero": lambda t: np.maximum(np.sin(7 * t), 0),
}


@pytest.mark.parametrize("name", CURVES)
def test_moments_lie_in_equal_shares_of_the_light(name: str) -> None:
    """Each moment is the middle of its stratum: half of the stratum's light comes before it (by brute force)."""
    at = np.linspace(0, 1, CURVE_INTERVALS + 1)
    openness = CURVES[name](at)
    fine = np.linspace(0, 1, 1_000_001)
    come = np.cumsum(np.interp(fine, at, openness))
    come /= come[-1]
    found = moments(16, 16, list(openness))
    assert np.interp([moment.time for moment in found], fine, come) == pytest.approx(
        (np.arange(16) + 0.5) / 16, abs=2e-5
    )


@pytest.mark.parametrize("openness", [(0.0, 0.0), (-1.0, -2.0), (float("nan"), 0.0)])
def test_a_shutter_that_never_opens_counts_as_open(openness: tuple[float, float]) -> None:
    assert [moment.time for moment in moments(4, 4, openness)] == pytest.approx([0.125, 0.375, 0.625, 0.875])
