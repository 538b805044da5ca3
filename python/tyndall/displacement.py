# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes whose materials move them: each vertex once, before anything is rendered.

Based on: Cycles without adaptive subdivision: a vertex is moved by the first of its triangles that has a displacement,
evaluated at that triangle's corner with the smooth normal; then normals are means of the unit normals of the triangles
around, unless the material also bumps what it moves.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from . import _native
from .fingerprints import fingerprint
from .native_materials import build_material
from .native_textures import build_texture, require_whole
from .scene_description import ATTRIBUTE_MARK, attribute_maps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .scene_description import Displacement, Material, Mesh

    FloatArray = NDArray[np.float32]


class DisplacedObject:
    """What displacements ask of the object that a mesh is first drawn as."""

    def __init__(
        self,
        world_from_object: NDArray[np.float64],
        color: tuple[float, float, float, float],
        pass_index: float,
        random: float,
    ) -> None:
        self.world_from_object = np.ascontiguousarray(world_from_object, np.float64)
        self.color = color
        self.pass_index = pass_index
        self.random = random


def displacements_of(materials: Sequence[Material]) -> tuple[Displacement | None, ...]:
    """Of each slot; empty where none moves anything."""
    found = tuple(material.displacement for material in materials)
    return found if any(one is not None for one in found) else ()


def displaced_key(mesh: Mesh, displacements: Sequence[Displacement | None], shown: DisplacedObject) -> str:
    """Of the mesh that ``displaced`` makes."""
    of_object = (shown.world_from_object, shown.color, shown.pass_index, shown.random)
    return f"{mesh.key} moved {fingerprint((tuple(displacements), of_object)).hex()}"


def displaced(
    mesh: Mesh,
    displacements: Sequence[Displacement | None],
    shown: DisplacedObject,
    key: str,
    vertex_normals: tuple[str, str],
    reports: list[str],
) -> Mesh:
    """``displacements``: of each slot. ``vertex_normals``: the two UV maps with smooth normals, (x, y) and (z, 1).

    Raises InvalidInput, and IoError of textures that lie in a file.
    """
    slots = np.zeros(len(mesh.triangles), np.intp) if mesh.material_slots is None else mesh.material_slots
    slots = np.minimum(slots, len(displacements) - 1)
    moves = np.array([one is not None for one in displacements])[slots]
    vertices, first = np.unique(mesh.triangles[moves], return_index=True)
    corners = np.flatnonzero(np.repeat(moves, 3))[first]  # of those, the first of each vertex
    maps = {name: uvs.reshape(-1, 2) for name, uvs in mesh.uv_maps}
    positions, normals = mesh.positions.copy(), _normals_at(maps, vertex_normals, corners)
    flat_normals = face_normals(mesh.positions, mesh.triangles)[corners // 3]
    for slot, displacement in enumerate(displacements):
        here = slots[corners // 3] == slot
        if displacement is not None and here.any():
            positions[vertices[here]] += _moved(
                displacement.program,
                mesh.positions[vertices[here]],
                (normals[here], flat_normals[here]),
                _uvs_at(displacement.program, mesh, maps, corners[here]),
                shown,
                reports,
            )
    keeps = np.array([one is None or one.keeps_normals for one in displacements])[slots]
    return replace(
        mesh,
        key=key,
        positions=positions,
        corner_normals=_new_normals(mesh, positions, ~keeps),
        uv_maps=tuple((name, uvs) for name, uvs in mesh.uv_maps if name not in vertex_normals),
    )


def face_normals(positions: FloatArray, triangles: NDArray[np.uint32]) -> FloatArray:
    """(triangles, 3), unit; zero of one without an area."""
    a, b, c = (positions[triangles[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    unit: FloatArray = np.divide(across, length, out=np.zeros_like(across), where=length > 0.0).astype(np.float32)
    return unit


def _moved(
    program: Material,
    positions: FloatArray,
    normals: tuple[FloatArray, FloatArray],
    uvs: FloatArray,
    shown: DisplacedObject,
    reports: list[str],
) -> FloatArray:
    native = build_material(program, [build_texture(use, reports) for use in program.textures])
    moved: FloatArray = _native.displacements(
        native,
        positions=positions,
        normals=normals[0],
        true_normals=normals[1],
        uvs=uvs,
        world_from_object=shown.world_from_object.astype(np.float32).ravel().tolist(),
        color=shown.color,
        pass_index=shown.pass_index,
        random=shown.random,
    )
    require_whole(program)
    return moved


def _normals_at(maps: dict[str, FloatArray], names: tuple[str, str], corners: NDArray[np.intp]) -> FloatArray:
    across, up = (maps[name][corners] for name in names)
    normals: FloatArray = np.ascontiguousarray(np.column_stack([across, up[:, 0]]), np.float32)
    return normals


def _uvs_at(program: Material, mesh: Mesh, maps: dict[str, FloatArray], corners: NDArray[np.intp]) -> FloatArray:
    """(corners, maps of the program, 2); the active one by no name, and zero of one that the mesh has not."""
    uvs = np.zeros((len(corners), len(program.uv_maps), 2), np.float32)
    for index, asked in enumerate(program.uv_maps):
        known = next((maps[name] for name, _ in mesh.uv_maps if _answers(name, asked)), None)
        if known is not None:
            uvs[:, index] = known[corners]
    return uvs


def _answers(name: str, asked: str) -> bool:
    """The active UV map or colour attribute, which is the first, goes by no name."""
    if asked == "":
        return not name.startswith(ATTRIBUTE_MARK)
    return name == asked or (asked in attribute_maps("") and name.startswith(asked))


def _new_normals(mesh: Mesh, positions: FloatArray, is_renewed: NDArray[np.bool_]) -> FloatArray | None:
    """Corners that are flat stay so."""
    if mesh.corner_normals is None or not is_renewed.any():
        return mesh.corner_normals
    around = mesh.triangles[is_renewed]
    each = np.repeat(face_normals(positions, around), 3, axis=0)
    count = len(positions)
    sums = np.stack([np.bincount(around.ravel(), each[:, axis], count) for axis in range(3)], axis=1)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    unit = np.divide(sums, length, out=np.zeros_like(sums), where=length > 0.0).astype(np.float32)
    is_moved = np.zeros(count, np.bool_)
    is_moved[around] = True
    at_corners = is_moved[mesh.triangles] & mesh.corner_normals.any(axis=2)
    normals = mesh.corner_normals.copy()
    normals[at_corners] = unit[mesh.triangles[at_corners]]
    return normals
