# SPDX-License-Identifier: GPL-3.0-or-later
"""What decides how voxels are made and stored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from numpy.typing import ArrayLike


@dataclass(frozen=True, kw_only=True)
class Config:
    """How a mesh becomes voxels, and how these are stored."""

    resolution: int = 1024  #: Voxels a side, a power of two in [4, 131072].
    #: "thin": 6-separating, no way leads through a closed surface from face to face of voxels; "conservative": every
    #: voxel that the mesh touches.
    rule: Literal["thin", "conservative"] = "thin"
    #: Lower and upper corner of the cube that is voxelized, in metres; None: from the lowest corner of the mesh's box,
    #: as long as its longest side.
    bounds_m: ArrayLike | None = None
    symmetry: Literal["none", "reflections", "cube"] = "cube"  #: What may turn a subtree that is stored once.
    memory_budget_bytes: int | None = None  #: Of the voxels, and of the graph's tables; None: no limit.
