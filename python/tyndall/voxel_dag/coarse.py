# SPDX-License-Identifier: GPL-3.0-or-later
"""As much of a large file as a coarse picture of it takes: its topmost levels, else its geometry, else all of it."""

from __future__ import annotations

import os
from itertools import takewhile

from tyndall._native import Progress

from .dag import LEAST_LEVEL, VoxelDag, load
from .file_header import read_header


def load_coarse(
    path: str | os.PathLike[str], level: int, most_cubes: int, progress: Progress | None = None
) -> VoxelDag:
    """Something with the file's ``coarse_cubes(level, most_cubes)``, and their colours if it has any.

    At levels 0 and 1 colours are means of finer cubes, each of the same weight. Raises IoError, which names the path
    and the section that is damaged, and Cancelled.
    """
    header = read_header(path)
    apart = header.top_cube_counts
    fitting = len(list(takewhile(lambda cubes: cubes <= most_cubes, apart)))
    if fitting >= LEAST_LEVEL and (level <= len(apart) or fitting < len(apart)):
        # Means of means: of levels that are too coarse to be voxels, the finest that is at hand.
        return load(path, progress, level=min(fitting, level) if level >= LEAST_LEVEL else fitting)
    geometry = load(path, progress, attributes=False)
    if not header.has_colors:
        return geometry
    found = geometry.coarse_cubes(level, most_cubes, progress)[1]
    del geometry
    return load(path, progress, level=found if LEAST_LEVEL <= found <= len(apart) else None)
