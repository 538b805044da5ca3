# SPDX-License-Identifier: GPL-3.0-or-later
"""What the voxels of a mesh are to carry, as the native module takes it."""

from __future__ import annotations

import numpy as np

from tyndall import _native

from .checks import channels, colors, normals, refuse
from .config import Config


def has_attributes(config: Config) -> bool:
    """Whether voxels are to carry anything."""
    return any(given is not None for given in (config.textures, config.colors, config.normals)) or bool(config.channels)


def surface(config: Config, vertex_count: int) -> _native.VoxelSurface:
    """Raises InvalidInput, which names what is wrong, and IoError, which names a picture's file."""
    textures = config.textures
    if config.solid and has_attributes(config):
        raise refuse("voxels inside of a solid have no surface: leave out colors, textures, normals and channels")
    kind, vertex_normals = _native.SurfaceNormals.NONE, None
    if isinstance(config.normals, str):
        if config.normals != "faces":
            raise refuse(f'normals is {config.normals!r}, neither "faces" nor (n, 3)')
        kind = _native.SurfaceNormals.FACES
    elif config.normals is not None:
        kind, vertex_normals = _native.SurfaceNormals.VERTICES, normals(config.normals, vertex_count)
    encoded = colors(config.colors, vertex_count)
    of_vertices = {name: values / np.float32(255) for name, values in channels(config.channels, vertex_count)}
    names = list(dict.fromkeys([*of_vertices, *([] if textures is None else textures.channels)]))
    # A material that says nothing leaves alone what vertices say.
    unsaid = {name: float(name in of_vertices) for name in names}
    return _native.VoxelSurface(
        colors=None if encoded is None else encoded / np.float32(255),
        materials=[] if textures is None else textures.native_materials(unsaid),
        has_material_colors=textures is not None and textures.has_colors,
        material_of_triangle=None if textures is None else textures.native_indices(),
        corner_uvs=None if textures is None else textures.native_uvs(),
        normals=kind,
        vertex_normals=vertex_normals,
        channels=[(name, of_vertices.get(name)) for name in names],
    )
