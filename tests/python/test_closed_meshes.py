# SPDX-License-Identifier: GPL-3.0-or-later
"""A medium needs an inside: what counts as closed."""

from __future__ import annotations

import numpy as np

from tyndall.closed_meshes import open_edge_count
from tyndall.scene_description import Mesh

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], np.float32)
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], np.uint32)


def tetrahedron(positions: np.ndarray = CORNERS, triangles: np.ndarray = FACES) -> Mesh:
    return Mesh(key="t", name="t", positions=positions, triangles=triangles)


def test_a_tetrahedron_is_closed_and_without_a_face_it_is_not() -> None:
    """The missing face leaves its three edges with one triangle each."""
    assert open_edge_count(tetrahedron()) == 0
    assert open_edge_count(tetrahedron(triangles=FACES[:3])) == 3


def test_vertices_split_at_seams_do_not_open_a_mesh() -> None:
    """Every triangle may have vertices of its own, as exporters of normals and UVs make them."""
    assert (
        open_edge_count(tetrahedron(CORNERS[FACES].reshape(-1, 3), np.arange(12, dtype=np.uint32).reshape(-1, 3))) == 0
    )


def test_a_vertex_that_is_not_a_number_takes_its_triangles_away() -> None:
    """What remains is the one face opposite, with three open edges."""
    broken = CORNERS.copy()
    broken[3] = np.nan
    assert open_edge_count(tetrahedron(broken)) == 3


def test_an_empty_mesh_has_no_open_edge() -> None:
    """Nothing to report: it bounds nothing."""
    assert open_edge_count(tetrahedron(triangles=np.zeros((0, 3), np.uint32))) == 0
