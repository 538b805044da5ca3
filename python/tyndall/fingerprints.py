# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells descriptions apart: a digest of all that makes a native scene; large parts stand by their keys."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from hashlib import blake2b
from typing import Any, Protocol

import numpy as np

from .heterogeneity import PaintedAir
from .scene_description import DensityGrid, Image, Instances, Mesh, Strands
from .voxel_dag import VoxelDag

ARRAYS_OF_INSTANCES = ("random", "particles", "instancer_values")  #: Or None.
#: What compares by ==.
PLAIN_OF_INSTANCES = [
    entry.name for entry in fields(Instances) if entry.name not in {"mesh", "world_from_object", *ARRAYS_OF_INSTANCES}
]


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
    elif isinstance(value, Instances):
        _feed_instances(digest, value)
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif isinstance(value, tuple):
        _feed_tuple(digest, value)
    elif is_dataclass(value):
        for entry in fields(value):
            _feed(digest, getattr(value, entry.name))
    else:
        digest.update(f"{value!r};".encode())


def _feed_tuple(digest: _Digest, value: tuple[object, ...]) -> None:
    digest.update(f"({len(value)}:".encode())
    if value and all(isinstance(item, str) for item in value):
        digest.update("\0".join(map(str, value)).encode())
        return
    for item in value:
        _feed(digest, item)


def _feed_instances(digest: _Digest, value: Instances) -> None:
    """At once: a scene may have 100,000 groups."""
    plain = [getattr(value, name) for name in PLAIN_OF_INSTANCES]
    arrays = [getattr(value, name) for name in ARRAYS_OF_INSTANCES]
    shapes = [None if array is None else array.shape for array in arrays]
    digest.update(f"<{value.mesh.key}>{plain!r}{value.world_from_object.shape}{shapes}".encode())
    digest.update(np.ascontiguousarray(value.world_from_object, np.float64).data)
    for array in arrays:
        if array is not None:
            digest.update(np.ascontiguousarray(array, np.float32).data)
