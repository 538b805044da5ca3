# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera properties: what part of all directions a panorama shows."""

from __future__ import annotations

from bpy.types import Context, Panel

from ..panoramas import EQUIRECTANGULAR, panorama_settings
from .base import PropertiesPanel


class TYNDALL_PT_panorama(PropertiesPanel, Panel):
    """Blender's own panel has these for Cycles alone."""

    bl_label = "Panorama"
    bl_context = "data"
    bl_parent_id = "DATA_PT_lens"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.camera is not None and context.camera.type == "PANO"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        settings = panorama_settings(context.camera)
        if settings is None:
            layout.label(text="Enable the Cycles add-on, which keeps these settings", icon="INFO")
            return
        layout.prop(settings, "panorama_type")
        if settings.panorama_type != EQUIRECTANGULAR:
            layout.label(text="Only Equirectangular is drawn; this one in perspective", icon="INFO")
            return
        for name in ("latitude", "longitude"):
            column = layout.column(align=True)
            column.prop(settings, f"{name}_min")
            column.prop(settings, f"{name}_max", text="Max")


CLASSES = (TYNDALL_PT_panorama,)
