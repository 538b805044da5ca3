# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes to ``.tdag`` files within a memory budget, whatever the resolution, in parts that survive an interruption."""

from __future__ import annotations

import os

from numpy.typing import ArrayLike

from tyndall import jobs
from tyndall._native import Progress

from .config import Config
from .dag import VoxelDag, load
from .file_header import FileHeader, read_header
from .forecast import require_room
from .parts import part_jobs, parts_of, scratch_of


def voxelize_to_file(
    positions_m: ArrayLike,
    triangles: ArrayLike,
    path: str | os.PathLike[str],
    config: Config | None = None,
    *,
    scratch: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    workers: int | str | None = None,
) -> VoxelDag:
    """What ``voxelize(...).save(path)`` writes, byte for byte, within ``config.memory_budget_bytes`` (None: 2 GiB).

    ``workers`` make the parts: None, this process; a number of processes, which share the budget; or those of a Dask
    scheduler, by its address, each with the budget, which see ``scratch`` under the same path. Finished parts lie in a
    folder of their own in ``scratch`` (None: beside the file) until the file is there: after a full disk, a cancelled
    or a killed call, the same call goes on from them. Raises InvalidInput, which says what would fit; IoError, which
    names the path; and Cancelled.
    """
    write_voxels(positions_m, triangles, path, config, scratch=scratch, progress=progress, workers=workers)
    return load(path, progress)


def write_voxels(
    positions_m: ArrayLike,
    triangles: ArrayLike,
    path: str | os.PathLike[str],
    config: Config | None = None,
    *,
    scratch: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    workers: int | str | None = None,
) -> FileHeader:
    """As voxelize_to_file(), but the file, which may be larger than memory, is not read back: what it says is known."""
    config, progress = config or Config(), progress or Progress()
    require_room(positions_m, triangles, path, config, scratch=scratch, progress=progress)
    folder, count = scratch_of(path, scratch), workers if isinstance(workers, int) else 1
    if workers is not None:
        parts = part_jobs(positions_m, triangles, config, folder, worker_count=count, progress=progress)
        jobs.run(parts, workers, progress, share=0.75)
    native = parts_of(positions_m, triangles, config, folder, progress, worker_count=count)
    native.finish(path, progress)
    return read_header(path)
