# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as voxels, and these as a directed acyclic graph: equal subtrees, also turned ones, are stored once."""

from .config import Config
from .dag import VoxelDag, load
from .meshes import from_coordinates, voxelize
from .textures import Material, Textures

__all__ = ["Config", "Material", "Textures", "VoxelDag", "from_coordinates", "load", "voxelize"]
