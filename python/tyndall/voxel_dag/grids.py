# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids of numbers become voxel DAGs: OpenVDB's level sets and fog volumes, and arrays."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyndall import _native
from tyndall._native import Progress
from tyndall.volumes import LEAF_VOXELS, MEMORY_LIMIT_BYTES, GridInfo, grid_infos, read_vdb

from .checks import MOST_LEVEL, budget, check_no_rows, named, refuse
from .config import Config
from .dag import VoxelDag
from .grid_colors import BYTES_PER_VOXEL, colored, read_colors
from .meshes import from_coordinates

Rule = Literal["inside", "dense", "surface"]
DEFAULT_THRESHOLDS = {"inside": 0.0, "dense": 0.5, "surface": 0.0}
MOST_VOXELS = 1 << MOST_LEVEL  #: A side.


def import_vdb(
    path: str | os.PathLike[str],
    grid: str | None = None,
    config: Config | None = None,
    progress: Progress | None = None,
    *,
    rule: Rule | None = None,
    threshold: float | None = None,
    color_grid: str | None = None,
) -> VoxelDag:
    """The voxels of a grid in an OpenVDB file, where they lie in the grid's space and as large as they are there.

    ``grid`` may be left out where the file has one grid alone, that of the colours aside. ``rule``: "inside": values
    of at most ``threshold``, 0 without; "surface": those of them that have a face towards one that is not; "dense":
    values of at least ``threshold``, 0.5 without. None: "inside" for a level set, "dense" for all others.
    ``color_grid``: one of three scene-linear numbers per voxel in the same place, as "color" of Blender or "Cd" of
    Houdini; what is beyond 0 and 1 is clamped. Of ``config``, symmetry, how colours are stored, and memory budget count
    (for what is read: 4 GiB without). Raises InvalidInput, which names the grid, for one that lies turned or stretched
    in space, holds no numbers, or has no bounds by the rule; IoError, which names the path; and Cancelled.
    """
    config, progress = config or Config(), progress or Progress()
    check_no_rows(config)
    infos = grid_infos(path, progress)
    color_info = None if color_grid is None else _chosen(os.fspath(path), infos, color_grid)
    info = _chosen(
        os.fspath(path), infos if grid is not None else [info for info in infos if info is not color_info], grid
    )
    culprit = f'{os.fspath(path)}: grid "{info.name}": '
    rule = rule or ("inside" if info.grid_class == "level set" else "dense")
    if rule not in DEFAULT_THRESHOLDS:
        raise refuse(f"rule is {rule!r}, not one of {', '.join(DEFAULT_THRESHOLDS)}")
    limit = np.float32(DEFAULT_THRESHOLDS[rule] if threshold is None else threshold)
    if not np.isfinite(limit):
        raise refuse(f"threshold is {threshold!r}, no finite number")
    most_bytes = config.memory_budget_bytes or MEMORY_LIMIT_BYTES
    read = read_vdb(path, [info.name], memory_limit_bytes=most_bytes, progress=progress)
    if info.name not in read:
        raise refuse(f"{culprit}it holds {info.value_type}, not one number per voxel")
    values = read[info.name]

    def is_set(numbers: NDArray[Any]) -> NDArray[np.bool_]:
        """What is no number is not."""
        result: NDArray[np.bool_] = numbers >= limit if rule == "dense" else numbers <= limit
        return result

    if is_set(np.array(values.background, np.float32)):
        raise refuse(f"{culprit}by the rule {rule!r} with {limit:g} all of space is set: its background is too")
    voxel_m, index_0_m = _placed(values.local_from_index, culprit)
    words = _words(np.packbits(is_set(values.leaf_values), axis=-1, bitorder="little"))
    is_kept = words.any(axis=1)
    origins = values.leaf_origins[is_kept].astype(np.int64)
    first = origins.min(axis=0) if len(origins) else np.zeros(3, np.int64)
    side = LEAF_VOXELS + (int(np.ptp(origins, axis=0).max()) if len(origins) else 0)
    if side > MOST_VOXELS:
        raise refuse(f"{culprit}its voxels span {side}; {MOST_VOXELS} a side are possible")
    dag = _dag(
        origins - first,
        words[is_kept],
        (side - 1).bit_length(),
        index_0_m + (first - 0.5) * voxel_m,  # an index is that of a voxel's centre
        voxel_m,
        is_shell=rule == "surface",
        config=config,
        progress=progress,
    )
    if color_info is None:
        return dag
    if dag.voxel_count * BYTES_PER_VOXEL > most_bytes:
        raise refuse(
            f"{culprit}the colours of {dag.voxel_count} voxels take some {dag.voxel_count * BYTES_PER_VOXEL / 1e9:.1f}"
            f" GB, beyond the memory budget of {most_bytes / 1e9:.1f} GB: raise it"
        )
    channels = read_colors(path, color_info, most_bytes, progress)
    if not np.allclose(channels[0].local_from_index, values.local_from_index, rtol=0.0, atol=1e-6 * voxel_m):
        raise refuse(
            f'{culprit}its colours, "{color_grid}", lie elsewhere, or have voxels of another size: resample them'
        )
    voxels, colors = colored(dag, channels, first)
    listed = replace(config, resolution=dag.resolution, bounds_m=dag.bounds_m, colors=colors)
    return from_coordinates(voxels, listed, progress)


