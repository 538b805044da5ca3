# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the light that a dense field scatters is off where voxels stand for it.

Based on: single scattering in planes through the field, lit along one axis and seen along another, of the program's own
          values and of those between voxels, at three places to a voxel.
Differs:  light that enters dense fog scatters in its outermost free paths: an error of density there counts, and one
          deep inside does not, so that the density's own error may be above or below this one.
Bound:    27 evaluations per voxel of a slice. What places three to a voxel do not tell apart is not seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Values = Callable[[NDArray[np.float64]], NDArray[np.float32]]

_PER_VOXEL = 3  #: Places along a voxel's side.
_OPAQUE = 700.0  #: exp() of more is 0.


@dataclass(frozen=True)
class LightError:
    """Relative: of the sum of all lines of sight, and RMS from line to line."""

    of_sum: float
    rms: float


def light_error(
    program: Values,
    voxels: Values,
    lower: NDArray[np.float64],
    step: NDArray[np.float64],
    counts: NDArray[np.int64],
    sigma_t: float,
) -> LightError:
    """``lower``, ``step`` and ``counts`` of the voxels; ``sigma_t`` per unit of ``step`` at a density of 1."""
    upright = np.random.default_rng(2).random(3)
    expected: list[NDArray[np.float64]] = []
    found: list[NDArray[np.float64]] = []
    for axis in range(3):
        seen, lit = (axis + 1) % 3, (axis + 2) % 3
        along = [(np.arange(_PER_VOXEL * counts[way]) + 0.5) * step[way] / _PER_VOXEL for way in (seen, lit)]
        places = np.empty((len(along[0]), len(along[1]), 3))
        places[..., seen], places[..., lit] = lower[seen] + along[0][:, np.newaxis], lower[lit] + along[1]
        places[..., axis] = lower[axis] + upright[axis] * step[axis] * counts[axis]
        sides = step[seen] / _PER_VOXEL, step[lit] / _PER_VOXEL
        for values, light in ((program, expected), (voxels, found)):
            sigma = sigma_t * values(places.reshape(-1, 3)).reshape(places.shape[:2]).astype(np.float64)
            light.append(scattered_along(sigma, *sides))
    truth, error = np.concatenate(expected), np.concatenate(found) - np.concatenate(expected)
    if not truth.any():
        return LightError(0.0, 0.0)
    return LightError(float(error.sum() / truth.sum()), float(np.sqrt((error**2).sum() / (truth**2).sum())))


def scattered_along(sigma: NDArray[np.float64], seen_step: float, lit_step: float) -> NDArray[np.float64]:
    """Of light along the second axis, per row of the first, seen along that: shares of a plane that scatters all.

    ``sigma`` is even within a place: there the sum is exact.
    """
    seen, lit = sigma * seen_step, sigma * lit_step
    before = np.cumsum(seen, axis=0) - seen + np.cumsum(lit, axis=1) - lit
    within = _mean_transmittance(seen) * _mean_transmittance(lit)
    found: NDArray[np.float64] = (seen * within * np.exp(-np.minimum(before, _OPAQUE))).sum(axis=0)
    return found


def _mean_transmittance(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.divide(-np.expm1(-depth), depth, out=np.ones_like(depth), where=depth > 0.0)
