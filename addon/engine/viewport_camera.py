# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D viewport looks through, as a camera: free and camera views, zoom, offset and border included."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tyndall.scene_description import Camera, CameraKind

from .settings import FrameWindow

if TYPE_CHECKING:
    import bpy
    from numpy.typing import NDArray


def camera_of_view(
    clip_from_camera: NDArray[np.float64],
    camera_from_world: NDArray[np.float64],
    size_px: tuple[int, int],
    clip_m: tuple[float, float],
) -> Camera:
    """Undo an OpenGL projection matrix: ``(4, 4)``, ``[row, column]``, clip space from -1 to 1.

    ``clip_m``: near and far of a perspective, whose far plane hides in the last digits of Blender's matrix, or beyond.
    """
    projection, world_from_camera = clip_from_camera, np.linalg.inv(camera_from_world)
    is_perspective = projection[3, 3] == 0.0
    scale_x, scale_y = projection[0, 0], projection[1, 1]
    if is_perspective:
        centre_x, centre_y = projection[0, 2], projection[1, 2]
        near_m, far_m = clip_m
    else:
        centre_x, centre_y = -projection[0, 3], -projection[1, 3]
        near_m = (projection[2, 3] + 1.0) / projection[2, 2]
        far_m = (projection[2, 3] - 1.0) / projection[2, 2]
        # A free orthographic view sees what lies behind its centre, too: step back until all of it lies in front.
        world_from_camera[:3, 3] += world_from_camera[:3, 2] * -min(near_m, 0.0)
        near_m, far_m = max(near_m, 0.0), far_m - min(near_m, 0.0)
    return Camera(
        kind=CameraKind.PERSPECTIVE if is_perspective else CameraKind.ORTHOGRAPHIC,
        world_from_camera=world_from_camera,
        window=(
            (centre_x - 1.0) / scale_x,
            (centre_x + 1.0) / scale_x,
            (centre_y - 1.0) / scale_y,
            (centre_y + 1.0) / scale_y,
        ),
        clip_m=(float(near_m), float(far_m)),
        size_px=size_px,
    )


def perspective_clip_m(space: bpy.types.SpaceView3D, view: bpy.types.RegionView3D) -> tuple[float, float]:
    """Near and far of a viewport that shows a perspective: of the camera, or of the view itself."""
    thing = space.camera if view.view_perspective == "CAMERA" else None
    clipped = space if thing is None or thing.type != "CAMERA" else thing.data
    return clipped.clip_start, clipped.clip_end


def frame_of_view(context: bpy.types.Context) -> FrameWindow:
    """The region in pixels, and what of it renders: the camera's border in a camera view, else the view's own."""
    size_px = context.region.width, context.region.height
    space, view, render = context.space_data, context.region_data, context.scene.render
    left, bottom, right, top = 0.0, 0.0, *map(float, size_px)
    if view.view_perspective == "CAMERA":
        if render.use_border and space.camera:
            left, bottom, right, top = camera_frame_px(context, size_px)
            width, height = right - left, top - bottom
            left, right = left + width * render.border_min_x, left + width * render.border_max_x
            bottom, top = bottom + height * render.border_min_y, bottom + height * render.border_max_y
    elif space.use_render_border:
        left, right = size_px[0] * space.render_border_min_x, size_px[0] * space.render_border_max_x
        bottom, top = size_px[1] * space.render_border_min_y, size_px[1] * space.render_border_max_y
    x0, x1 = _pixels(left, right, size_px[0])
    y0, y1 = _pixels(bottom, top, size_px[1])
    return FrameWindow(size_px=size_px, region_px=(x0, y0, x1, y1))


def window_beyond_frame(
    window: tuple[float, float, float, float], frame_px: tuple[float, float, float, float], size_px: tuple[int, int]
) -> tuple[float, float, float, float]:
    """Of the region, by that of the camera's frame in it: both left, right, bottom, top; the frame left, bottom, ..."""
    left, bottom, right, top = frame_px
    across, up = (window[1] - window[0]) / (right - left), (window[3] - window[2]) / (top - bottom)
    return (
        window[0] - left * across,
        window[1] + (size_px[0] - right) * across,
        window[2] - bottom * up,
        window[3] + (size_px[1] - top) * up,
    )


def _pixels(low: float, high: float, size_px: int) -> tuple[int, int]:
    """Whole pixels that cover a range, inside the region and never empty."""
    first = min(max(math.floor(low), 0), size_px - 1)
    return first, max(min(math.ceil(high), size_px), first + 1)


def camera_frame_px(context: bpy.types.Context, size_px: tuple[int, int]) -> tuple[float, float, float, float]:
    """Left, bottom, right and top of the camera's frame in the region; partly outside when zoomed in."""
    camera = context.space_data.camera
    world_from_camera = camera.matrix_world.normalized()
    corners_in_clip = [
        context.region_data.perspective_matrix @ (world_from_camera @ corner).to_4d()
        for corner in camera.data.view_frame(scene=context.scene)
    ]
    x_px = [(corner.x / corner.w + 1.0) / 2.0 * size_px[0] for corner in corners_in_clip]
    y_px = [(corner.y / corner.w + 1.0) / 2.0 * size_px[1] for corner in corners_in_clip]
    return min(x_px), min(y_px), max(x_px), max(y_px)
