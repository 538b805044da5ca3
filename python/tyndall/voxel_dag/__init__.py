# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as voxels, and these as a directed acyclic graph: equal subtrees, also turned ones, are stored once."""

from .block_faces import exposed_cubes, exposed_faces
from .coarse import load_coarse
from .config import Config
from .dag import LevelCounts, VoxelDag, load
from .estimate import Estimate, Extent, estimate, extent_of, largest_that_fits
from .exports import VoxelMesh
from .file_header import FileHeader, checked_header, read_header
from .forecast import Forecast, forecast
from .grids import from_array, import_vdb
from .meshes import filled_shares, from_coordinates, voxelize
from .out_of_core import voxelize_to_file, write_voxels
from .textures import Material, Textures
from .vox_files import import_vox

__all__ = [
    "Config",
    "Estimate",
    "Extent",
    "FileHeader",
    "Forecast",
    "LevelCounts",
    "Material",
    "Textures",
    "VoxelDag",
    "VoxelMesh",
    "checked_header",
    "estimate",
    "exposed_cubes",
    "exposed_faces",
    "extent_of",
    "filled_shares",
    "forecast",
    "from_array",
    "from_coordinates",
    "import_vdb",
    "import_vox",
    "largest_that_fits",
    "load",
    "load_coarse",
    "read_header",
    "voxelize",
    "voxelize_to_file",
    "write_voxels",
]
