# SPDX-License-Identifier: GPL-3.0-or-later
"""MagicaVoxel's files."""

from __future__ import annotations

import os

from tyndall import _native
from tyndall._native import Progress
from tyndall.volumes import MEMORY_LIMIT_BYTES

from .checks import MOST_BYTES, attribute_config, check_no_rows, named, whole
from .config import Config
from .dag import VoxelDag


def import_vox(
    path: str | os.PathLike[str],
    config: Config | None = None,
    progress: Progress | None = None,
    *,
    voxel_size_m: float = 1.0,
) -> VoxelDag:
    """All models of a MagicaVoxel file, where its scene graph places them, in the smallest cube that holds them.

    Colours are the palette's; materials become the channels "roughness", "metallic" and "emission" where they differ
    from 1, 0 and 0. What is hidden is left out, animations show their first frame; where models overlap, the later one
    in the graph counts. Axes and origin are the file's. Of ``config``, how voxels and colours are stored and the memory
    budget count (4 GiB without). Raises IoError, which names the path and the chunk that is damaged; InvalidInput for
    scenes that are too large; and Cancelled.
    """
    config = config or Config()
    check_no_rows(config)
    most_bytes = config.memory_budget_bytes or MEMORY_LIMIT_BYTES
    return VoxelDag(
        _native.import_vox(
            path,
            voxel_size_m=float(voxel_size_m),
            symmetry=named(_native.VoxelSymmetry, "symmetry", config.symmetry),
            attribute_config=attribute_config(config),
            memory_budget_bytes=whole("memory_budget_bytes", most_bytes, MOST_BYTES),
            progress=progress or Progress(),
        )
    )
