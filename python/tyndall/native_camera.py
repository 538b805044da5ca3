# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras as the native side has them, and single rays of theirs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import _native
from .scene_description import Camera, Lens

if TYPE_CHECKING:
    from collections.abc import Sequence

Place = tuple[float, float]
Vector = tuple[float, float, float]


def native_camera(camera: Camera, origin_in_world: NDArray[np.float64]) -> _native.Camera:
    """In the scene's space, whose origin that is. Raises ``InvalidInput``."""
    matrix = np.array(camera.world_from_camera, dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise _native.InvalidInput("camera: its matrix is not finite")
    matrix[:3, 3] -= origin_in_world
    lens = camera.lens if camera.lens is not None else Lens(radius_m=0.0, focus_m=1.0)
    if not lens.ratio > 0.0:
        raise _native.InvalidInput(f"camera: its aperture has a ratio of {lens.ratio:g}; it must be above 0")
    return _native.Camera(
        kind=int(camera.kind),
        world_from_camera=matrix.astype(np.float32, order="C"),
        window=camera.window,
        clip_m=camera.clip_m,
        size_px=camera.size_px,
        lens_radius_m=lens.radius_m,
        focus_m=lens.focus_m,
        blades=lens.blades,
        blades_rotation_rad=lens.rotation_rad,
        aperture_ratio=lens.ratio,
        air_u=lens.air_place,
        panorama_kind=int(camera.panorama.kind),
        rim=camera.panorama.rim,
        angle_by_radius=camera.panorama.angle_by_radius,
    )


def require_usable(camera: Camera) -> None:
    """Raise ``InvalidInput``, whose text begins with "camera: ", for one that cannot be rendered with."""
    native_camera(camera, np.array(camera.world_from_camera[:3, 3], dtype=np.float64)).require_usable()


def ray_through(camera: Camera, place_px: Place) -> tuple[Vector, Vector] | None:
    """Origin, at the near clip, and unit direction, in world space; None: beside what the camera shows.

    The place is one of the full frame, from its left and bottom. Raises ``InvalidInput``.
    """
    position = np.array(camera.world_from_camera[:3, 3], dtype=np.float64)
    found = native_camera(camera, position).ray_through(*place_px)
    if found is None:
        return None
    origin, direction = found
    return _vector(position + origin), _vector(direction)


def raster_position(camera: Camera, world_point: Sequence[float]) -> Place | None:
    """Where a camera shows a point, in pixels of its full frame from its left and bottom; None: nowhere.

    It may lie beside the frame, and beyond a panorama's rim. Raises ``InvalidInput``.
    """
    position = np.array(camera.world_from_camera[:3, 3], dtype=np.float64)
    return native_camera(camera, position).raster_position(*(np.array(world_point, dtype=np.float64) - position))


def _vector(values: Sequence[float] | NDArray[np.float64]) -> Vector:
    return float(values[0]), float(values[1]), float(values[2])
