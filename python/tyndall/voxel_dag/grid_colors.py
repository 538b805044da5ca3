# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of voxels in OpenVDB's files: grids of three scene-linear numbers. A DAG has bytes, as sRGB encodes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall.linear_colours import linear_from_srgb, srgb_from_linear
from tyndall.volumes import LEAF_VOXELS, GridInfo, SparseGrid, read_vdb

from .checks import refuse

if TYPE_CHECKING:
    import os

    from numpy.typing import NDArray

    from tyndall._native import Progress

    from .dag import VoxelDag

#: Of a voxel while its colour is looked up: where it is, by its indices and by its leaf's, and the colour in floats.
BYTES_PER_VOXEL = 96

_LINEAR_OF_BYTE = linear_from_srgb(np.arange(256) / 255.0).astype(np.float32)
_BLOCK_BITS = 15  #: Of a leaf's place along a side of the largest DAG.


def linear_of(colors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """What a grid has for a DAG's colours: (k, 3)."""
    linear: NDArray[np.float32] = _LINEAR_OF_BYTE[colors]
    return linear


def voxels_of_blocks(origins: NDArray[np.int32], words: NDArray[np.uint64]) -> NDArray[np.uint32]:
    """What is set in blocks of 8 x 8 x 8, (k, 3): block by block, x slowest and z fastest."""
    bits = np.unpackbits(words.astype("<u8").view(np.uint8), axis=1, bitorder="little")
    block, place = np.nonzero(bits)
    within = np.stack([place >> 6, place >> 3 & 7, place & 7], axis=1)
    return (origins[block] + within).astype(np.uint32)


def read_colors(
    path: str | os.PathLike[str], info: GridInfo, memory_limit_bytes: int, progress: Progress
) -> list[SparseGrid]:
    """Red, green and blue of a grid of vectors. Raises InvalidInput for one of anything else, IoError, Cancelled."""
    read = read_vdb(path, [info.name], memory_limit_bytes=memory_limit_bytes, progress=progress)
    names = [f"{info.name}.{axis}" for axis in "xyz"]
    if not all(name in read for name in names):
        raise refuse(f'{path}: grid "{info.name}": it holds {info.value_type}, no colours: three numbers per voxel')
    return [read[name] for name in names]


def colored(
    dag: VoxelDag, channels: list[SparseGrid], first: NDArray[np.int64]
) -> tuple[NDArray[np.uint32], NDArray[np.uint8]]:
    """A DAG's voxels and their colours. ``first``: the grids' index of its voxel (0, 0, 0), multiples of 8."""
    lookups = [_Lookup(channel, first) for channel in channels]
    voxels, colors = [np.zeros((0, 3), np.uint32)], [np.zeros((0, 3), np.uint8)]
    for some in dag.coordinates():
        linear = np.stack([lookup.at(some) for lookup in lookups], axis=1)
        encoded = srgb_from_linear(np.clip(np.nan_to_num(linear), 0.0, 1.0))
        voxels.append(some)
        colors.append(np.rint(255 * encoded).astype(np.uint8))
    return np.concatenate(voxels), np.concatenate(colors)


class _Lookup:
    """A grid's numbers at voxels of a DAG."""

    def __init__(self, grid: SparseGrid, first: NDArray[np.int64]) -> None:
        blocks = (grid.leaf_origins - first) // LEAF_VOXELS
        is_near = ((blocks >= 0) & (blocks < 1 << _BLOCK_BITS)).all(axis=1)
        keys = _keys(blocks[is_near])
        order = np.argsort(keys)
        self._keys = keys[order]
        self._values = grid.leaf_values[is_near][order]
        self._background = np.float32(grid.background)

    def at(self, voxels: NDArray[np.uint32]) -> NDArray[np.float32]:
        result = np.full(len(voxels), self._background)
        if len(self._keys) == 0:
            return result
        blocks, within = np.divmod(voxels.astype(np.int64), LEAF_VOXELS)
        keys = _keys(blocks)
        leaf = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        is_there = self._keys[leaf] == keys
        x, y, z = within[is_there].T
        result[is_there] = self._values[leaf[is_there], x, y, z]
        return result


def _keys(blocks: NDArray[np.int64]) -> NDArray[np.int64]:
    x, y, z = blocks.astype(np.int64).T
    keys: NDArray[np.int64] = (x << 2 * _BLOCK_BITS) | (y << _BLOCK_BITS) | z
    return keys
