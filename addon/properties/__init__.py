# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that are saved in the .blend: ``tyndall`` of scenes, view layers, worlds, objects, lights and node trees.

That of a viewport's shading, too, which belongs to its window. And ``tyndall_voxels`` of objects: what makes one stand
for the voxels of a file.
"""

from bpy.props import PointerProperty
from bpy.types import Light, NodeTree, Object, Scene, View3DShading, ViewLayer, World
from bpy.utils import register_class, unregister_class

from . import air_brush, light_map_fit, occluder_edits, painted_air, transfer_functions, transfer_layers, voxels
from .heterogeneity import TyndallHeterogeneity
from .indirect import TyndallIndirectSettings
from .light import TyndallLightSettings
from .light_shafts import TyndallLightShaftSettings
from .over_engine import TyndallOverEngine
from .painted_air import TyndallObjectSettings
from .scene import TyndallSceneSettings
from .tagging import OVERRIDABLE, tag
from .transfer_functions import TyndallTransferFunction
from .view_layer import TyndallViewLayerSettings
from .viewport_shading import TyndallViewportShading
from .voxels import TyndallVoxels
from .world import TyndallWorldSettings

#: In the order of registration: a group before the group that points to it.
CLASSES = (
    *occluder_edits.CLASSES,
    *light_map_fit.CLASSES,
    *transfer_layers.CLASSES,
    *transfer_functions.CLASSES,
    *painted_air.CLASSES,
    *air_brush.CLASSES,
    *voxels.CLASSES,
    TyndallLightShaftSettings,
    TyndallHeterogeneity,
    TyndallIndirectSettings,
    TyndallOverEngine,
    TyndallSceneSettings,
    TyndallLightSettings,
    TyndallViewLayerSettings,
    TyndallViewportShading,
    TyndallWorldSettings,
)
OWNERS = (
    (Scene, TyndallSceneSettings),
    (Object, TyndallObjectSettings),
    (Light, TyndallLightSettings),
    (ViewLayer, TyndallViewLayerSettings),
    (World, TyndallWorldSettings),
    (NodeTree, TyndallTransferFunction),
)


def register() -> None:
    for cls in CLASSES:
        register_class(cls)
    for owner, settings in OWNERS:
        owner.tyndall = PointerProperty(name="Tyndall", type=settings, update=tag, override=OVERRIDABLE)
    View3DShading.tyndall = PointerProperty(name="Tyndall", type=TyndallViewportShading)
    Object.tyndall_voxels = PointerProperty(name="Voxels", type=TyndallVoxels, update=tag, override=OVERRIDABLE)


def unregister() -> None:
    del Object.tyndall_voxels, View3DShading.tyndall
    for owner, _settings in OWNERS:
        del owner.tyndall
    for cls in reversed(CLASSES):
        unregister_class(cls)
