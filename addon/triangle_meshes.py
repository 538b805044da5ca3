# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of triangles as Blender's meshes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from .voxel_boxes import COLOURS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bpy.types import Mesh
    from numpy.typing import NDArray


def triangle_mesh(
    name: str,
    positions_m: NDArray[np.floating[Any]],
    triangles: NDArray[np.uint32],
    colors: NDArray[np.uint8] | None,
    *,
    is_smooth: bool,
    channels: Mapping[str, NDArray[np.uint8]] | None = None,
) -> Mesh:
    """``colors``, (m, 3), of triangles, as sRGB encodes them: the mesh's colour attribute.

    ``channels``: attributes, each (m,), of which 255 becomes 1.
    """
    mesh = bpy.data.meshes.new(name)
    count = len(triangles)
    mesh.vertices.add(len(positions_m))
    mesh.vertices.foreach_set("co", positions_m.astype(np.float32).ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    if bpy.app.version < (4, 0, 0):  # later ones know it by where the next begins
        mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    # Said in each version: from 4.1 on faces are smooth that say nothing, before they are flat.
    mesh.polygons.foreach_set("use_smooth", np.full(count, is_smooth))
    if colors is not None:
        rgba = np.full((count, 4), 255, np.uint8)
        rgba[:, :3] = colors
        attribute = mesh.color_attributes.new(COLOURS, "BYTE_COLOR", "CORNER")
        attribute.data.foreach_set("color_srgb", (np.repeat(rgba, 3, axis=0) / np.float32(255.0)).ravel())
    for channel, values in (channels or {}).items():
        mesh.attributes.new(channel, "FLOAT", "FACE").data.foreach_set("value", values / np.float32(255.0))
    mesh.update(calc_edges=True)
    return mesh