def from_array(
    values: ArrayLike,
    config: Config | None = None,
    progress: Progress | None = None,
    *,
    threshold: float | None = None,
    voxel_size_m: float = 1.0,
    lower_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    colors: ArrayLike | None = None,
) -> VoxelDag:
    """Voxel (x, y, z) is set where ``values[x, y, z]`` is true, or reaches ``threshold``. Slices: transpose (2, 1, 0).

    ``lower_m``: the lowest corner of the first voxel. The cube is the least power of two that holds the array.
    ``colors``: (nx, ny, nz, 3), uint8 or 0 to 1, as sRGB encodes them. Of ``config``, how voxels and colours are
    stored and the memory budget count. Raises InvalidInput and Cancelled.
    """
    config, progress = config or Config(), progress or Progress()
    check_no_rows(config)
    array = np.asarray(values)
    if array.ndim != 3:  # noqa: PLR2004 - x, y and z
        raise refuse(f"values have the shape {array.shape}, not (nx, ny, nz)")
    if threshold is None and array.dtype != np.bool_:
        raise refuse(f"values are {array.dtype}: give a threshold, or an array of bool")
    if array.dtype.kind not in "biuf":
        raise refuse(f"values are {array.dtype}, not numbers")
    if max(array.shape) > MOST_VOXELS:
        raise refuse(f"values have the shape {array.shape}; {MOST_VOXELS} voxels a side are possible")
    if not (np.isfinite(voxel_size_m) and voxel_size_m > 0):
        raise refuse(f"voxel_size_m is {voxel_size_m!r}, no length above 0")
    corner_m = np.asarray(lower_m, np.float64)
    if corner_m.shape != (3,) or not np.isfinite(corner_m).all():
        raise refuse(f"lower_m is {lower_m!r}, not three finite numbers")
    is_set = array if threshold is None else array >= threshold
    level = (max(LEAF_VOXELS, *array.shape) - 1).bit_length()
    if colors is not None:
        colored = np.asarray(colors)
        if colored.shape != (*array.shape, 3):
            raise refuse(f"colors have the shape {colored.shape}, not {(*array.shape, 3)}")
        bounds_m = [corner_m, corner_m + voxel_size_m * 2.0**level]
        listed = replace(config, resolution=1 << level, bounds_m=bounds_m, colors=colored[is_set])
        return from_coordinates(np.argwhere(is_set), listed, progress)
    bits = np.packbits(is_set, axis=2, bitorder="little")
    bits = np.pad(bits, [(0, -bits.shape[0] % LEAF_VOXELS), (0, -bits.shape[1] % LEAF_VOXELS), (0, 0)])
    x, y, z = bits.shape[0] // LEAF_VOXELS, bits.shape[1] // LEAF_VOXELS, bits.shape[2]
    blocks = bits.reshape(x, LEAF_VOXELS, y, LEAF_VOXELS, z).transpose(0, 2, 4, 1, 3)
    kept = np.argwhere(blocks.any(axis=(3, 4)))
    return _dag(
        kept * LEAF_VOXELS,
        _words(np.ascontiguousarray(blocks[tuple(kept.T)])),
        level,
        corner_m,
        float(voxel_size_m),
        is_shell=False,
        config=config,
        progress=progress,
    )


def _chosen(path: str, infos: list[GridInfo], name: str | None) -> GridInfo:
    names = ", ".join(f'"{info.name}"' for info in infos) or "none"
    if name is None and len(infos) != 1:
        raise refuse(f"{path}: say which grid to read; it has: {names}")
    found = [info for info in infos if name in (None, info.name)]
    if not found:
        raise refuse(f'{path}: it has no grid "{name}"; it has: {names}')
    if found[0].refusal:
        raise refuse(f'{path}: grid "{found[0].name}": {found[0].refusal}')
    return found[0]


def _placed(local_from_index: NDArray[np.float64], culprit: str) -> tuple[float, NDArray[np.float64]]:
    """The voxels' side, and where index 0 lies."""
    turn = local_from_index[:3, :3]
    side = float(turn[0, 0])
    if side <= 0 or not np.allclose(turn, side * np.eye(3), rtol=0.0, atol=1e-6 * side):
        raise refuse(f"{culprit}its voxels are turned or no cubes, which bounds cannot say: resample it")
    return side, local_from_index[:3, 3]


def _words(bits: NDArray[np.uint8]) -> NDArray[np.uint64]:
    """Bit z of byte 8 x + y of each block, any shape, as bit 8 y + z of word x, (n, 8)."""
    return bits.reshape(-1, LEAF_VOXELS**2).view("<u8")


def _dag(
    origins: NDArray[np.int64],
    words: NDArray[np.uint64],
    level: int,
    lower_m: NDArray[np.float64],
    voxel_m: float,
    *,
    is_shell: bool,
    config: Config,
    progress: Progress,
) -> VoxelDag:
    return VoxelDag(
        _native.voxel_dag_of_blocks(
            origins=np.ascontiguousarray(origins, np.uint32),
            words=words,
            level=level,
            is_shell=is_shell,
            bounds=(lower_m.tolist(), voxel_m * 2.0**level),
            symmetry=named(_native.VoxelSymmetry, "symmetry", config.symmetry),
            memory_budget_bytes=budget(config),
            progress=progress,
        )
    )
