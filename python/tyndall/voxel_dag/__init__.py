# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as voxels, and these as a directed acyclic graph: equal subtrees, also turned ones, are stored once."""

from .config import Config
from .dag import LevelCounts, VoxelDag, load
from .estimate import Estimate, Extent, estimate, extent_of, largest_that_fits
from .forecast import Forecast, forecast
from .meshes import from_coordinates, voxelize
from .out_of_core import voxelize_to_file
from .preview import exposed_faces, preview

__all__ = [
    "Config",
    "Estimate",
    "Extent",
    "Forecast",
    "LevelCounts",
    "VoxelDag",
    "estimate",
    "exposed_faces",
    "extent_of",
    "forecast",
    "from_coordinates",
    "largest_that_fits",
    "load",
    "preview",
    "voxelize",
    "voxelize_to_file",
]
