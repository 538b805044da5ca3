# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera properties: the kind of a panorama, its lens, and what part of all directions it shows."""

from __future__ import annotations

from bpy.types import Context, Panel

from ..panoramas import (
    CENTRAL_CYLINDRICAL,
    EQUIRECTANGULAR,
    FISHEYE_EQUIDISTANT,
    FISHEYE_EQUISOLID,
    FISHEYE_LENS_POLYNOMIAL,
    panorama_settings,
)
from .base import PropertiesPanel

_RANGES = {
    EQUIRECTANGULAR: (("latitude", "Latitude"), ("longitude", "Longitude")),
    CENTRAL_CYLINDRICAL: (
        ("central_cylindrical_range_v", "Height"),
        ("central_cylindrical_range_u", "Longitude"),
    ),
}
_SETTINGS = {
    CENTRAL_CYLINDRICAL: ("central_cylindrical_radius",),
    FISHEYE_EQUIDISTANT: ("fisheye_fov",),
    FISHEYE_EQUISOLID: ("fisheye_lens", "fisheye_fov"),
    FISHEYE_LENS_POLYNOMIAL: ("fisheye_fov", *(f"fisheye_polynomial_k{power}" for power in range(5))),
}


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
        kind = settings.panorama_type
        for name, text in _RANGES.get(kind, ()):
            column = layout.column(align=True)
            column.prop(settings, f"{name}_min", text=f"{text} Min")
            column.prop(settings, f"{name}_max", text="Max")
        for name in _SETTINGS.get(kind, ()):
            layout.prop(settings, name)


CLASSES = (TYNDALL_PT_panorama,)
