# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted volumes in tiles, as a .blend keeps them: 16^3 voxels each, half floats, compressed.

A tile in which nothing is painted is not kept. Arrays are float32 ``(nz, ny, nx)``; x runs fastest, in tiles, too.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .scene_description import FloatArray

TILE_VOXELS = 16  #: Per side; the last tile along an axis ends where the volume ends.
#: Of zlib: the fastest. Smooth paint shrinks to a fifth, and 9 would save another tenth for ten times the time.
_COMPRESSION = 1
_ESCAPE, _IS_ESCAPE = b"\x01", b"\x02"

Resolution = tuple[int, int, int]  #: Voxels along x, y and z.


def local_from_index(resolution: Resolution, local_from_unit: ArrayLike) -> NDArray[np.float64]:
    """(4, 4): a voxel's centre has its index, x first; the volume is [0, 1]^3 of ``local_from_unit``."""
    counts = np.array(resolution, np.float64)
    unit_from_index = np.diag([*(1.0 / counts), 1.0])
    unit_from_index[:3, 3] = 0.5 / counts
    return np.asarray(local_from_unit, np.float64) @ unit_from_index


@dataclass(frozen=True, kw_only=True)
class VolumeKind:
    """What a painted volume may hold, and what it holds where nothing is painted."""

    neutral: float
    lowest: float
    highest: float


#: By the names that ``heterogeneity.PaintedAir`` has for them.
VOLUME_KINDS = {
    "amount": VolumeKind(neutral=0.0, lowest=-1.0, highest=1.0),
    "level": VolumeKind(neutral=0.0, lowest=-8.0, highest=8.0),
    "intensity": VolumeKind(neutral=1.0, lowest=0.0, highest=1000.0),
}


def tile_counts(shape: tuple[int, ...]) -> tuple[int, int, int]:
    """Tiles along z, y and x of an array of this shape."""
    nz, ny, nx = (-(-voxels // TILE_VOXELS) for voxels in shape)
    return nz, ny, nx


def tile_count(shape: tuple[int, ...]) -> int:
    """Of an array of this shape."""
    nz, ny, nx = tile_counts(shape)
    return nz * ny * nx


def tile_block(index: int, shape: tuple[int, ...]) -> tuple[slice, slice, slice]:
    """The voxels of a tile: what to index an array with."""
    _, ny, nx = tile_counts(shape)
    place = index // (ny * nx), index // nx % ny, index % nx
    z, y, x = (
        slice(at * TILE_VOXELS, min((at + 1) * TILE_VOXELS, voxels)) for at, voxels in zip(place, shape, strict=True)
    )
    return z, y, x


def tiles_in(block: tuple[slice, slice, slice], shape: tuple[int, ...]) -> set[int]:
    """Indices of the tiles that hold voxels of a block."""
    if any(part.start >= part.stop for part in block):
        return set()
    _, ny, nx = tile_counts(shape)
    z, y, x = (range(part.start // TILE_VOXELS, (part.stop - 1) // TILE_VOXELS + 1) for part in block)
    return {(at_z * ny + at_y) * nx + at_x for at_z, at_y, at_x in product(z, y, x)}


def packed(voxels: FloatArray) -> bytes:
    """A tile's voxels as they are kept: to 11 bits.

    Without a zero byte, at which library overrides (Blender 3.4 to 5.0, measured) cut a string: each becomes two of
    _ESCAPE, and an _ESCAPE is marked as one. That makes it 0.8 % longer.
    """
    compressed = zlib.compress(voxels.astype("<f2").tobytes(), _COMPRESSION)
    return compressed.replace(_ESCAPE, _ESCAPE + _IS_ESCAPE).replace(b"\x00", _ESCAPE * 2)


def unpacked(kept: bytes, shape: tuple[int, ...]) -> FloatArray:
    """What was packed. Raises ValueError if that was no tile of this shape."""
    compressed = kept.replace(_ESCAPE * 2, b"\x00").replace(_ESCAPE + _IS_ESCAPE, _ESCAPE)
    try:
        halves = np.frombuffer(zlib.decompress(compressed), "<f2")
    except zlib.error as error:
        raise ValueError(f"a tile is damaged: {error}") from error
    if halves.size != np.prod(shape):
        raise ValueError(f"a tile has {halves.size} voxels instead of {' x '.join(map(str, shape))}")
    return halves.astype(np.float32).reshape(shape)


def as_kept(voxels: FloatArray, kind: VolumeKind) -> FloatArray:
    """Clamped and rounded to what a tile can hold: kept and read again, they are the same."""
    kept: FloatArray = np.clip(voxels, kind.lowest, kind.highest).astype(np.float16).astype(np.float32)
    return kept


def resampled(values: FloatArray, resolution: Resolution) -> FloatArray:
    """At another resolution: linear between the voxels' centres, averaged where it gets coarser.

    Beyond the outermost centres it is as there.
    """
    for axis, wanted in enumerate(reversed(resolution)):
        if values.shape[axis] != wanted:
            weights = _weights(values.shape[axis], wanted)
            values = np.moveaxis(np.tensordot(weights, values, axes=(1, axis)), 0, axis)
    return np.ascontiguousarray(values, np.float32)


def _weights(given: int, wanted: int) -> FloatArray:
    """(wanted, given), rows add up to 1: a triangle as wide as the larger voxels."""
    centres = (np.arange(wanted) + 0.5) * (given / wanted) - 0.5
    distances = np.abs(np.clip(centres, 0.0, given - 1.0)[:, None] - np.arange(given))
    weights = np.maximum(1.0 - distances / max(1.0, given / wanted), 0.0)
    normalised: FloatArray = (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)
    return normalised
