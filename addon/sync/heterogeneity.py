# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air at a frame: keys and drivers have their values, and the wind has carried it so far."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.heterogeneity import AirNoise, Heterogeneity

from .wind import carried_m

if TYPE_CHECKING:
    from bpy.types import Scene

    from .reports import Reports


def read_heterogeneity(scene: Scene, reports: Reports, *, is_viewport: bool = False) -> Heterogeneity | None:
    """``scene`` is evaluated. None: the air is even."""
    settings = scene.tyndall.heterogeneity
    if not settings.is_enabled:
        return None
    carried = carried_m(scene, reports)
    x, y, z = (offset_m + way_m for offset_m, way_m in zip(settings.offset_m, carried, strict=True))
    return Heterogeneity(
        noise=AirNoise(
            scale_m=settings.scale_m,
            octaves=settings.octaves,
            persistence=settings.persistence,
            seed=settings.seed,
        ),
        moved_m=(x, y, z),
        amount=settings.amount,
        level=settings.level,
        intensity=settings.intensity,
        weighting=settings.weighting,
        step_count=settings.step_count,
        upsampling=int(settings.viewport_upsampling if is_viewport else settings.upsampling),
    )
