# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse grids of numbers in space, and the OpenVDB files that hold them.

``_volume_io``, which carries OpenVDB, is loaded by the first call that opens a file: a grid in memory needs none.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .scene_description import FloatArray

if TYPE_CHECKING:
    from ._native import Progress

LEAF_VOXELS = 8  #: Voxels per side of a leaf, as in OpenVDB.
MEMORY_LIMIT_BYTES = 4 << 30  #: Of the leaves that one call reads.

Index = tuple[int, int, int]


@dataclass(frozen=True, kw_only=True, eq=False)
class SparseGrid:
    """A scalar per voxel; outside of the leaves it is the background. None at all is a grid like any other."""

    name: str
    leaf_origins: NDArray[np.int32]  #: (n, 3): index x, y, z of each leaf's first voxel, multiples of LEAF_VOXELS.
    leaf_values: FloatArray  #: (n, 8, 8, 8), by x, y, z.
    local_from_index: NDArray[np.float64]  #: (4, 4): metres of the object's space; a voxel's centre has its index.
    background: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class GridInfo:
    """What a file says of a grid without reading its voxels."""

    name: str  #: Two of one name are "density" and "density[1]".
    value_type: str  #: OpenVDB's: "float", "double", "int32", "bool", "vec3s", ...
    grid_class: str  #: "fog volume", "level set", "staggered" or "unknown".
    is_half: bool  #: Real numbers are stored with 16 bits.
    active_voxel_count: int  #: Those of constant tiles included.
    bounds: (
        tuple[Index, Index] | None
    )  #: First and last index of the active voxels, both inclusive; None: there is none.
    local_from_index: NDArray[np.float64] | None  #: (4, 4); None: the grid lies in a frustum.
    refusal: str  #: Why ``read_vdb`` would refuse it; "" if it would not.


def grid_infos(path: str | os.PathLike[str], progress: Progress | None = None) -> list[GridInfo]:
    """The grids of an OpenVDB file, in its order. Raises IoError, which names path and grid, and Cancelled."""
    from . import _native, _volume_io  # noqa: PLC0415 - see the module's docstring

    listed, _ = _volume_io.list_grids(path, progress or _native.Progress())
    infos = []
    for grid in listed:
        first, last = grid.pop("first_index"), grid.pop("last_index")
        is_empty = any(end < begin for begin, end in zip(first, last, strict=True))
        infos.append(GridInfo(bounds=None if is_empty else (first, last), **grid))
    return infos


def read_vdb(
    path: str | os.PathLike[str],
    names: Iterable[str] | None = None,
    *,
    memory_limit_bytes: int = MEMORY_LIMIT_BYTES,
    progress: Progress | None = None,
) -> dict[str, SparseGrid]:
    """The grids of these names, or all that can be read, by name and in the order of the file.

    Numbers of any type become float32. A grid of vectors, "velocity", becomes three: "velocity.x", "velocity.y" and
    "velocity.z". Constant tiles become leaves; leaves ascend by origin. A grid may have none. Raises InvalidInput for a
    name that the file does not have, for a grid that holds something else or lies in a frustum, and where the leaves
    would need more than the limit; IoError for a file that is missing or damaged; Cancelled.
    """
    from . import _native, _volume_io  # noqa: PLC0415 - see the module's docstring

    wanted = None if names is None else list(names)
    read = _volume_io.read_grids(path, wanted, memory_limit_bytes, progress or _native.Progress())
    return {
        name: SparseGrid(
            name=name,
            leaf_origins=origins,
            leaf_values=values,
            local_from_index=local_from_index,
            background=background,
        )
        for name, origins, values, local_from_index, background in read
    }


def write_vdb(
    path: str | os.PathLike[str],
    grids: Iterable[SparseGrid],
    *,
    is_half: bool = False,
    metadata: Mapping[str, str] | None = None,
    progress: Progress | None = None,
) -> None:
    """Write fog volumes: whole or not at all, exactly unless ``is_half``, which keeps 11 bits up to 65504.

    Voxels whose bits differ from the background's are active. Raises InvalidInput, which names the grid, for names that
    are empty or the same, leaves that overlap, matrices without an inverse and what a half float cannot hold; IoError
    for a folder that cannot be written to and a full disk; Cancelled.
    """
    from . import __version__, _native, _volume_io  # noqa: PLC0415 - see the module's docstring

    leaves = [
        (
            grid.name,
            np.ascontiguousarray(grid.leaf_origins),
            np.ascontiguousarray(grid.leaf_values),
            np.ascontiguousarray(grid.local_from_index),
            grid.background,
        )
        for grid in grids
    ]
    of_file = {"creator": f"Tyndall {__version__}", **(metadata or {})}
    _volume_io.write_grids(path, leaves, is_half, of_file, progress or _native.Progress())


