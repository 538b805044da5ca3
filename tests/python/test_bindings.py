# SPDX-License-Identifier: GPL-3.0-or-later
"""What crosses into native code is checked once, and the argument that is wrong is named."""

from __future__ import annotations

import numpy as np
import pytest

from tyndall import Cancelled, InvalidInput, IoError, Progress, _native


def mesh(positions: np.ndarray, triangles: np.ndarray, progress: Progress | None = None) -> _native.TriangleMesh:
    return _native.TriangleMesh("m", positions, triangles, None, None, [], progress or Progress())


POSITIONS = np.eye(3, dtype=np.float32)
TRIANGLES = np.array([[0, 1, 2]], dtype=np.uint32)


def test_errors_are_pythons_own_kinds() -> None:
    assert issubclass(InvalidInput, ValueError)
    assert issubclass(IoError, OSError)
    assert issubclass(Cancelled, Exception)


@pytest.mark.parametrize(
    "positions",
    [
        POSITIONS.astype(np.float64),
        POSITIONS.ravel(),
        np.zeros((3, 4), dtype=np.float32),
        np.zeros((3, 6), dtype=np.float32)[:, ::2],
    ],
    ids=["dtype", "dimensions", "width", "stride"],
)
def test_an_array_of_another_kind_is_refused_by_its_name(positions: np.ndarray) -> None:
    with pytest.raises(TypeError, match=r"^positions must be a C-contiguous float32 array of shape \(n, 3\), not "):
        mesh(positions, TRIANGLES)


def test_a_wrong_value_in_a_right_array_is_refused_by_the_meshs_name() -> None:
    with pytest.raises(InvalidInput, match="m"):
        mesh(POSITIONS, TRIANGLES + np.uint32(7))


def test_degenerate_triangles_are_dropped_and_counted() -> None:
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0]], dtype=np.float32)
    triangles = np.array([[0, 1, 2], [0, 0, 1], [0, 1, 3]], dtype=np.uint32)
    native = mesh(positions, triangles)
    assert (native.triangle_count, native.degenerate_triangle_count, native.non_finite_triangle_count) == (1, 1, 1)


def test_arrays_are_copied_in() -> None:
    positions = POSITIONS.copy()
    native = mesh(positions, TRIANGLES)
    positions[:] = 100
    assert native.bounds_m == [[0, 0, 0], [1, 1, 1]]


def test_a_cancelled_progress_stops_a_call() -> None:
    progress = Progress()
    progress.cancel()
    with pytest.raises(Cancelled):
        mesh(POSITIONS, TRIANGLES, progress)


def test_progress_never_goes_back() -> None:
    progress = Progress()
    progress.advance_to(0.5)
    progress.advance_to(0.25)
    progress.message = "Embree"
    assert (progress.fraction, progress.message) == (0.5, "Embree")
    assert progress.remaining_s == pytest.approx(progress.elapsed_s, rel=0.5)


def test_kernels_run_on_the_instruction_set_that_lives() -> None:
    """The baseline is on every CPU; after it the next one may be forced, and what a CPU lacks is named."""
    for _ in range(2):
        forced = _native.ForcedSimdTarget("SSE4")
        del forced
    with pytest.raises(InvalidInput, match="this CPU has no MMX"):
        _native.ForcedSimdTarget("MMX")
