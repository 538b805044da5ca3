# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's cameras with sensor fit, shift and pixel aspect resolved into a window, and their lens."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tyndall.native_camera import require_usable
from tyndall.scene_description import Camera, CameraKind, Lens, Panorama

from .panoramas import read_panorama, sensor_over_frame

if TYPE_CHECKING:
    import bpy
    from numpy.typing import NDArray

    from .reports import Reports

_LARGEST_COORDINATE_M = 1e18  #: Beyond it, squares do not fit into single precision.
#: Of the aperture's radius; the native side refuses half of it. So near, all is blurred over the whole picture.
_NEAREST_FOCUS = 2e-4
_UNLIMITED_M = (1e-5, 1e5)
_CONE_RAD = math.radians(45)  #: Of lights that are no spots.


@dataclass(frozen=True)
class _Sight:
    """What Cycles looks through where the scene's camera is another object."""

    lens: float  #: Millimetres, as the sensor.
    type: str = "PERSP"
    sensor_fit: str = "AUTO"
    sensor_width: float = 36.0
    sensor_height: float = 24.0
    ortho_scale: float = 1.0


def read_camera(
    thing: bpy.types.Object,
    render: bpy.types.RenderSettings,
    size_px: tuple[int, int],
    reports: Reports,
    *,
    world_from_camera: NDArray[np.float64] | None = None,
    shift_x: float | None = None,
) -> Camera:
    """The evaluated camera object of a frame of ``size_px``. Matrix and shift are those of a stereo view, if given.

    Raises ``ValueError``, which names it, for one that nothing can be seen through.
    """
    placed = np.array(thing.matrix_world if world_from_camera is None else world_from_camera, dtype=np.float64)
    if not (np.abs(placed) < _LARGEST_COORDINATE_M).all() or np.linalg.det(placed[:3, :3]) == 0.0:
        raise ValueError(f'Camera "{thing.name}": its position is not finite, or its scale is 0')
    if thing.type != "CAMERA":
        window = _window(_sight(thing), render, size_px, (0.0, 0.0))
        return Camera(
            kind=CameraKind.PERSPECTIVE,
            world_from_camera=without_scale(placed),
            window=window,
            clip_m=_UNLIMITED_M,
            size_px=size_px,
        )
    data, culprit = thing.data, f'Camera "{thing.name}"'
    shift = data.shift_x if shift_x is None else shift_x, data.shift_y
    seen = read_panorama(data, render, size_px, shift, culprit, reports) if data.type == "PANO" else None
    if seen is not None:
        kind, panorama, window = CameraKind.PANORAMIC, seen.panorama, seen.window
    else:
        kind, panorama = CameraKind.ORTHOGRAPHIC if data.type == "ORTHO" else CameraKind.PERSPECTIVE, Panorama()
        window = _window(data, render, size_px, shift)
    if data.type == "CUSTOM":
        reports.add(culprit, "a custom camera of a script: drawn in perspective")
    camera = Camera(
        kind=kind,
        world_from_camera=without_scale(placed),
        window=window,
        clip_m=(data.clip_start, data.clip_end),
        size_px=size_px,
        lens=_lens(thing, placed, culprit, reports) if data.dof.use_dof else None,
        panorama=panorama,
    )
    try:
        require_usable(camera)
    except ValueError as error:  # of numbers that are none, which Blender's properties may hold
        raise ValueError(f"{culprit}: {str(error).removeprefix('camera: ')}") from None
    return camera


def _sight(thing: bpy.types.Object) -> _Sight:
    """A lamp's cone, or 50 mm."""
    if thing.type != "LIGHT":
        return _Sight(50.0)
    cone_rad = thing.data.spot_size if thing.data.type == "SPOT" else _CONE_RAD
    return _Sight(16.0 / math.tan(cone_rad / 2.0))


def _window(
    data: bpy.types.Camera | _Sight,
    render: bpy.types.RenderSettings,
    size_px: tuple[int, int],
    shift: tuple[float, float],
) -> tuple[float, float, float, float]:
    """Of a perspective camera, one metre ahead, or of an orthographic one, in metres."""
    aspect = render.pixel_aspect_y / render.pixel_aspect_x
    # Lengths below are in pixels along x; `extent_px` is the side of the frame that the sensor spans.
    extent_px, sensor = sensor_over_frame(data, aspect, size_px)
    metres_per_px = (data.ortho_scale if data.type == "ORTHO" else sensor / data.lens) / extent_px
    centre_x, centre_y = shift[0] * extent_px, shift[1] * extent_px
    half_width, half_height = size_px[0] / 2, aspect * size_px[1] / 2
    return (
        (centre_x - half_width) * metres_per_px,
        (centre_x + half_width) * metres_per_px,
        (centre_y - half_height) * metres_per_px,
        (centre_y + half_height) * metres_per_px,
    )


def _lens(thing: bpy.types.Object, placed: NDArray[np.float64], culprit: str, reports: Reports) -> Lens | None:
    """None, and a report: nothing can be in focus."""
    data, focus = thing.data, thing.data.dof
    distance_m = focus.focus_distance
    if focus.focus_object is not None:
        target = focus.focus_object.matrix_world
        if focus.focus_object.type == "ARMATURE" and (bone := focus.focus_object.pose.bones.get(focus.focus_subtarget)):
            target = target @ bone.matrix
        axis = placed[:3, 2] / np.linalg.norm(placed[:3, 2])
        distance_m = float(abs(axis @ (np.array(target.translation) - placed[:3, 3])))
    # Cycles' bound of the f-number; an orthographic camera's aperture is measured in metres.
    focal_m = 1.0 if data.type == "ORTHO" else data.lens * 1e-3
    radius_m = focal_m / (2.0 * max(focus.aperture_fstop, 1e-5))
    if not 0.0 < distance_m < _LARGEST_COORDINATE_M:
        reports.add(culprit, f"it focuses at {distance_m:g} m: everything is drawn in focus")
        return None
    nearest_m = _NEAREST_FOCUS * radius_m * max(1.0, 1.0 / focus.aperture_ratio)
    if distance_m < nearest_m:
        reports.add(culprit, f"it focuses at {distance_m:g} m, too near for its aperture: at {nearest_m:g} m")
        distance_m = nearest_m
    return Lens(
        radius_m=radius_m,
        focus_m=distance_m,
        blades=focus.aperture_blades,
        rotation_rad=focus.aperture_rotation,
        ratio=focus.aperture_ratio,
    )


def without_scale(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The 4x4 matrix with unit axes; a zero axis stays zero, and the native side names the camera."""
    result = matrix.astype(np.float64, order="C")
    lengths = np.linalg.norm(result[:3, :3], axis=0)
    result[:3, :3] /= np.where(lengths > 0.0, lengths, 1.0)
    return result
