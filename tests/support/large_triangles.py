# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that has many voxels for its few triangles, and many alike: large at any resolution, small as a graph."""

from __future__ import annotations

import numpy as np


def large_triangles(count: int = 12, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Positions and triangles, each about as large as the whole, and about parallel."""
    random = np.random.default_rng(seed)
    corners = np.array([[0, 0, 0], [1, 0, 0.2], [0, 1, 0.3]]) + random.uniform(-0.1, 0.1, (count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)
