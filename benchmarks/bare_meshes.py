# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes that the tools around voxel DAGs are compared on, as support/voxel_meshes.hpp has them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from tyndall.mesh_files import TriangleMesh, read_mesh

_DATA = Path(os.environ.get("TYNDALL_SHARED_DATA", "../shared/data"))
#: Of Sponza_LowPoly.bin, as its .gltf states them: positions' offset and count, indices' offset and count, two meshes.
_SPONZA = ((0, 64806, 777672, 175905), (1129484, 4697, 1185848, 13347))


def bare_mesh(name: str) -> TriangleMesh:
    """``dragon`` or ``sponza``. Raises OSError where the file is absent."""
    if name == "dragon":
        return read_mesh(_DATA / "dragon/dragon_vrip.ply.gz")
    content = (_DATA / "sponza_lowpoly/Sponza_LowPoly.bin").read_bytes()
    positions, triangles, first = [], [], 0
    for position_offset, position_count, index_offset, index_count in _SPONZA:
        positions.append(np.frombuffer(content, "<f4", 3 * position_count, position_offset).reshape(-1, 3))
        triangles.append(
            np.frombuffer(content, "<u2", index_count, index_offset).reshape(-1, 3).astype(np.uint32) + first
        )
        first += position_count
    return np.concatenate(positions), np.concatenate(triangles)
