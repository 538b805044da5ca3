# SPDX-License-Identifier: GPL-3.0-or-later
"""Hosek's and Wilkie's sky: its formula, and its coefficients at a sun's elevation, a turbidity and a ground's albedo.

Based on: Hosek and Wilkie 2012, An Analytic Model for Full Spectral Sky-Dome Radiance; how blender/cycles v4.5.0,
          kernel/svm/sky.h, keeps its angles within what it is made for.
Differs:  the coefficients' control values were measured (tests/support/fit_hosek_sky.py).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

#: Of the shape, in the paper's order, and the radiance that it is multiplied by.
NAMES = ("A", "B", "C", "D", "E", "F", "G", "H", "I", "L")
#: The lowest directions that have a sky of their own.
LOWEST_COSINE = math.sin(0.001)


def bezier_weights(elevation_deg: ArrayLike) -> NDArray[np.float64]:
    """(..., 6): of the control values, even in the cube root of the elevation."""
    at = np.cbrt(np.clip(np.asarray(elevation_deg, np.float64) / 90.0, 0.0, 1.0))
    return np.stack([math.comb(5, k) * at**k * (1.0 - at) ** (5 - k) for k in range(6)], axis=-1)


def coefficients(
    turbidity: float, albedo: float, elevation_deg: float, table: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """(10, 3): per name, of X, Y and Z. Linear in albedo and between whole turbidities."""
    table = control_values() if table is None else table
    turbidity = min(max(turbidity, 1.0), 10.0)
    lower = min(int(turbidity), 9)
    share = turbidity - lower
    of_both = (1.0 - share) * table[lower - 1] + share * table[lower]
    of_ground = (1.0 - albedo) * of_both[0] + albedo * of_both[1]  # (3, 10, 6)
    found: NDArray[np.float64] = (of_ground @ bezier_weights(elevation_deg)).T
    return found


def sky_xyz(found: NDArray[np.float64], up: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3): by the cosine of the angle to the zenith, and the angle to the sun."""
    a, b, c, d, e, f, g, h, i, radiance = found
    up, angle = np.maximum(up, LOWEST_COSINE)[..., None], angle[..., None]
    cosine = np.cos(angle)
    glow = (1.0 + cosine**2) / (1.0 + h * h - 2.0 * h * cosine) ** 1.5
    shape = c + d * np.exp(e * angle) + f * cosine**2 + g * glow + i * np.sqrt(up)
    xyz: NDArray[np.float64] = (1.0 + a * np.exp(b / (up + 0.01))) * shape * radiance
    return xyz


@lru_cache(maxsize=1)
def control_values() -> NDArray[np.float64]:
    """(10 turbidities, 2 albedos, X Y Z, 10 coefficients, 6)."""
    from .hosek_sky_table import CONTROL_VALUES  # large

    return np.array(CONTROL_VALUES.split(), np.float64).reshape(10, 2, 3, len(NAMES), 6)
