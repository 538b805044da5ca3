# SPDX-License-Identifier: GPL-3.0-or-later
"""Where Blender keeps what Cycles' panoramas are: at the camera since 4.x, with Cycles' own settings before."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bpy.types import Camera

#: The one that is drawn.
EQUIRECTANGULAR = "EQUIRECTANGULAR"


def panorama_settings(data: Camera) -> Any:  # noqa: ANN401  of the one kind or the other
    """What has ``panorama_type`` and its limits; None where Cycles, which keeps them before 4.x, is not enabled."""
    return data if hasattr(data, "panorama_type") else getattr(data, "cycles", None)
