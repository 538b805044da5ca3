# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse grids of numbers in space: what OpenVDB files hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .scene_description import FloatArray

LEAF_VOXELS = 8  #: Voxels per side of a leaf, as in OpenVDB.


@dataclass(frozen=True, kw_only=True, eq=False)
class SparseGrid:
    """A scalar per voxel; outside of the leaves it is the background."""

    name: str
    leaf_origins: NDArray[np.int32]  #: (n, 3): index x, y, z of each leaf's first voxel, multiples of LEAF_VOXELS.
    leaf_values: FloatArray  #: (n, 8, 8, 8), by x, y, z.
    local_from_index: NDArray[np.float64]  #: (4, 4): metres of the object's space; a voxel's centre has its index.
    background: float = 0.0
