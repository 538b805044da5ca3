# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a mesh closes around a volume: a medium inside an open one has no inside."""

from __future__ import annotations

import numpy as np

from tyndall.scene_description import Mesh


def open_edge_count(mesh: Mesh) -> int:
    """Edges with an odd number of triangles; vertices at one place count as one. 0: the mesh is closed.

    Triangles with a vertex that is not finite are left out, as they are from the scene.
    """
    finite = np.logical_and.reduce(np.isfinite(mesh.positions), axis=1)
    _, place = np.unique(np.where(finite[:, None], mesh.positions, 0), axis=0, return_inverse=True)
    corners = place.reshape(-1)[mesh.triangles[finite[mesh.triangles].all(axis=1)]]
    edges = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]
    _, triangle_counts = np.unique(edges, axis=0, return_counts=True)
    return int((triangle_counts % 2).sum())
