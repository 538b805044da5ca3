# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's cameras with sensor fit, shift and pixel aspect resolved into a window."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall.scene_description import Camera, CameraKind

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
    data = thing.data
    if data.type == "PANO":
        reports.add(f'Camera "{thing.name}"', "panoramic; drawn in perspective with its focal length")
    if data.dof.use_dof:
        reports.add(f'Camera "{thing.name}"', "depth of field is not drawn: everything is in focus")
    aspect = render.pixel_aspect_y / render.pixel_aspect_x
    is_orthographic = data.type == "ORTHO"
    is_wide = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and size_px[0] >= aspect * size_px[1])
    # Lengths below are in pixels along x; `extent_px` is the side of the frame that the sensor spans.
    extent_px = size_px[0] if is_wide else aspect * size_px[1]
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    metres_per_px = (data.ortho_scale if is_orthographic else sensor / data.lens) / extent_px
    centre_x = (data.shift_x if shift_x is None else shift_x) * extent_px
    centre_y = data.shift_y * extent_px
    half_width, half_height = size_px[0] / 2, aspect * size_px[1] / 2
    return Camera(
        kind=CameraKind.ORTHOGRAPHIC if is_orthographic else CameraKind.PERSPECTIVE,
        world_from_camera=without_scale(placed),
        window=(
            (centre_x - half_width) * metres_per_px,
            (centre_x + half_width) * metres_per_px,
            (centre_y - half_height) * metres_per_px,
            (centre_y + half_height) * metres_per_px,
        ),
        clip_m=(data.clip_start, data.clip_end),
        size_px=size_px,
    )


def without_scale(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The 4x4 matrix with unit axes; a zero axis stays zero, and the native side names the camera."""
    result = matrix.astype(np.float64, order="C")
    lengths = np.linalg.norm(result[:3, :3], axis=0)
    result[:3, :3] /= np.where(lengths > 0.0, lengths, 1.0)
    return result
