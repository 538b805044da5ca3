# SPDX-License-Identifier: GPL-3.0-or-later
"""What decides how voxels are made and stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from .textures import Textures


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
    #: (n, 3), uint8 or 0 to 1, as sRGB encodes them: of each vertex of a mesh, or of each voxel of a list.
    colors: ArrayLike | None = None
    #: (n, 3), of any length but 0, alike; "faces": those of a mesh's triangles, by the order of their corners.
    normals: ArrayLike | Literal["faces"] | None = None
    channels: Mapping[str, ArrayLike] | None = None  #: Up to 4 further values of 8 bits, (n,) each, by name.
    #: Colours, pictures and channels of a mesh's triangles; ``colors`` and ``channels`` of vertices are multiplied.
    textures: Textures | None = None
    #: Fill a mesh that closes. Voxels inside have no surface: not together with colours, normals or channels.
    solid: bool = False
    #: Colours are stored as they are, unless a palette of at most so many is asked for, or one in which no voxel's
    #: colour is further away than that, by CIE94 (1 is hardly seen side by side): one of both.
    color_count: int | None = None
    most_color_difference: float | None = None
    normal_bits: int = 32  #: [8, 32]: 0.64 degrees at most at 16, 0.0025 at 32.
