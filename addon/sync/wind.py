# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the wind has carried the texture of the air at a frame: the integral of its speed since frame 0.

It is a function of the frame and the keys alone: the same whichever frame renders first, in a window or without one.
Speed times time would jump back and forth wherever a key changes the speed.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from ..animation_paths import animates_by_other_means, curves_at
from ..properties.heterogeneity import WIND_PATH

if TYPE_CHECKING:
    from bpy.types import FCurve, Scene

    from .reports import Reports


def carried_m(scene: Scene, reports: Reports) -> tuple[float, float, float]:
    """Along x, y and z, at the present frame of an evaluated scene. Frame 0 is where it starts; before, it is upwind.

    What is driven, or animated by strips of the NLA editor, has no past that could be asked for: its present speed
    counts for all the time, with a report.
    """
    owner = scene.original
    if animates_by_other_means(owner, WIND_PATH):
        reports.add(
            f'Scene "{owner.name}"',
            "its wind is driven, or animated by an NLA strip: taken as if it had always blown as it does now. "
            "Keyframe it, or drive the offset instead",
        )
        curves = {}
    else:
        curves = {curve.array_index: curve for curve in curves_at(owner, WIND_PATH) if not _is_muted(curve)}
    frame = scene.frame_current_final
    frames_per_s = scene.render.fps / scene.render.fps_base
    x, y, z = (
        (integral(curves[axis], frame) if axis in curves else speed * frame) / frames_per_s
        for axis, speed in enumerate(scene.tyndall.heterogeneity.wind_m_per_s)
    )
    return x, y, z


def integral(curve: FCurve, frame: float) -> float:
    """Of an F-Curve's value from frame 0 to ``frame``, by the midpoint rule between whole frames and keys.

    Continuous in ``frame``, also where the value steps; exact where the curve is made of straight lines between keys.
    """
    first, last = min(0.0, frame), max(0.0, frame)
    places = [first, *_corners(curve, first, last), last]
    area = sum(curve.evaluate(0.5 * (begin + end)) * (end - begin) for begin, end in pairwise(places))
    return math.copysign(1.0, frame) * area


def _corners(curve: FCurve, first: float, last: float) -> list[float]:
    """Where the rule has to look, strictly between two frames. Beyond its keys a curve is straight, unless modified."""
    keys = [key.co.x for key in curve.keyframe_points]
    if not curve.modifiers:
        first, last = max(first, min(keys, default=last)), min(last, max(keys, default=first))
        inside = {key for key in keys if first <= key <= last}
    else:
        inside = {key for key in keys if first < key < last}
    inside |= {float(whole) for whole in range(math.floor(first) + 1, math.ceil(last))}
    return sorted(inside)


def _is_muted(curve: FCurve) -> bool:
    return curve.mute or (curve.group is not None and curve.group.mute)
