# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the light that a dense field scatters is off where voxels stand for it.

Based on: single scattering in planes through the field, lit along one axis and seen along another, of the program's own
          values and of those between voxels, at three places to a voxel.
Differs:  light that enters dense fog scatters in its outermost free paths: an error of density there counts, and one
          deep inside does not, so that the density's own error may be above or below this one.
Bound:    27 evaluations per voxel of a slice, a million at a time. What places three to a voxel do not tell apart is
          not seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from numpy.typing import NDArray

    Values = Callable[[NDArray[np.float64]], NDArray[np.float32]]

_PER_VOXEL = 3  #: Places along a voxel's side.
_PLACES_AT_ONCE = 1 << 20
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
        plane = _Plane(axis, float(lower[axis] + upright[axis] * step[axis] * counts[axis]), lower, step, counts)
        for values, light in ((program, expected), (voxels, found)):
            sigma = (sigma_t * rows.astype(np.float64) for rows in plane.rows_of(values))
            light.append(scattered_along(sigma, step[seen] / _PER_VOXEL, step[lit] / _PER_VOXEL))
    truth, error = np.concatenate(expected), np.concatenate(found) - np.concatenate(expected)
    if not truth.any():
        return LightError(0.0, 0.0)
    return LightError(float(error.sum() / truth.sum()), float(np.sqrt((error**2).sum() / (truth**2).sum())))


@dataclass(frozen=True)
class _Plane:
    """Upright to an axis of the voxels, seen along the next and lit along the one after."""

    axis: int
    at: float
    lower: NDArray[np.float64]
    step: NDArray[np.float64]
    counts: NDArray[np.int64]

    def rows_of(self, values: Values) -> Iterator[NDArray[np.float32]]:
        """Values at its places, so many rows at a time along the axis on which it is seen."""
        seen, lit = (self._along((self.axis + way) % 3) for way in (1, 2))
        rows = max(_PLACES_AT_ONCE // len(lit), 1)
        for first in range(0, len(seen), rows):
            these = seen[first : first + rows]
            places = np.empty((len(these), len(lit), 3))
            places[..., self.axis] = self.at
            places[..., (self.axis + 1) % 3] = these[:, np.newaxis]
            places[..., (self.axis + 2) % 3] = lit
            yield values(places.reshape(-1, 3)).reshape(places.shape[:2])

    def _along(self, axis: int) -> NDArray[np.float64]:
        count = int(_PER_VOXEL * self.counts[axis])
        places: NDArray[np.float64] = self.lower[axis] + (np.arange(count) + 0.5) * (self.step[axis] / _PER_VOXEL)
        return places


def scattered_along(sigma: Iterable[NDArray[np.float64]], seen_step: float, lit_step: float) -> NDArray[np.float64]:
    """Of light along the second axis, per row of the first, seen along that: shares of a plane that scatters all.

    ``sigma`` comes in parts along the first axis and is even within a place: there the sum is exact.
    """
    found = passed = np.zeros(1)
    for part in sigma:
        seen, lit = part * seen_step, part * lit_step
        before = passed + np.cumsum(seen, axis=0) - seen + np.cumsum(lit, axis=1) - lit
        within = _mean_transmittance(seen) * _mean_transmittance(lit)
        found = found + (seen * within * np.exp(-np.minimum(before, _OPAQUE))).sum(axis=0)
        passed = passed + seen.sum(axis=0)
    return found


def _mean_transmittance(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.divide(-np.expm1(-depth), depth, out=np.ones_like(depth), where=depth > 0.0)
