# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that become voxels, and objects that stand for these."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from addon.voxel_boxes import file_of
from tyndall.voxel_dag import load

from .new_file import new_file
from .small_scenes import cube


def saved_block(folder: Path) -> bpy.types.Scene:
    """A file on disk, with a cube of 2 m that is selected, and small voxels."""
    scene = new_file()
    scene.render.engine = "TYNDALL"
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    box = cube("Block")
    box.location = (5.0, 0.0, 0.0)
    select(box)
    scene.tyndall.voxelize.resolution = "16"
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    return bpy.context.scene


def select(*things: bpy.types.Object) -> None:
    bpy.context.view_layer.update()  # which still lists what was removed
    for other in bpy.context.view_layer.objects:
        other.select_set(other in things)
    bpy.context.view_layer.objects.active = things[0] if things else None


def voxels_in_world(box: bpy.types.Object) -> np.ndarray:
    """Lower and upper corner of all its voxels, (2, 3)."""
    dag = load(file_of(box))
    found = np.concatenate(list(dag.coordinates()))
    size_m = (dag.bounds_m[1] - dag.bounds_m[0]) / dag.resolution
    ends = dag.bounds_m[0] + np.array([found.min(axis=0), found.max(axis=0) + 1]) * size_m
    return np.array([box.matrix_world @ Vector(end) for end in ends])
