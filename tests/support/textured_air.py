# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene whose air has a texture, and what is sent of it: for the tests of the texture and of its wind."""

from __future__ import annotations

import bpy

from addon.animation_paths import curves_at
from addon.properties.heterogeneity import WIND_PATH, TyndallHeterogeneity
from addon.sync.heterogeneity import read_heterogeneity
from addon.sync.reports import Reports
from support.small_scenes import empty_scene
from tyndall.heterogeneity import Heterogeneity


def textured_air() -> TyndallHeterogeneity:
    """The texture of a scene at 24 frames a second, switched on."""
    scene = empty_scene()
    scene.render.fps, scene.render.fps_base = 24, 1.0
    scene.tyndall.heterogeneity.is_enabled = True
    return scene.tyndall.heterogeneity


def read(*, is_viewport: bool = False) -> tuple[Heterogeneity | None, tuple[str, ...]]:
    """What a render would be given at this frame, and what it would be told."""
    reports = Reports()
    return read_heterogeneity(bpy.context.evaluated_depsgraph_get(), reports, is_viewport=is_viewport), reports.lines()


def sent() -> Heterogeneity:
    heterogeneity, lines = read()
    assert heterogeneity is not None
    assert lines == ()
    return heterogeneity


def at(frame: float) -> Heterogeneity:
    bpy.context.scene.frame_set(int(frame // 1), subframe=frame % 1)
    return sent()


def key_wind(*keys: tuple[float, float], axis: int = 0, interpolation: str = "LINEAR") -> bpy.types.FCurve:
    """Of frames and speeds, m/s."""
    scene = bpy.context.scene
    for frame, speed in keys:
        scene.tyndall.heterogeneity.wind_m_per_s[axis] = speed
        scene.keyframe_insert(WIND_PATH, index=axis, frame=frame)
    (curve,) = (curve for curve in curves_at(scene, WIND_PATH) if curve.array_index == axis)
    for key in curve.keyframe_points:
        key.interpolation = interpolation
    return curve
