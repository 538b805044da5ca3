# SPDX-License-Identifier: GPL-3.0-or-later
"""What buttons do. Every operator runs in a script, too."""

from bpy.utils import register_class, unregister_class

from . import (
    animation,
    denoising,
    fog_box,
    light_depth,
    light_map_fit,
    media,
    occluder_edits,
    over_engine,
    paint_air,
    paint_function,
    painted_air,
    pick_constraint,
    presets,
    reports,
    transfer_functions,
    transfer_states,
    volume_files,
    voxel_exports,
    voxel_files,
    voxelize,
    world_sun,
)

CLASSES = (
    *fog_box.CLASSES,
    *media.CLASSES,
    *animation.CLASSES,
    *light_depth.CLASSES,
    *occluder_edits.CLASSES,
    *transfer_functions.CLASSES,
    *transfer_states.CLASSES,
    *pick_constraint.CLASSES,
    *paint_function.CLASSES,
    *light_map_fit.CLASSES,
    *over_engine.CLASSES,
    *denoising.CLASSES,
    *paint_air.CLASSES,
    *painted_air.CLASSES,
    *volume_files.CLASSES,
    *world_sun.CLASSES,
    *voxelize.CLASSES,
    *voxel_files.CLASSES,
    *voxel_exports.CLASSES,
    *reports.CLASSES,
    *presets.CLASSES,
)


def register() -> None:
    for cls in CLASSES:
        register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        unregister_class(cls)
