# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids that a program makes of others, voxel by voxel.

Based on: a shader's coefficients are what its program gives for the grids' values at a place.
Differs:  the program is asked at voxels, and what it gives is interpolated between them, where a renderer that asks
          at each step interpolates what the program reads: where it bends within a voxel the two differ there.
Bound:    one evaluation per voxel of the leaves that any of the grids has; 4 bytes per voxel, 100 while a part is made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import InvalidInput
from .fingerprints import fingerprint
from .program_points import values_of
from .scene_description import DensityGrid, attribute_maps
from .volumes import LEAF_VOXELS, SparseGrid

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from .program_points import PointPlace
    from .scene_description import Material

    FloatArray = NDArray[np.float32]

_LEAVES_AT_ONCE = 1024
_WITHIN = np.indices((LEAF_VOXELS,) * 3).reshape(3, -1).T


def combined_key(program: Material, place: PointPlace, grids: Mapping[str, tuple[DensityGrid, ...]]) -> str:
    """Equal where the grids are. ``grids``: by the names that the program knows; of vectors, one for each number."""
    return f"made {fingerprint((program, place.read_by(program), tuple(sorted(grids.items())))).hex()}"


def combined(
    program: Material,
    place: PointPlace,
    grids: Mapping[str, tuple[DensityGrid, ...]],
    channels: Sequence[int],
    voxel_shift: float,
    notes: list[str],
    poll: Callable[[], None],
) -> list[SparseGrid]:
    """Channels of what the program gives in the leaves of the grids; ``poll`` may raise between parts.

    ``voxel_shift``: voxels by which it is asked off their places, along each axis, as they will be drawn. Outside of a
    grid's leaves it is 0. Raises InvalidInput for grids whose voxels are not the same, and IoError of textures that lie
    in a file.
    """
    parts = [part.grid for of_name in grids.values() for part in of_name]
    local_from_index = parts[0].local_from_index
    for part in parts:
        if not np.allclose(
            part.local_from_index, local_from_index, rtol=1e-5, atol=1e-6 * np.abs(local_from_index).max()
        ):
            raise InvalidInput(f'its grids "{parts[0].name}" and "{part.name}" have other voxels: resample one of them')
    origins, row = np.unique(np.concatenate([part.leaf_origins for part in parts]), axis=0, return_inverse=True)
    leaves_of = _leaf_of_each_row(parts, row.ravel(), len(origins))
    values_at = values_of(program, place, notes)
    found = np.empty((len(channels), len(origins), LEAF_VOXELS**3), np.float32)
    for first in range(0, len(origins), _LEAVES_AT_ONCE):
        poll()
        some = slice(first, min(first + _LEAVES_AT_ONCE, len(origins)))
        indices = (origins[some, None] + _WITHIN).reshape(-1, 3) + voxel_shift
        positions = indices @ local_from_index[:3, :3].T + local_from_index[:3, 3]
        read = [_values(part, leaf[some]) for part, leaf in zip(parts, leaves_of, strict=True)]
        values = values_at(positions, _uv_maps(grids, read))
        for into, channel in zip(found, channels, strict=True):
            into[some] = values[:, channel].reshape(-1, LEAF_VOXELS**3)
    return [_sparse(" and ".join(grids), origins, values, local_from_index) for values in found]


def _sparse(
    name: str, origins: NDArray[np.int32], values: FloatArray, local_from_index: NDArray[np.float64]
) -> SparseGrid:
    is_kept = values.any(axis=1)
    return SparseGrid(
        name=name,
        leaf_origins=np.ascontiguousarray(origins[is_kept], np.int32),
        leaf_values=values[is_kept].reshape(-1, *(LEAF_VOXELS,) * 3),
        local_from_index=local_from_index,
    )


def _leaf_of_each_row(parts: list[SparseGrid], row: NDArray[np.int64], row_count: int) -> list[NDArray[np.int64]]:
    """Of each grid: which of its leaves has the origin of each row; -1: none."""
    found, first = [], 0
    for part in parts:
        leaf = np.full(row_count, -1)
        leaf[row[first : first + len(part.leaf_origins)]] = np.arange(len(part.leaf_origins))
        found.append(leaf)
        first += len(part.leaf_origins)
    return found


def _values(part: SparseGrid, leaf: NDArray[np.int64]) -> FloatArray:
    result = np.zeros((len(leaf), LEAF_VOXELS**3), np.float32)
    is_there = leaf >= 0
    result[is_there] = part.leaf_values[leaf[is_there]].reshape(-1, LEAF_VOXELS**3)
    return result.ravel()


def _uv_maps(grids: Mapping[str, tuple[DensityGrid, ...]], read: list[FloatArray]) -> dict[str, FloatArray]:
    """As a program reads attributes: a number is a colour of three equal parts."""
    maps, first = {}, 0
    for name, of_name in grids.items():
        channels = [read[first + (channel if len(of_name) > 1 else 0)] for channel in range(3)]
        red_green, blue_alpha = attribute_maps(name)
        maps[red_green] = np.stack(channels[:2], axis=1)
        maps[blue_alpha] = np.stack([channels[2], np.ones_like(channels[2])], axis=1)
        first += len(of_name)
    return maps