def from_dense(
    name: str,
    values: FloatArray,
    local_from_index: NDArray[np.float64],
    *,
    first_index: Index = (0, 0, 0),
    background: float = 0.0,
) -> SparseGrid:
    """A grid of an array (nx, ny, nz) whose first value has the index ``first_index``, less leaves of background."""
    origin = np.array(first_index, np.int64) // LEAF_VOXELS * LEAF_VOXELS
    before = np.array(first_index, np.int64) - origin
    after = -(before + values.shape) % LEAF_VOXELS
    padding = list(zip(before, after, strict=True))
    padded = np.pad(values.astype(np.float32), padding, constant_values=np.float32(background))
    counts = np.array(padded.shape) // LEAF_VOXELS
    blocks = padded.reshape(counts[0], LEAF_VOXELS, counts[1], LEAF_VOXELS, counts[2], LEAF_VOXELS)
    leaves = blocks.transpose(0, 2, 4, 1, 3, 5)
    # Bits, as in a file: -0 is not a background of 0, and a background that is no number equals itself.
    is_background = leaves.view(np.uint32) == np.float32(background).view(np.uint32)
    kept = np.argwhere(~is_background.all(axis=(3, 4, 5)))
    return SparseGrid(
        name=name,
        leaf_origins=(origin + kept * LEAF_VOXELS).astype(np.int32),
        leaf_values=np.ascontiguousarray(leaves[tuple(kept.T)]),
        local_from_index=np.array(local_from_index, np.float64),
        background=background,
    )


def to_dense(grid: SparseGrid, bounds: tuple[Index, Index] | None = None) -> tuple[FloatArray, Index]:
    """All values between two indices, the first inclusive and the last exclusive, (nx, ny, nz), and the first index.

    Without bounds: those of the leaves. Raises ValueError for a grid without leaves then, because it has none.
    """
    leaves = grid.leaf_origins.astype(np.int64) // LEAF_VOXELS
    if bounds is None:
        if len(leaves) == 0:
            raise ValueError(f'grid "{grid.name}" has no leaves, and so no bounds')
        first, last = leaves.min(axis=0) * LEAF_VOXELS, (leaves.max(axis=0) + 1) * LEAF_VOXELS
    else:
        first, last = (np.array(index, np.int64) for index in bounds)
    first_leaf = first // LEAF_VOXELS
    counts = np.maximum(-(-last // LEAF_VOXELS) - first_leaf, 0)
    blocks = np.full((*counts, LEAF_VOXELS, LEAF_VOXELS, LEAF_VOXELS), grid.background, np.float32)
    places = leaves - first_leaf
    is_inside = ((places >= 0) & (places < counts)).all(axis=1)
    blocks[tuple(places[is_inside].T)] = grid.leaf_values[is_inside]
    dense = blocks.transpose(0, 3, 1, 4, 2, 5).reshape(counts * LEAF_VOXELS)
    begin, end = first - first_leaf * LEAF_VOXELS, last - first_leaf * LEAF_VOXELS
    cut = tuple(slice(*axis) for axis in zip(begin, np.maximum(end, begin), strict=True))
    return np.ascontiguousarray(dense[cut]), (int(first[0]), int(first[1]), int(first[2]))


def values_at(grid: SparseGrid, indices: NDArray[np.int64]) -> FloatArray:
    """Voxels of a grid, (n,), by their indices, (n, 3); the background outside of its leaves."""
    values = np.full(len(indices), grid.background, np.float32)
    if len(grid.leaf_origins) == 0:
        return values
    leaves = grid.leaf_origins.astype(np.int64) // LEAF_VOXELS
    first, counts = leaves.min(axis=0), np.ptp(leaves, axis=0) + 1
    wanted = indices // LEAF_VOXELS - first
    is_near = ((wanted >= 0) & (wanted < counts)).all(axis=1)

    def number(places: NDArray[np.int64]) -> NDArray[np.int64]:
        numbers: NDArray[np.int64] = (places[:, 0] * counts[1] + places[:, 1]) * counts[2] + places[:, 2]
        return numbers

    known = number(leaves - first)
    order = np.argsort(known)
    near = np.flatnonzero(is_near)
    sought = number(wanted[near])
    leaf = order[np.minimum(np.searchsorted(known, sought, sorter=order), len(order) - 1)]
    is_there = known[leaf] == sought
    found, leaf = near[is_there], leaf[is_there]
    x, y, z = (indices[found] % LEAF_VOXELS).T
    values[found] = grid.leaf_values[leaf, x, y, z]
    return values
