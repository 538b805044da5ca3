# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a voxel DAG, one by one or as ``tyndall.jobs``: a mesh's file and a number in, a part's file out."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from numpy.typing import ArrayLike

from tyndall import _native
from tyndall._native import Progress
from tyndall.frame_files import completed
from tyndall.jobs import Job

from .checks import MOST_INDEX, attribute_config, budget, cube, indices, named, points, whole
from .config import Config
from .kept_meshes import load_mesh, save_mesh
from .surfaces import surface

_DEFAULT_BUDGET_BYTES = 2 << 30


def budget_of(config: Config) -> int:
    """Bytes of memory that making a file may take."""
    return _DEFAULT_BUDGET_BYTES if config.memory_budget_bytes is None else budget(config)


def scratch_of(path: str | os.PathLike[str], scratch: str | os.PathLike[str] | None) -> Path:
    """The folder in which parts' folders lie."""
    return Path(path).absolute().parent if scratch is None else Path(scratch).absolute()


def parts_of(
    positions_m: ArrayLike,
    triangles: ArrayLike,
    config: Config,
    scratch: Path,
    progress: Progress,
    *,
    worker_count: int = 1,
) -> _native.OutOfCoreVoxels:
    """The parts of a mesh; ``worker_count`` processes share the budget. Raises InvalidInput and Cancelled."""
    positions = points(positions_m, "positions_m")
    return _native.OutOfCoreVoxels(
        positions=positions,
        triangles=indices(triangles, "triangles"),
        resolution=whole("resolution", config.resolution, MOST_INDEX),
        rule=named(_native.VoxelizeRule, "rule", config.rule),
        bounds=cube(config.bounds_m),
        surface=surface(config, len(positions)),
        is_solid=config.solid,
        symmetry=named(_native.VoxelSymmetry, "symmetry", config.symmetry),
        attribute_config=attribute_config(config),
        memory_budget_bytes=budget_of(config),
        worker_count=worker_count,
        scratch_folder=scratch,
        progress=progress,
    )


def part_jobs(
    positions_m: ArrayLike,
    triangles: ArrayLike,
    config: Config,
    scratch: Path,
    *,
    worker_count: int = 1,
    progress: Progress | None = None,
) -> list[Job]:
    """One job per part; the mesh is written beside the parts. Raises InvalidInput, IoError, OSError and Cancelled."""
    positions_m, triangles = points(positions_m, "positions_m"), indices(triangles, "triangles")
    native = parts_of(positions_m, triangles, config, scratch, progress or Progress(), worker_count=worker_count)
    mesh = Path(native.part_path(0)).with_name("mesh.npz")
    if not mesh.exists():
        mesh.parent.mkdir(parents=True, exist_ok=True)
        with completed(mesh) as temporary:
            save_mesh(temporary, positions_m, triangles, config)
    budget_bytes = budget_of(config)  # the only setting that two calls of one job may have different
    return [
        Job(_make_part, (mesh, scratch, budget_bytes, worker_count, part), Path(native.part_path(part)))
        for part in range(native.part_count)
    ]


def _make_part(mesh: Path, scratch: Path, budget_bytes: int, worker_count: int, part: int) -> None:
    _opened(mesh, scratch, budget_bytes, worker_count).make_part(part, Progress())


@lru_cache(maxsize=1)  # a worker makes many parts of one mesh
def _opened(mesh: Path, scratch: Path, budget_bytes: int, worker_count: int) -> _native.OutOfCoreVoxels:
    positions_m, triangles, config = load_mesh(mesh)
    config = replace(config, memory_budget_bytes=budget_bytes)
    return parts_of(positions_m, triangles, config, scratch, Progress(), worker_count=worker_count)
