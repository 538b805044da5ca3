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


def surface_of(mesh: Any, *, resolution: int, has_colors: bool, has_normals: bool) -> Any:  # noqa: ANN401  the add-on's
    """Positions and triangles of what was gathered, and what ``tyndall.voxel_dag.Config`` takes of them.

    That is the colours of materials, those of nodes that vary with a texel for a voxel of this resolution, and smooth
    normals, for which each corner has a vertex.
    """
    carried = {"has_colors": has_colors, "has_normals": has_normals, "channels": ()}
    return _part(".sync.voxel_surfaces").surface_of(mesh, resolution=resolution, **carried)
