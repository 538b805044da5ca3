# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as voxels, and these as a directed acyclic graph: equal subtrees, also turned ones, are stored once."""

from .config import Config
from .dag import VoxelDag, load
from .forecast import Forecast, forecast
from .meshes import from_coordinates, voxelize
from .out_of_core import voxelize_to_file

__all__ = ["Config", "Forecast", "VoxelDag", "forecast", "from_coordinates", "load", "voxelize", "voxelize_to_file"]
