# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxel DAGs as meshes and as the files of other programs."""

from __future__ import annotations

import math
import os
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tyndall import _native
from tyndall._native import Progress
from tyndall.volumes import MEMORY_LIMIT_BYTES

from .checks import MOST_BYTES, doublings, named, refuse, whole
from .grid_colors import BYTES_PER_VOXEL, linear_of, voxels_of_blocks

#: Of a block of 8 x 8 x 8 voxels while OpenVDB has it: its own leaf, and those around it that a level set needs.
GRID_BYTES_PER_BLOCK = 8192
_COLOR_BYTES_PER_BLOCK = 8192  #: A leaf of vectors, likewise.
_SQUARES_AT_ONCE = 1 << 18


class VoxelMesh(NamedTuple):
    """Triangles of voxels. Seen from outside, corners go round against the clock."""

    positions_m: NDArray[np.float64]  #: (p, 3)
    triangles: NDArray[np.uint32]  #: (m, 3), indices of positions.
    colors: NDArray[np.uint8] | None  #: (m, 3), as sRGB encodes them, of boxes whose voxels have colours.


class Exports:
    """What a voxel DAG becomes elsewhere: a part of ``VoxelDag``."""

    _native: _native.VoxelDag

    def to_mesh(
        self,
        kind: Literal["boxes", "smooth"] = "boxes",
        *,
        level: int | None = None,
        memory_budget_bytes: int = MEMORY_LIMIT_BYTES,
        progress: Progress | None = None,
    ) -> VoxelMesh:
        """A closed mesh of the voxels, or of the cubes that have any, of which 2 ** ``level`` lie along a side.

        "boxes": two triangles for each face between a voxel that is set and one that is not, exactly; "smooth": the
        surface of their level set, by OpenVDB. Raises InvalidInput, which says what it would take, where the memory
        budget does not suffice; and Cancelled.
        """
        if kind not in ("boxes", "smooth"):
            raise refuse(f"kind is {kind!r}, not one of boxes, smooth")
        progress = progress or Progress()
        lower_m, side_m = self._native.bounds_m
        coarser = doublings(level, self._native.resolution)
        cube_m = math.ldexp(side_m, coarser) / self._native.resolution
        if kind == "boxes":
            budget = whole("memory_budget_bytes", memory_budget_bytes, MOST_BYTES)
            positions, triangles, cubes, colors = self._native.box_mesh(coarser, budget, progress)
            positions *= cube_m
            positions += lower_m
            return VoxelMesh(positions, triangles, colors[np.repeat(cubes, 2)] if self._native.has_colors else None)
        from tyndall import _volume_io  # noqa: PLC0415 - OpenVDB is loaded by what needs it

        origins, words = self._blocks(coarser, memory_budget_bytes, progress)
        centres, triangles = _volume_io.smooth_mesh(origins, words, progress)
        return VoxelMesh((centres.astype(np.float64) + 0.5) * cube_m + lower_m, triangles, None)

    def box_channels(
        self, mesh: VoxelMesh, *, level: int | None = None, progress: Progress | None = None
    ) -> dict[str, NDArray[np.uint8]]:
        """By name the channels of what ``to_mesh`` made of boxes of that level: of each triangle, (m,).

        Raises InvalidInput where a triangle is of no cube, and Cancelled.
        """
        progress = progress or Progress()
        names: list[str] = self._native.channels
        squares = mesh.triangles.reshape(-1, 2, 3)
        channels = {name: np.empty(len(squares), np.uint8) for name in names}
        lower_m, side_m = self._native.bounds_m
        coarser = doublings(level, self._native.resolution)
        cubes_per_m = self._native.resolution / math.ldexp(side_m, coarser)
        for first in range(0, len(squares) if names else 0, _SQUARES_AT_ONCE):
            part = slice(first, first + _SQUARES_AT_ONCE)
            halves = cubes_per_m * (mesh.positions_m[squares[part, 0]] - lower_m)  # triangles, as wide as their squares
            outwards = np.cross(halves[:, 1] - halves[:, 0], halves[:, 2] - halves[:, 0])  # of length 1, as the edges
            within = 0.5 * (halves.min(axis=1) + halves.max(axis=1) - outwards)
            cubes = np.floor(within).astype(np.uint32) << coarser
            for name in names:
                channels[name][part] = self._native.channel_at(name, cubes, coarser, progress)
        return {name: np.repeat(values, 2) for name, values in channels.items()}

    def to_vdb(
        self,
        path: str | os.PathLike[str],
        kind: Literal["fog", "level set"] = "fog",
        *,
        name: str | None = None,
        color_name: str = "color",
        level: int | None = None,
        memory_budget_bytes: int = MEMORY_LIMIT_BYTES,
        progress: Progress | None = None,
    ) -> None:
        """Write an OpenVDB file with one grid of voxels, or of cubes, 2 ** ``level`` along a side, whole or not at all.

        "fog": 1 where a voxel is set, named "density"; "level set": distances to the voxels' surface, negative where
        one is set, named "surface". Colours, where there are any, become a second grid, of scene-linear vectors; its
        name of "color" is the one that Blender's Volume Info reads. "" for the name: none is written. Raises
        InvalidInput, which says what it would take, where the memory budget does not suffice; IoError, which names the
        path; and Cancelled.
        """
        from tyndall import __version__, _volume_io  # noqa: PLC0415 - OpenVDB is loaded by what needs it

        grid_kind = named(_volume_io.VoxelGridKind, "kind", kind.replace(" ", "_"))
        progress = progress or Progress()
        lower_m, side_m = self._native.bounds_m
        coarser = doublings(level, self._native.resolution)
        cube_m = math.ldexp(side_m, coarser) / self._native.resolution
        local_from_index = np.diag([cube_m, cube_m, cube_m, 1.0])
        local_from_index[:3, 3] = np.add(lower_m, 0.5 * cube_m)
        origins, words = self._blocks(coarser, memory_budget_bytes, progress)
        _volume_io.write_voxel_grid(
            path,
            name or ("density" if kind == "fog" else "surface"),
            origins,
            words,
            local_from_index,
            grid_kind,
            self._linear_colors(color_name, level, origins, words, memory_budget_bytes, progress),
            {"creator": f"Tyndall {__version__}"},
            progress,
        )

    def to_vox(
        self,
        path: str | os.PathLike[str],
        *,
        quantize: bool = False,
        memory_budget_bytes: int = MEMORY_LIMIT_BYTES,
        progress: Progress | None = None,
    ) -> None:
        """Write a MagicaVoxel file, whole or not at all: models of 256 voxels a side, put together by its scene graph.

        Colours go with the voxels, normals and channels do not. More than 255 colours are refused, or, with
        ``quantize``, become those of a palette. Raises InvalidInput, which says what would fit, for what such a file
        has no room for; IoError, which names the path; and Cancelled.
        """
        budget = whole("memory_budget_bytes", memory_budget_bytes, MOST_BYTES)
        self._native.save_vox(path, quantize, budget, progress or Progress())

    def _linear_colors(
        self,
        name: str,
        level: int | None,
        origins: NDArray[np.int32],
        words: NDArray[np.uint64],
        memory_budget_bytes: int,
        progress: Progress,
    ) -> tuple[str, NDArray[np.float32]] | None:
        """Of each voxel, block by block, and the name of their grid."""
        if not (name and self._native.has_colors):
            return None
        count = int(np.unpackbits(words.view(np.uint8)).sum())
        needed = len(origins) * (GRID_BYTES_PER_BLOCK + _COLOR_BYTES_PER_BLOCK) + count * BYTES_PER_VOXEL
        if needed > memory_budget_bytes:
            raise refuse(
                f"grids of these voxels and their colours take some {needed / 1e9:.1f} GB, beyond the memory budget of"
                f" {memory_budget_bytes / 1e9:.1f} GB: choose a coarser level, raise the budget, or leave the colours"
                ' out (color_name="")'
            )
        coarser = doublings(level, self._native.resolution)
        voxels = voxels_of_blocks(origins, words) << coarser
        return name, linear_of(self._native.colors_at(voxels, coarser, progress))

    def _blocks(
        self, coarser: int, memory_budget_bytes: int, progress: Progress
    ) -> tuple[NDArray[np.int32], NDArray[np.uint64]]:
        """Blocks of 8 x 8 x 8, as OpenVDB's leaves."""
        budget = whole("memory_budget_bytes", memory_budget_bytes, MOST_BYTES)
        origins, words = self._native.leaf_blocks(coarser, budget, progress)
        if len(origins) * GRID_BYTES_PER_BLOCK > budget:
            raise refuse(
                f"a grid of these voxels takes some {len(origins) * GRID_BYTES_PER_BLOCK / 1e9:.1f} GB, beyond the"
                f" memory budget of {budget / 1e9:.1f} GB: choose a coarser level, or raise the budget"
            )
        return origins.astype(np.int32), words
