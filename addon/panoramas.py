# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' panoramas: where Blender keeps their settings, at the camera since 4.x, and with Cycles' own before."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bpy.types import Camera

EQUIRECTANGULAR = "EQUIRECTANGULAR"
FISHEYE_EQUIDISTANT = "FISHEYE_EQUIDISTANT"
FISHEYE_EQUISOLID = "FISHEYE_EQUISOLID"
FISHEYE_LENS_POLYNOMIAL = "FISHEYE_LENS_POLYNOMIAL"
MIRRORBALL = "MIRRORBALL"
EQUIANGULAR_CUBEMAP_FACE = "EQUIANGULAR_CUBEMAP_FACE"
CENTRAL_CYLINDRICAL = "CENTRAL_CYLINDRICAL"  #: Not in 3.4.


def panorama_settings(data: Camera) -> Any:  # noqa: ANN401  of the one kind or the other
    """What has ``panorama_type`` and its limits; None where Cycles, which keeps them before 4.x, is not enabled."""
    return data if hasattr(data, "panorama_type") else getattr(data, "cycles", None)
