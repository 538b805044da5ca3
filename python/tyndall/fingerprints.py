# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells descriptions apart: a digest of all that makes a native scene; large parts stand by their keys."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from hashlib import blake2b
from typing import Any, Protocol

import numpy as np

from .heterogeneity import PaintedAir
from .scene_description import DensityGrid, Image, Mesh, Strands
from .voxel_dag import VoxelDag


class _Digest(Protocol):
    def update(self, data: Any, /) -> None: ...  # noqa: ANN401 - anything with a buffer


def fingerprint(value: object) -> bytes:
    """Equal for descriptions that give the same native scene. Meshes, images, grids, voxels, hair, air: by keys."""
    digest = blake2b(digest_size=16)
    _feed(digest, value)
    return digest.digest()


def _feed(digest: _Digest, value: object) -> None:
    if isinstance(value, Mesh | Image | DensityGrid | Strands):
        digest.update(f"<{value.key}>".encode())
    elif isinstance(value, VoxelDag):
        digest.update(f"<voxels {value.key}>".encode())
    elif isinstance(value, PaintedAir):
        _feed(digest, (value.key, value.world_from_unit))
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif isinstance(value, tuple):
        digest.update(f"({len(value)}:".encode())
        if value and all(isinstance(item, str) for item in value):
            digest.update("\0".join(value).encode())
            return
        for item in value:
            _feed(digest, item)
    elif is_dataclass(value):
        for entry in fields(value):
            _feed(digest, getattr(value, entry.name))
    else:
        digest.update(f"{value!r};".encode())
