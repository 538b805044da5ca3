# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own panels that mean something under our engine: each asks engines to enter themselves.

A panel that lists BLENDER_RENDER is meant for every engine. Those left out would show settings that nobody reads.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from .base import ENGINE

#: Panels for other engines only that fit ours.
BORROWED = frozenset({"EEVEE_MATERIAL_PT_context_material", "MATERIAL_PT_preview"})

LEFT_OUT = frozenset(
    {
        "DATA_PT_area",  # ours: Light
        "DATA_PT_falloff_curve",
        "DATA_PT_light",  # ours: Light
        "DATA_PT_lightprobe",
        "DATA_PT_spot",  # ours: Beam Shape
        "DATA_PT_volume_render",
        "NODE_DATA_PT_light",
        "NODE_DATA_PT_spot",
        "VIEWLAYER_PT_layer_passes",  # ours: Passes
    }
)
#: Freestyle strokes and stereoscopy are not rendered, and light probes are EEVEE's.
LEFT_OUT_PREFIXES = (
    "DATA_PT_camera_stereoscopy",
    "DATA_PT_lightprobe_",
    "MATERIAL_PT_freestyle",
    "RENDER_PT_freestyle",
    "RENDER_PT_simplify",  # ours: Simplify
    "RENDER_PT_stereoscopy",
    "VIEWLAYER_PT_freestyle",
)


def standard_panels() -> Iterator[type[bpy.types.Panel]]:
    """Blender's panels that show under our engine."""
    for panel in bpy.types.Panel.__subclasses__():
        name = panel.__name__
        if name in LEFT_OUT or name.startswith(LEFT_OUT_PREFIXES):
            continue
        if name in BORROWED or "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()):
            yield panel


def register() -> None:
    for panel in standard_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines and panel.__module__.startswith("bl_ui"):
            engines.discard(ENGINE)
