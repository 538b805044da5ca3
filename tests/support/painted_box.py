# SPDX-License-Identifier: GPL-3.0-or-later
"""A box to paint the air in, and strokes through it: for the tests of painting."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy

from addon import painted_air
from support.small_scenes import add, empty_scene

VOXELS = 32
#: Of the box: 4 m around the origin.
HALF_SIDE_M = 2.0


def painted_box() -> bpy.types.Object:
    """The scene's painted air, 32 voxels of 12.5 cm along each side; a hard brush that sets 0.5 fully."""
    scene = empty_scene()
    painted_air.forget()
    thing = add("Air", None)
    thing.empty_display_type, thing.empty_display_size = "CUBE", HALF_SIDE_M
    thing.tyndall.painted_air.resolution = (VOXELS,) * 3
    scene.tyndall.heterogeneity.painted = thing
    brush = scene.tyndall.air_brush
    brush.volume, brush.mode, brush.radius_m, brush.depth = "AMOUNT", "PAINT", 0.5, 1.0
    brush.amount, brush.opacity, brush.hardness = 0.5, 1.0, 1.0
    bpy.context.view_layer.update()
    return thing


def stroke(*places_m: Sequence[float], pressure: float = 1.0, **options: Any) -> set[str]:
    """With the scene's brush."""
    dabs = [{"name": "", "location": tuple(place_m), "pressure": pressure} for place_m in places_m]
    return bpy.ops.tyndall.paint_air_stroke(dabs=dabs, **options)
