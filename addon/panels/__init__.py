# SPDX-License-Identifier: GPL-3.0-or-later
"""Our panels in the Properties editor and the 3D view's sidebar, and which of Blender's own show beside them."""

from bpy.utils import register_class, unregister_class

from . import (
    animate,
    colour,
    film,
    gobo,
    heterogeneity,
    indirect,
    light,
    light_groups,
    light_shafts,
    material,
    medium,
    motion_blur,
    objects,
    occluder_edits,
    output,
    over_engine,
    paint_air,
    panorama,
    passes,
    presets,
    sampling,
    simplify,
    standard,
    statistics,
    transfer_functions,
    unavailable,
    viewport_shading,
    voxels,
    world,
)

#: In the order in which they are drawn; a sub-panel after its parent.
CLASSES = (
    *unavailable.CLASSES,
    *presets.CLASSES,
    *sampling.CLASSES,
    *light_shafts.CLASSES,
    *indirect.CLASSES,
    *motion_blur.CLASSES,
    *film.CLASSES,
    *simplify.CLASSES,
    *statistics.CLASSES,
    *passes.CLASSES,
    *world.CLASSES,
    *panorama.CLASSES,
    *objects.CLASSES,
    *light_groups.CLASSES,
    *viewport_shading.CLASSES,
    *light.CLASSES,
    *occluder_edits.CLASSES,
    *gobo.CLASSES,
    *transfer_functions.CLASSES,
    *heterogeneity.CLASSES,
    *material.CLASSES,
    # The sidebar's tab, in the order of an artist's work.
    *medium.SIDEBAR_CLASSES,
    *occluder_edits.SIDEBAR_CLASSES,
    *colour.SIDEBAR_CLASSES,
    *heterogeneity.SIDEBAR_CLASSES,
    *paint_air.CLASSES,
    *animate.SIDEBAR_CLASSES,
    *output.SIDEBAR_CLASSES,
    *over_engine.CLASSES,
    # The tab of voxels.
    *voxels.SIDEBAR_CLASSES,
)


def register() -> None:
    standard.register()
    for cls in CLASSES:
        register_class(cls)
    voxels.register()


def unregister() -> None:
    voxels.unregister()
    for cls in reversed(CLASSES):
        unregister_class(cls)
    standard.unregister()
