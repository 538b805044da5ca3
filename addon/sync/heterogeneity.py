# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air at a frame: keys and drivers have their values, and the wind has carried it so far."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.heterogeneity import AirNoise, Heterogeneity

from ..painted_air import painted_air
from .wind import carried_m

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Scene

    from tyndall.heterogeneity import PaintedAir

    from .reports import Reports


def read_heterogeneity(
    depsgraph: Depsgraph, reports: Reports, scene: Scene | None = None, *, is_viewport: bool = False
) -> Heterogeneity | None:
    """None: the air is even. A painted box that cannot be used is left out, with a report; the rest of it stays.

    ``scene`` is evaluated, and has the settings; the depsgraph's own without it.
    """
    scene = scene or depsgraph.scene_eval
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
            contrast=settings.contrast,
            seed=settings.seed,
        ),
        moved_m=(x, y, z),
        amount=settings.amount,
        level=settings.level,
        intensity=settings.intensity,
        weighting=settings.weighting,
        step_count=settings.step_count,
        upsampling=int(settings.viewport_upsampling if is_viewport else settings.upsampling),
        painted=_painted(scene.original, depsgraph, reports),
    )


def _painted(scene: Scene, depsgraph: Depsgraph, reports: Reports) -> PaintedAir | None:
    """``scene`` is the original: an evaluated pointer may outlive what it points to."""
    box = scene.tyndall.heterogeneity.painted
    if box is None:
        return None
    culprit = f'Scene "{scene.name}"'
    if scene.objects.get(box.name) != box:  # one that was deleted lives on in our pointer
        reports.add(culprit, f'its painted air is left out: "{box.name}" is not in the scene')
        return None
    try:
        return painted_air(box.evaluated_get(depsgraph))
    except ValueError as error:
        reports.add(culprit, f"its painted air is left out: {error}")
        return None
