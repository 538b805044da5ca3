# SPDX-License-Identifier: GPL-3.0-or-later
"""What was gathered for voxels, as ``tyndall.voxel_dag`` takes it: triangles, pictures, normals and channels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tyndall.linear_colours import srgb_from_linear
from tyndall.voxel_dag import Material, Textures

from .materials import COLOUR
from .varying_voxels import draw, texel_size_m
from .voxel_colours import DARK, EMISSION, Glow, luminance

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from numpy.typing import NDArray

    from .voxel_colours import Colouring
    from .voxel_meshes import VoxelMesh


_DIM = 0.01  #: Of what glows most: what glows less has no hue that counts.


def glow_of(mesh: VoxelMesh, *, has_colors: bool) -> Glow:
    """In the hues of what glows where these differ and voxels have colours, else in that of what glows most."""
    glows = [colouring.glow.reshape(-1, 3) for colouring in mesh.colourings if EMISSION in colouring.channels]
    texels = np.concatenate([np.zeros((1, 3)), *glows])
    brightest = texels.max(axis=1)
    if not (strength := float(brightest.max())) > 0.0:
        return DARK
    shown = brightest > _DIM * strength
    hues = texels[shown] / brightest[shown, None]
    if not np.allclose(hues, hues[0], atol=0.02):
        if has_colors:
            return Glow(strength, None)
        mesh.reports.add("Emission", "voxels without colours glow in one, that of what glows most")
    most = texels[luminance(texels).argmax()]
    return Glow(float(most.max()), tuple((most / most.max()).tolist()))


def _hues_of(colouring: Colouring) -> NDArray[np.floating[Any]] | None:
    """Of what glows, (height, width, 3); black where it does not. None: nowhere."""
    if not colouring.glow.any():
        return None
    brightest = colouring.glow.max(axis=2, keepdims=True)
    hues: NDArray[np.floating[Any]] = colouring.glow / np.where(brightest > 0.0, brightest, 1.0)
    return hues


def surface_of(
    mesh: VoxelMesh,
    *,
    resolution: int,
    has_colors: bool,
    has_normals: bool,
    channels: Collection[str],
    poll: Callable[[], None] = lambda: None,
) -> tuple[NDArray[np.float64], NDArray[np.uint32], dict[str, Any]]:
    """Positions and triangles, and what ``tyndall.voxel_dag.Config`` takes of them as voxels are to carry.

    ``poll`` may raise to stop. Raises IoError of textures that lie in a file.
    """
    wanted = [*([COLOUR] if has_colors else []), *channels]
    glow = glow_of(mesh, has_colors=has_colors) if EMISSION in wanted else DARK
    fields: dict[str, Any] = {}
    if wanted:
        fields["textures"] = _textures_of(mesh, wanted, glow, resolution, poll)
    factors = {name: mesh.corner_factors[name] for name in wanted if name in mesh.corner_factors}
    if COLOUR in factors and glow.hue is None:
        glowing = np.array([colouring.glow.any() for colouring in mesh.colourings])
        factors[COLOUR] = np.where(glowing[mesh.colouring_of_triangle][:, None, None], 1.0, factors[COLOUR])
    if not (has_normals or factors):
        return mesh.positions_m, mesh.triangles, fields
    positions_m, triangles, normals = split_corners(mesh)
    if has_normals:
        fields["normals"] = normals
    if COLOUR in factors:
        fields["colors"] = srgb_from_linear(factors.pop(COLOUR).reshape(-1, 3))
    fields["channels"] = {name: np.rint(255.0 * factor.ravel()).astype(np.uint8) for name, factor in factors.items()}
    return positions_m, triangles, fields


def _textures_of(mesh: VoxelMesh, wanted: list[str], glow: Glow, resolution: int, poll: Callable[[], None]) -> Textures:
    materials = [_material(colouring, wanted, glow) for colouring in mesh.colourings]
    if glow.hue is None and any(one.glow.any() and one.texels.any() for one in mesh.colourings):
        mesh.reports.add("Emission", "voxels that glow in different colours have these alone, not their surfaces'")
    corner_uvs, material_of_triangle = mesh.corner_uvs, mesh.colouring_of_triangle
    if mesh.varying:
        corner_uvs, material_of_triangle = corner_uvs.copy(), material_of_triangle.copy()
        voxel_m = float(np.ptp(mesh.positions_m, axis=0).max()) / max(resolution, 1)
        texel_m = texel_size_m(mesh.varying, voxel_m)
        if texel_m > voxel_m:
            mesh.reports.add("Voxels", f"nodes that vary are read every {texel_m:.3g} m; a voxel is {voxel_m:.3g} m")
    for surface in mesh.varying:
        notes: list[str] = []
        drawn = draw(surface, wanted, texel_m, notes, poll)
        for note in notes:
            mesh.reports.add("Voxels", note)
        for triangles, is_mirrored in zip(surface.triangles, surface.is_mirrored, strict=True):
            corner_uvs[triangles] = drawn.corner_uvs[:, ::-1] if is_mirrored else drawn.corner_uvs
            material_of_triangle[triangles] = len(materials)
        channels: dict[str, Any] = {name: picture for name, picture in drawn.pictures.items() if name != COLOUR}
        if EMISSION in (same := materials[surface.colouring].channels):
            channels[EMISSION] = float(np.mean(same[EMISSION]))
        hues = _hues_of(mesh.colourings[surface.colouring]) if glow.hue is None else None
        look: dict[str, Any] = {"picture": drawn.pictures.get(COLOUR)}
        if hues is not None:
            look = {"color": srgb_from_linear(hues.reshape(-1, 3).max(axis=0))}
        materials.append(Material(**look, outside="extend", channels=channels))
    return Textures(materials=materials, corner_uvs=corner_uvs, material_of_triangle=material_of_triangle)


def _material(colouring: Colouring, wanted: list[str], glow: Glow) -> Material:
    hues = _hues_of(colouring) if glow.hue is None else None
    kept = {}
    for name, parts in colouring.channels.items():
        if name in wanted:
            texels: NDArray[np.floating[Any]] = parts.texels[..., 0]
            if name == EMISSION:
                hue = hues if hues is not None else np.array(glow.hue or (1.0, 1.0, 1.0))
                texels = texels / np.maximum(luminance(hue)[..., 0] * glow.strength, 1e-9)
            texels = np.clip(texels, 0.0, 1.0)
            kept[name] = texels if texels.size > 1 else float(texels[0, 0])
    look: dict[str, Any] = {}
    if COLOUR in wanted:
        colors = colouring.texels if hues is None else hues.astype(np.float32)
        is_same = colors.shape[:2] == (1, 1)
        look = {"color": srgb_from_linear(colors[0, 0])} if is_same else {"picture": colors}
    return Material(**look, outside=colouring.extension.name.lower(), channels=kept)


def split_corners(mesh: VoxelMesh) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float32]]:
    """Positions, triangles and normals, with a vertex for each corner; flat corners have their triangle's normal."""
    positions_m = mesh.positions_m[mesh.triangles]
    across = np.cross(positions_m[:, 1] - positions_m[:, 0], positions_m[:, 2] - positions_m[:, 0])
    lengths = np.linalg.norm(across, axis=1, keepdims=True)
    of_faces = np.where(lengths > 0.0, across / np.where(lengths > 0.0, lengths, 1.0), (0.0, 0.0, 1.0))
    is_flat = ~mesh.corner_normals.any(axis=2, keepdims=True)
    normals = np.where(is_flat, of_faces[:, None], mesh.corner_normals).astype(np.float32)
    corners = np.arange(3 * len(mesh.triangles), dtype=np.uint32).reshape(-1, 3)
    return positions_m.reshape(-1, 3), corners, normals.reshape(-1, 3)
