# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's panoramic cameras with their lens, sensor fit, shift and pixel aspect resolved into a window.

As in Cycles the window covers the frame whatever its proportions, so that circles are ellipses in a frame that is not a
square; only fisheyes with a sensor keep their own. The shift is counted in widths and heights of the frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tyndall.scene_description import Panorama, PanoramaKind

from ..panoramas import (
    CENTRAL_CYLINDRICAL,
    EQUIANGULAR_CUBEMAP_FACE,
    EQUIRECTANGULAR,
    FISHEYE_EQUIDISTANT,
    FISHEYE_EQUISOLID,
    FISHEYE_LENS_POLYNOMIAL,
    MIRRORBALL,
    panorama_settings,
)
from .finite_numbers import are_finite

if TYPE_CHECKING:
    from collections.abc import Callable

    import bpy

    from .reports import Reports

Window = tuple[float, float, float, float]  #: Left, right, bottom, top.


@dataclass(frozen=True)
class SeenPanorama:
    """What a frame shows."""

    panorama: Panorama
    window: Window


def read_panorama(
    data: bpy.types.Camera,
    render: bpy.types.RenderSettings,
    size_px: tuple[int, int],
    shift: tuple[float, float],
    culprit: str,
    reports: Reports,
) -> SeenPanorama | None:
    """None, and a report: it is drawn in perspective. Raises ``ValueError`` for one that shows nothing."""
    settings = panorama_settings(data)
    if settings is None:
        reports.add(culprit, "its panorama is kept by the Cycles add-on, which is off: drawn in perspective")
        return None
    read = _READERS.get(settings.panorama_type)
    if read is None:
        kind = settings.panorama_type.replace("_", " ").lower()
        reports.add(culprit, f"a panorama of the kind {kind}, which is not known: drawn in perspective")
        return None
    aspect = render.pixel_aspect_y / render.pixel_aspect_x
    # As wide and high as the frame, in the sensor's unit.
    extent_px, sensor = sensor_over_frame(data, aspect, size_px)
    per_px = sensor / extent_px
    seen = read(settings, (size_px[0] * per_px, aspect * size_px[1] * per_px), culprit)
    left, right, bottom, top = seen.window
    across, up = shift[0] * (right - left), shift[1] * (top - bottom)
    return SeenPanorama(seen.panorama, (left + across, right + across, bottom + up, top + up))


def sensor_over_frame(data: bpy.types.Camera, aspect: float, size_px: tuple[int, int]) -> tuple[float, float]:
    """The side of the frame that the sensor spans, in pixels along x, and the sensor's size, in millimetres."""
    is_wide = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and size_px[0] >= aspect * size_px[1])
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    return (size_px[0] if is_wide else aspect * size_px[1]), sensor


def _around(half_width: float, half_height: float) -> Window:
    return -half_width, half_width, -half_height, half_height


def _range(culprit: str, across: tuple[float, float], up: tuple[float, float], names: str) -> Window:
    if across[0] == across[1] or up[0] == up[1]:
        raise ValueError(f"{culprit}: its panorama's least and largest {names} are equal")
    return *across, *up


def _equirectangular(settings: Any, _sensor: tuple[float, float], culprit: str) -> SeenPanorama:  # noqa: ANN401
    longitude, latitude = (
        (getattr(settings, f"{name}_min"), getattr(settings, f"{name}_max")) for name in ("longitude", "latitude")
    )
    return SeenPanorama(Panorama(), _range(culprit, longitude, latitude, "latitude or longitude"))


def _equidistant(settings: Any, _sensor: tuple[float, float], _culprit: str) -> SeenPanorama:  # noqa: ANN401
    half = settings.fisheye_fov / 2
    return SeenPanorama(Panorama(kind=PanoramaKind.FISHEYE_EQUIDISTANT, rim=half), _around(half, half))


def _equisolid(settings: Any, sensor: tuple[float, float], _culprit: str) -> SeenPanorama:  # noqa: ANN401
    rim, per_mm = math.sin(settings.fisheye_fov / 4), 1 / (2 * settings.fisheye_lens)
    window = _around(sensor[0] / 2 * per_mm, sensor[1] / 2 * per_mm)
    return SeenPanorama(Panorama(kind=PanoramaKind.FISHEYE_EQUISOLID, rim=rim), window)


def _polynomial(settings: Any, sensor: tuple[float, float], culprit: str) -> SeenPanorama:  # noqa: ANN401
    k0, k1, k2, k3, k4 = factors = [getattr(settings, f"fisheye_polynomial_k{power}") for power in range(5)]
    if not are_finite(factors):
        raise ValueError(f"{culprit}: its lens polynomial is not finite")
    panorama = Panorama(
        kind=PanoramaKind.FISHEYE_POLYNOMIAL, rim=settings.fisheye_fov / 2, angle_by_radius=(-k0, -k1, -k2, -k3, -k4)
    )
    return SeenPanorama(panorama, _around(sensor[0] / 2, sensor[1] / 2))


def _mirror_ball(_settings: Any, _sensor: tuple[float, float], _culprit: str) -> SeenPanorama:  # noqa: ANN401
    return SeenPanorama(Panorama(kind=PanoramaKind.MIRROR_BALL, rim=1.0), _around(1.0, 1.0))


def _cubemap_face(_settings: Any, _sensor: tuple[float, float], _culprit: str) -> SeenPanorama:  # noqa: ANN401
    quarter = math.pi / 4
    return SeenPanorama(Panorama(kind=PanoramaKind.EQUIANGULAR_CUBEMAP_FACE), _around(quarter, quarter))


def _cylindrical(settings: Any, _sensor: tuple[float, float], culprit: str) -> SeenPanorama:  # noqa: ANN401
    radius = settings.central_cylindrical_radius
    longitude = settings.central_cylindrical_range_u_min, settings.central_cylindrical_range_u_max
    height = settings.central_cylindrical_range_v_min / radius, settings.central_cylindrical_range_v_max / radius
    window = _range(culprit, longitude, height, "longitude or height")
    return SeenPanorama(Panorama(kind=PanoramaKind.CENTRAL_CYLINDRICAL), window)


_READERS: dict[str, Callable[[Any, tuple[float, float], str], SeenPanorama]] = {
    EQUIRECTANGULAR: _equirectangular,
    FISHEYE_EQUIDISTANT: _equidistant,
    FISHEYE_EQUISOLID: _equisolid,
    FISHEYE_LENS_POLYNOMIAL: _polynomial,
    MIRRORBALL: _mirror_ball,
    EQUIANGULAR_CUBEMAP_FACE: _cubemap_face,
    CENTRAL_CYLINDRICAL: _cylindrical,
}
