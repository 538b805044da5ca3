# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees the scene."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class CameraKind(IntEnum):
    """How view rays leave the camera."""

    PERSPECTIVE = 0
    ORTHOGRAPHIC = 1
    PANORAMIC = 2


class PanoramaKind(IntEnum):
    """What the window of a panoramic camera means; (0, 0) is straight ahead."""

    EQUIRECTANGULAR = 0  #: Longitude and latitude, radians.
    FISHEYE_EQUIDISTANT = 1  #: Their length is the angle from ahead, radians.
    FISHEYE_EQUISOLID = 2  #: Their length is the sine of half the angle: lengths on a sensor by 2 focal lengths.
    FISHEYE_POLYNOMIAL = 3  #: Lengths on the sensor, in the unit of the polynomial.
    MIRROR_BALL = 4  #: Radii of the ball.
    EQUIANGULAR_CUBEMAP_FACE = 5  #: Angles to the right and up, each seen along the other axis, radians.
    CENTRAL_CYLINDRICAL = 6  #: Longitude, radians; height on a cylinder of radius 1.


@dataclass(frozen=True, kw_only=True)
class Panorama:
    """Where a panoramic camera looks."""

    kind: PanoramaKind = PanoramaKind.EQUIRECTANGULAR
    #: Of fisheyes and mirror balls: the longest way from (0, 0) that is shown; of a polynomial the largest angle.
    rim: float = math.inf
    #: Of a polynomial: radians, of the powers 0 to 4 of the radius.
    angle_by_radius: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Lens:
    """What blurs that which is not in focus, as soon as a pixel has more than one sample.

    Shafts are seen through one point of it: pictures through several add up to their blur (lens_points.py).
    """

    radius_m: float  #: Of the circle around the aperture, above 0.
    focus_m: float  #: Along -Z (panoramic: along the ray), above 0.
    blades: int = 0  #: Sides of the aperture; fewer than 3: a disc.
    rotation_rad: float = 0.0  #: Of the blades.
    ratio: float = 1.0  #: Height of the aperture by its width, above 0.
    #: Where shafts are seen through, of a perspective camera's: a place of [0, 1)^2 whose equal areas are equal ones of
    #: the aperture. None: its middle.
    air_place: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Camera:
    """Sensor fit, shift and pixel aspect are already resolved into the window."""

    kind: CameraKind
    world_from_camera: NDArray[np.float64]  #: (4, 4), no scale; looks along -Z.
    #: Left, right, bottom, top: at 1 m (perspective), metres (orthographic), or in the panorama's units.
    window: tuple[float, float, float, float]
    clip_m: tuple[float, float]  #: Near and far, along -Z (panoramic: along the ray).
    size_px: tuple[int, int]  #: Width and height of the full frame.
    lens: Lens | None = None  #: None: all is sharp.
    panorama: Panorama = field(default_factory=Panorama)  #: Of a panoramic camera.
