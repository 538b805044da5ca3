# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's cameras with sensor fit, shift and pixel aspect resolved into a window, and their lens."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall.scene_description import Camera, CameraKind, Lens

from ..panoramas import EQUIRECTANGULAR, panorama_settings

if TYPE_CHECKING:
    import bpy
    from numpy.typing import NDArray

    from .reports import Reports

_LARGEST_COORDINATE_M = 1e18  #: Beyond it, squares do not fit into single precision.


def read_camera(
    thing: bpy.types.Object,
    render: bpy.types.RenderSettings,
    size_px: tuple[int, int],
    reports: Reports,
    *,
    world_from_camera: NDArray[np.float64] | None = None,
    shift_x: float | None = None,
) -> Camera:
    """The evaluated camera object of a frame of ``size_px``. Matrix and shift are those of a stereo view, if given."""
    if thing.type != "CAMERA":
        raise ValueError(f'"{thing.name}" is the scene\'s camera, but it is of type {thing.type.lower()}')
    placed = np.array(thing.matrix_world if world_from_camera is None else world_from_camera, dtype=np.float64)
    if not (np.abs(placed) < _LARGEST_COORDINATE_M).all() or np.linalg.det(placed[:3, :3]) == 0.0:
        raise ValueError(f'Camera "{thing.name}": its position is not finite, or its scale is 0')
    data, culprit = thing.data, f'Camera "{thing.name}"'
    panorama = _panorama(data, culprit, reports) if data.type == "PANO" else None
    if panorama is not None:
        kind, window = CameraKind.EQUIRECTANGULAR, panorama
    else:
        kind = CameraKind.ORTHOGRAPHIC if data.type == "ORTHO" else CameraKind.PERSPECTIVE
        window = _window(data, render, size_px, data.shift_x if shift_x is None else shift_x)
    return Camera(
        kind=kind,
        world_from_camera=without_scale(placed),
        window=window,
        clip_m=(data.clip_start, data.clip_end),
        size_px=size_px,
        lens=_lens(thing, placed, culprit, reports) if data.dof.use_dof else None,
    )


def _window(
    data: bpy.types.Camera, render: bpy.types.RenderSettings, size_px: tuple[int, int], shift_x: float
) -> tuple[float, float, float, float]:
    """Of a perspective camera, one metre ahead, or of an orthographic one, in metres."""
    aspect = render.pixel_aspect_y / render.pixel_aspect_x
    is_wide = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and size_px[0] >= aspect * size_px[1])
    # Lengths below are in pixels along x; `extent_px` is the side of the frame that the sensor spans.
    extent_px = size_px[0] if is_wide else aspect * size_px[1]
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    metres_per_px = (data.ortho_scale if data.type == "ORTHO" else sensor / data.lens) / extent_px
    centre_x, centre_y = shift_x * extent_px, data.shift_y * extent_px
    half_width, half_height = size_px[0] / 2, aspect * size_px[1] / 2
    return (
        (centre_x - half_width) * metres_per_px,
        (centre_x + half_width) * metres_per_px,
        (centre_y - half_height) * metres_per_px,
        (centre_y + half_height) * metres_per_px,
    )


def _panorama(data: bpy.types.Camera, culprit: str, reports: Reports) -> tuple[float, float, float, float] | None:
    """Longitudes and latitudes; None, and a report: it is drawn in perspective."""
    settings = panorama_settings(data)
    if settings is None:
        reports.add(culprit, "its panorama is kept by the Cycles add-on, which is off: drawn in perspective")
        return None
    if settings.panorama_type != EQUIRECTANGULAR:
        kind = settings.panorama_type.replace("_", " ").lower()
        reports.add(culprit, f"a panorama of the kind {kind}, not equirectangular: drawn in perspective")
        return None
    window = settings.longitude_min, settings.longitude_max, settings.latitude_min, settings.latitude_max
    if window[0] == window[1] or window[2] == window[3]:
        raise ValueError(f"{culprit}: its panorama's least and largest latitude or longitude are equal")
    return window


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
