# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors of a length of 1. No bpy here."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def unit_vectors(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Along the last axis, (..., n); what has no length stays 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: NDArray[np.float64] = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)
    return unit
