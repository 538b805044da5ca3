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
from ._native import InvalidInput, shared_array
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
    reports: list[str],
) -> Mesh:
    """``displacements``: of each slot.

    Raises InvalidInput, also of a mesh without vertex normals, and IoError of textures that lie in a file.
    """
    if mesh.vertex_normals is None:
        raise InvalidInput("the mesh has no vertex normals")
    slots = np.zeros(len(mesh.triangles), np.intp) if mesh.material_slots is None else mesh.material_slots
    slots = np.minimum(slots, len(displacements) - 1)
    moves = np.array([one is not None for one in displacements])[slots]
    corners = _native.first_corners(mesh.triangles, moves, mesh.positions)
    vertices, slot_of_corner = mesh.triangles.ravel()[corners], slots[corners // 3]
    maps = {name: uvs.reshape(-1, 2) for name, uvs in mesh.uv_maps}
    positions = _shared_copy(mesh.positions)
    for slot, displacement in enumerate(displacements):
        here = slot_of_corner == slot
        if displacement is not None and here.any():
            uvs = _uvs_at(displacement.program, mesh, maps, corners[here])
            at = corners[here], mesh.vertex_normals, uvs
            positions[vertices[here]] += _moved(displacement.program, mesh, at, shown, reports)
    keeps = np.array([one is None or one.keeps_normals for one in displacements])[slots]
    return replace(
        mesh,
        key=key,
        positions=positions,
        corner_normals=_new_normals(mesh, positions, ~keeps),
        vertex_normals=None,
    )


def _shared_copy(values: FloatArray) -> FloatArray:
    """Which native code need not copy once more."""
    copy: FloatArray = shared_array(values.shape, values.dtype)
    copy[...] = values
    return copy


def _moved(
    program: Material,
    mesh: Mesh,
    at: tuple[NDArray[np.uint32], FloatArray, FloatArray],
    shown: DisplacedObject,
    reports: list[str],
) -> FloatArray:
    """``at``: corners, the normals of all vertices, and the maps of the corners."""
    corners, vertex_normals, uvs = at
    native = build_material(program, [build_texture(use, reports) for use in program.textures])
    moved: FloatArray = _native.displacements(
        native,
        positions=mesh.positions,
        triangles=mesh.triangles,
        vertex_normals=vertex_normals,
        corners=corners,
        uvs=uvs,
        world_from_object=shown.world_from_object.astype(np.float32).ravel().tolist(),
        color=shown.color,
        pass_index=shown.pass_index,
        random=shown.random,
    )
    require_whole(program)
    return moved


def _uvs_at(program: Material, mesh: Mesh, maps: dict[str, FloatArray], corners: NDArray[np.uint32]) -> FloatArray:
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
    normals = _shared_copy(mesh.corner_normals)
    _native.renew_normals(positions, mesh.triangles, is_renewed, normals)
    return normals
