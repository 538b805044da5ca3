# SPDX-License-Identifier: GPL-3.0-or-later
"""A lumpy cloud as an OpenVDB file, volume objects that show it, and how they are looked at."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from tyndall.volumes import LEAF_VOXELS, SparseGrid, write_vdb

from .small_scenes import Node, add, empty_scene


def cloud(voxels: int) -> NDArray[np.float32]:
    """Densities over [-1, 1]^3, (voxels, voxels, voxels) by x, y, z: lopsided, so that a turned axis shows."""
    place = (np.arange(voxels) + 0.5) * (2.0 / voxels) - 1.0
    x, y, z = np.meshgrid(place, place, place, indexing="ij")
    lumps = 1.0 + 0.7 * np.sin(6.0 * x + 1.0) * np.sin(5.0 * y) * np.cos(4.0 * z + 0.5) + 0.4 * x - 0.3 * z
    return np.asarray(np.clip(1.0 - (x * x + 1.5 * y * y + z * z), 0.0, None) * lumps, np.float32)


def sparse(
    densities: NDArray[np.float32], name: str = "density", first: tuple[int, int, int] = (0, 0, 0)
) -> SparseGrid:
    """Voxels as cells of [-1, 1]^3; ``first`` is the index of the first one, a multiple of 8 each. Empty leaves go."""
    count = densities.shape[0] // LEAF_VOXELS
    blocks = densities.reshape(count, LEAF_VOXELS, count, LEAF_VOXELS, count, LEAF_VOXELS)
    leaves = blocks.transpose(0, 2, 4, 1, 3, 5).reshape(-1, LEAF_VOXELS, LEAF_VOXELS, LEAF_VOXELS)
    origins = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * LEAF_VOXELS
    is_kept = leaves.reshape(len(leaves), -1).any(axis=1)
    voxel_m = 2.0 / densities.shape[0]
    local_from_index = np.diag([voxel_m, voxel_m, voxel_m, 1.0])
    local_from_index[:3, 3] = -1.0 + (0.5 - np.array(first)) * voxel_m
    return SparseGrid(
        name=name,
        leaf_origins=np.asarray(origins[is_kept] + np.array(first), np.int32),
        leaf_values=np.ascontiguousarray(leaves[is_kept]),
        local_from_index=local_from_index,
    )


def volume_object(path: Path, material: bpy.types.Material | None = None, name: str = "Cloud") -> bpy.types.Object:
    data = bpy.data.volumes.new(name)
    data.filepath = str(path)
    if material is not None:
        data.materials.append(material)
    return add(name, data)


def cloud_file(folder: Path, voxels: int = 48) -> Path:
    path = folder / f"cloud_{voxels}.vdb"
    write_vdb(path, [sparse(cloud(voxels), first=(8, -16, 0))])
    return path


def wall(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
    """Seen by the camera alone."""
    glow = new("ShaderNodeEmission")
    link(new("ShaderNodeLightPath").outputs["Is Camera Ray"], glow.inputs["Strength"])
    return glow.outputs[0]


def look(width_m: float = 2.4, size_px: int = 12) -> bpy.types.Scene:
    scene = empty_scene(size_px)
    scene.camera.data.ortho_scale = width_m
    scene.camera.location.z = 6.0
    cycles = scene.cycles
    cycles.volume_max_steps = 1024
    cycles.volume_step_rate = cycles.volume_preview_step_rate = 0.3
    scene.tyndall.shafts.grid_error_target = 0.002
    return scene


def rms_difference(ours: NDArray[np.float32], cycles: NDArray[np.float32]) -> float:
    """Relative."""
    return float(np.sqrt(np.mean((ours - cycles) ** 2) / np.mean(cycles**2)))
