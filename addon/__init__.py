# SPDX-License-Identifier: GPL-3.0-or-later
"""Tyndall in Blender: engine, settings, panels and operators. One folder, legacy add-on and extension at once.

Only the engine needs the native core: where that does not load, all else registers, and the panels say why.
"""

from importlib import import_module
from types import ModuleType

bl_info = {
    "name": "Tyndall",
    "author": "The Tyndall authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render Properties > Render Engine",
    "description": "Exact light shafts in fog, haze and smoke",
    "category": "Render",
}

_PARTS = (
    ".properties",
    ".granted_writes",
    ".transfer_function_preview",
    ".operators",
    ".panels",
    ".constraint_markers",
    ".fitted_maps",
    ".stroke_views",
    ".air_painting",
    ".air_painting_view",
    ".air_tool",
    ".residual_plot",
    ".voxel_reading",
    ".voxel_preview",
    ".preferences",
    ".last_render",
    ".over_engine.handlers",
)
_registered: list[ModuleType] = []


def register() -> None:
    """Register everything, the engine last: nothing renders before its settings exist."""
    availability = import_module(".availability", __package__)
    engine = ".engine" if availability.load() else ".unavailable_engine"
    for name in (*_PARTS, engine):
        module = import_module(name, __package__)
        module.register()
        _registered.append(module)


def unregister() -> None:
    """Undo it backwards. An engine that is still registered when Blender ends crashes or hangs it."""
    while _registered:
        _registered.pop().unregister()
