# SPDX-License-Identifier: GPL-3.0-or-later
"""Where on a lens light shafts are seen through, picture by picture, so that what is out of focus blurs in the mean.

Based on: Haeberli and Akeley, The Accumulation Buffer, SIGGRAPH 1990; Halton 1960.
Differs:  surfaces have a place on the lens for each sample of each pixel. Shafts have one for a part of all samples:
          their slope rows need rays that leave from one point.
"""

from __future__ import annotations

from dataclasses import replace

from .scene_description import Camera, CameraKind

Place = tuple[float, float]


def has_lens_points(camera: Camera) -> bool:
    """Whether its lens blurs, and the rays through a point of it are those of a camera."""
    return camera.lens is not None and camera.kind == CameraKind.PERSPECTIVE


def lens_point(index: int) -> Place:
    """Of as many as are asked for, spread evenly; of [0, 1)^2. Neither number rises with the index, nor with time."""
    return _radical_inverse(index, 2), _radical_inverse(index, 3)


def seen_through(camera: Camera, place: Place) -> Camera:
    """The camera whose shafts are seen through there."""
    lens = None if camera.lens is None else replace(camera.lens, air_place=place)
    return replace(camera, lens=lens)


def _radical_inverse(index: int, base: int) -> float:
    """Digits of the index, mirrored behind the point."""
    share, found = 1.0, 0.0
    while index:
        share /= base
        found += share * (index % base)
        index //= base
    return found
