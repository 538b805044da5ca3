# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's settings of motion blur, which are Cycles' own: when the shutter opens and closes around a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tyndall.shutter_times import CURVE_INTERVALS, Moment, moments

from ..shutter_position import position_settings

if TYPE_CHECKING:
    from bpy.types import Depsgraph, Scene, ViewLayer

    from ..sync.reports import Reports

_FIRST_FRAME, _LAST_FRAME = -1048574.0, 1048574.0  #: Blender's.
#: What part of its time the shutter is open before the frame.
_SHARE_BEFORE = {"START": 0.0, "CENTER": 0.5, "END": 1.0}


def frame_parts(frame: float) -> tuple[int, float]:
    """As ``RenderEngine.frame_set`` takes it: whole frame and the part of one behind it; within Blender's range."""
    frame = min(max(frame, _FIRST_FRAME), _LAST_FRAME)
    whole = int(np.floor(frame))
    return whole, float(frame - whole)


@dataclass(frozen=True, kw_only=True)
class Shutter:
    """Opens at a frame and stays open for so many frames; at equal distances in this time, it is so far open."""

    opens_frame: float
    open_frames: float
    openness: tuple[float, ...]

    def frame_of(self, moment: Moment) -> tuple[int, float]:
        """As ``frame_parts``."""
        return frame_parts(self.opens_frame + moment.time * self.open_frames)

    def moments(self, pixel_samples: int, most: int) -> list[Moment]:
        return moments(pixel_samples, most, self.openness)


def read_shutter(scene: Scene, view_layer: ViewLayer) -> Shutter | None:
    """Around the scene's present frame; None where scene or view layer want no blur."""
    render = scene.render
    if not (render.use_motion_blur and getattr(view_layer, "use_motion_blur", True)):
        return None
    owner = position_settings(scene)
    position = "CENTER" if owner is None else owner.motion_blur_position
    curve = render.motion_blur_shutter_curve
    curve.initialize()
    return Shutter(
        opens_frame=scene.frame_current + scene.frame_subframe - _SHARE_BEFORE[position] * render.motion_blur_shutter,
        open_frames=render.motion_blur_shutter,
        openness=tuple(
            curve.evaluate(curve.curves[0], index / CURVE_INTERVALS) for index in range(CURVE_INTERVALS + 1)
        ),
    )


def report_unfollowed(scene: Scene, depsgraph: Depsgraph, view_layer: ViewLayer, reports: Reports) -> None:
    """What is asked for beyond that, and has no answer while the shutter is open."""
    if view_layer.use_pass_vector:
        reports.add(f'View layer "{view_layer.name}"', "its pass Vector is empty under motion blur, as in Cycles")
    if getattr(getattr(scene, "cycles", None), "rolling_shutter_type", "NONE") != "NONE":
        reports.add(f'Scene "{scene.name}"', "its shutter rolls, which is not followed: it opens everywhere at once")
    for thing in depsgraph.objects:
        if not getattr(getattr(thing, "cycles", None), "use_motion_blur", True):
            reports.add(f'Object "{thing.name}"', "its motion blur is off, which is not followed: it blurs if it moves")
