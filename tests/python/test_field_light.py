# SPDX-License-Identifier: GPL-3.0-or-later
"""What dense fields scatter along lines of sight, and how far off voxels make it, by closed forms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from tyndall.field_light import light_error, scattered_along

Values = Callable[[NDArray[np.float64]], NDArray[np.float32]]
SIGMA_T = 12.0  # per metre, of a field a metre wide: opaque to 6e-6


def test_even_fog_that_is_lit_from_the_side_scatters_what_reaches_each_line() -> None:
    """All that comes is scattered along a line of sight through opaque fog: exp(-depth of the light)."""
    side = 1.0 / 50
    parts = (np.full((rows, 50), SIGMA_T) for rows in (20, 29, 1))
    found = scattered_along(parts, side, side)
    edges = np.exp(-SIGMA_T * np.linspace(0.0, 1.0, 51))
    closed_form = (edges[:-1] - edges[1:]) / (SIGMA_T * side) * -np.expm1(-SIGMA_T)
    assert found == pytest.approx(closed_form, rel=1e-12)


def even(density: float) -> Values:
    def values(positions: NDArray[np.float64]) -> NDArray[np.float32]:
        return np.full(len(positions), density, np.float32)

    return values


@pytest.mark.parametrize("share", [0.8, 1.0, 1.25])
def test_voxels_of_a_share_of_the_density_are_off_by_the_closed_form(share: float) -> None:
    """exp(-share x) beside exp(-x) of all depths x."""
    counts, step = np.array([60, 40, 50]), np.array([1.0 / 60, 1.0 / 40, 1.0 / 50])
    error = light_error(even(1.0), even(share), np.array([-0.3, 0.2, 1.0]), step, counts, SIGMA_T)
    squares = 0.5 / share - 2.0 / (1.0 + share) + 0.5
    assert error.of_sum == pytest.approx(1.0 / share - 1.0, abs=2e-4)
    assert error.rms == pytest.approx(np.sqrt(squares / 0.5), abs=2e-3)


def test_a_field_that_scatters_nothing_is_not_off() -> None:
    counts = np.array([8, 8, 8])
    error = light_error(even(0.0), even(0.0), np.zeros(3), np.full(3, 0.1), counts, SIGMA_T)
    assert (error.of_sum, error.rms) == (0.0, 0.0)
