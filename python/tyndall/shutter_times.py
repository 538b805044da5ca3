# SPDX-License-Identifier: GPL-3.0-or-later
"""When a picture's samples are taken while a shutter is open: strata of the light that it lets through.

Based on: Haeberli and Akeley, The Accumulation Buffer, SIGGRAPH 1990.
Differs:  strata are equal in light and not in time, so that all samples weigh the same; the moments are their middles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: Intervals of a shutter's curve, each taken as a straight line; Cycles' table has as many entries.
CURVE_INTERVALS = 256


@dataclass(frozen=True, kw_only=True)
class Moment:
    """When, as a share of the shutter's time, and which samples of each pixel see it."""

    time: float  #: [0, 1]
    first_sample: int
    sample_count: int


def moments(pixel_samples: int, most: int, openness: Sequence[float] = (1.0, 1.0)) -> list[Moment]:
    """At most so many, in the order of time, of a shutter that is so far open at equal distances from 0 to 1.

    What is below 0 counts as closed; of a shutter that never opens, as one that is open all the time.
    """
    count = max(1, min(pixel_samples, most))
    firsts = [pixel_samples * index // count for index in range(count + 1)]
    middles = (np.array(firsts[:-1]) + np.array(firsts[1:])) / (2 * pixel_samples)
    times = _times_of(middles, np.maximum(np.nan_to_num(np.asarray(openness, np.float64)), 0.0))
    return [
        Moment(time=float(time), first_sample=first, sample_count=end - first)
        for time, first, end in zip(times, firsts[:-1], firsts[1:], strict=True)
    ]


def _times_of(shares: NDArray[np.float64], openness: NDArray[np.float64]) -> NDArray[np.float64]:
    """When so much of all the light has come."""
    at = np.linspace(0.0, 1.0, len(openness))
    of_intervals = (openness[:-1] + openness[1:]) / 2 * np.diff(at)
    total = of_intervals.sum()
    if not total > 0.0:
        return shares
    come = np.concatenate([[0.0], np.cumsum(of_intervals)]) / total
    interval = np.clip(np.searchsorted(come, shares, side="right") - 1, 0, len(of_intervals) - 1)
    # Within an interval the light that came is a parabola: start * x + (end - start) * x^2 / 2, in this form without
    # a difference of large numbers, also where start and end are equal.
    start, end = openness[interval], openness[interval + 1]
    wanted = (shares - come[interval]) * total * (len(openness) - 1)
    share_of_interval = 2.0 * wanted / (start + np.sqrt(np.maximum(start**2 + 2.0 * (end - start) * wanted, 0.0)))
    times: NDArray[np.float64] = at[interval] + np.clip(share_of_interval, 0.0, 1.0) / (len(openness) - 1)
    return times
