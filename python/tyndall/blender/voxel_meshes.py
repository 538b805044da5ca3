# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's objects as triangles that ``tyndall.voxel_dag`` takes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy

from . import _part


def gather(depsgraph: bpy.types.Depsgraph, objects: Iterable[bpy.types.Object]) -> Any:  # noqa: ANN401  the add-on's
    """Positions_m, float64 (n, 3), in the world, and triangles, uint32 (m, 3), of objects and all that they instance.

    Modifiers are applied. Raises InvalidInput, which names the object: one with a vertex that is not finite, or those
    of which none has a face.
    """
    return _part(".sync.voxel_meshes").gather(depsgraph, objects)


def textures_of(mesh: Any) -> Any:  # noqa: ANN401  the add-on's
    """The diffuse part of the materials of what was gathered, as ``tyndall.voxel_dag.Config`` takes it."""
    return _part(".sync.voxel_meshes").textures_of(mesh)


def split_corners(mesh: Any) -> Any:  # noqa: ANN401  the add-on's
    """Positions, triangles and smooth normals of what was gathered, with a vertex for each corner."""
    return _part(".sync.voxel_meshes").split_corners(mesh)
