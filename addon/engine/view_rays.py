# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays of what an artist looks at, a 3D viewport or the render in an Image Editor; and the surfaces that they meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from mathutils import Vector

from tyndall.scene_description import CameraKind

from ..frame_size import frame_size_px
from ..shader_nodes import is_medium_only
from ..sync.cameras import read_camera
from ..sync.reports import Reports
from .settings import frame_window
from .viewport_camera import camera_of_view, perspective_clip_m

if TYPE_CHECKING:
    from bpy.types import Area, Context, Depsgraph, Object, Region, Scene, SpaceView3D
    from mathutils import Matrix

    from tyndall.scene_description import Camera

#: A next surface begins behind the last by this share of the way to it.
_STEP = 1e-5
#: Surfaces of media that a ray passes before it is taken for lost.
_MOST_MEDIA = 64


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where an artist points at."""

    camera: Camera
    place_px: tuple[float, float]  #: Of the camera's full frame, from its left and bottom.

    def ray(self) -> tuple[Vector, Vector] | None:
        """Origin, at the near clip, and unit direction, in world space; None: beside what a panorama shows."""
        if self.camera.kind == CameraKind.PANORAMIC:
            from tyndall.native_camera import ray_through

            found = ray_through(self.camera, self.place_px)
            return None if found is None else (Vector(found[0]), Vector(found[1]))
        left, right, bottom, top = self.camera.window
        width_px, height_px = self.camera.size_px
        x = left + (right - left) * self.place_px[0] / width_px
        y = bottom + (top - bottom) * self.place_px[1] / height_px
        near_m = self.camera.clip_m[0]
        is_perspective = self.camera.kind == CameraKind.PERSPECTIVE
        origin = (x * near_m, y * near_m, -near_m) if is_perspective else (x, y, -near_m)
        towards = (x, y, -1.0) if is_perspective else (0.0, 0.0, -1.0)
        world_from_camera = self.camera.world_from_camera
        direction = Vector(world_from_camera[:3, :3] @ np.array(towards)).normalized()
        return Vector(world_from_camera[:3, :3] @ np.array(origin) + world_from_camera[:3, 3]), direction


@dataclass(frozen=True, kw_only=True)
class Hit:
    """The first surface on a ray."""

    thing: Object  #: The original.
    polygon_index: int  #: Of the evaluated mesh.
    world_from_object: Matrix  #: Of the instance that was met.
    world_point: Vector

    def instancer(self, depsgraph: Depsgraph) -> Object | None:
        """What instances the object where it was met, the original; None: it was met at its own place."""
        own = self.thing.evaluated_get(depsgraph).matrix_world
        if _are_alike(own, self.world_from_object):
            return None
        instancers = [  # all of them: Blender does not free an iteration that is left before its end
            instance.parent.original
            for instance in depsgraph.object_instances
            if instance.is_instance
            and instance.object.original == self.thing
            and _are_alike(instance.matrix_world, self.world_from_object)
        ]
        return instancers[0] if instancers else None


def _are_alike(matrix: Matrix, other: Matrix) -> bool:
    return np.allclose(np.array(matrix), np.array(other), rtol=1e-5, atol=1e-5)


def place_under(context: Context, depsgraph: Depsgraph, x_px: int, y_px: int) -> Place | None:
    """What is under the mouse, in pixels of the window; None: neither a 3D view nor the render."""
    for area in context.screen.areas:
        for region in area.regions:
            x, y = x_px - region.x, y_px - region.y
            if region.type != "WINDOW" or not (0 <= x < region.width and 0 <= y < region.height):
                continue
            if area.type == "VIEW_3D":
                return _in_viewport(area.spaces.active, region, x, y)
            if shows_render(area):
                return _in_render(region, depsgraph, x, y)
    return None


def shows_render(area: Area) -> bool:
    """Whether it is an Image Editor with the result of a render."""
    image = area.spaces.active.image if area.type == "IMAGE_EDITOR" else None
    return image is not None and image.type == "RENDER_RESULT"


def _in_viewport(space: SpaceView3D, region: Region, x: int, y: int) -> Place:
    view, size_px = region.data, (region.width, region.height)
    matrices = np.array(view.window_matrix), np.array(view.view_matrix)
    camera = camera_of_view(*matrices, size_px, perspective_clip_m(space, view))
    return Place(camera=camera, place_px=(x + 0.5, y + 0.5))


def _in_render(region: Region, depsgraph: Depsgraph, x: int, y: int) -> Place | None:
    """The picture lies over [0, 1]^2 of the editor's view, whatever its zoom."""
    view: Any = region.view2d
    across, up = view.region_to_view(x + 0.5, y + 0.5)
    if not (0.0 <= across <= 1.0 and 0.0 <= up <= 1.0):
        return None
    x0, y0, x1, y1 = picture_px(depsgraph.scene)
    return place_in_frame(depsgraph, (x0 + across * (x1 - x0), y0 + up * (y1 - y0)))


def picture_px(scene: Scene) -> tuple[int, int, int, int]:
    """The part of the frame that a render is a picture of: all, unless it is cropped to a border."""
    size_px = frame_size_px(scene)
    if scene.render.use_border and scene.render.use_crop_to_border:
        return frame_window(scene.render, size_px).region_px
    return 0, 0, *size_px


def place_in_frame(depsgraph: Depsgraph, place_px: tuple[float, float]) -> Place:
    """Of the scene's camera. Raises ValueError, which says what is wrong with it."""
    scene = depsgraph.scene_eval
    if scene.camera is None:
        raise ValueError("the scene has no camera")
    camera = read_camera(scene.camera, scene.render, frame_size_px(scene), Reports())
    return Place(camera=camera, place_px=place_px)


def marker_on_render(context: Context, world_point: tuple[float, float, float]) -> tuple[float, float] | None:
    """Pixels of an Image Editor's region where the render shows a point; None: behind the camera."""
    scene = context.scene
    if (at := share_of_frame(context, scene, Vector(world_point))) is None:
        return None
    across, up = at
    (width, height), (x0, y0, x1, y1) = frame_size_px(scene), picture_px(scene)
    in_picture = (across * width - x0) / (x1 - x0), (up * height - y0) / (y1 - y0)
    x, y = context.region.view2d.view_to_region(*in_picture, clip=False)
    return float(x), float(y)


def share_of_frame(context: Context, scene: Scene, world_point: Vector) -> tuple[float, float] | None:
    """From the frame's left and bottom; None: behind the camera, or nowhere in a panorama."""
    from bpy_extras.object_utils import world_to_camera_view

    if scene.camera.type == "CAMERA" and scene.camera.data.type == "PANO":
        camera = place_in_frame(context.evaluated_depsgraph_get(), (0.0, 0.0)).camera
        if camera.kind == CameraKind.PANORAMIC:
            from tyndall.native_camera import raster_position

            place_px = raster_position(camera, world_point)
            return None if place_px is None else (place_px[0] / camera.size_px[0], place_px[1] / camera.size_px[1])
    seen: Any = world_to_camera_view(scene, scene.camera, world_point)
    return (float(seen[0]), float(seen[1])) if seen[2] > 0.0 else None


def first_hit(depsgraph: Depsgraph, place: Place, object_name: str = "") -> Hit | None:
    """The first surface; those of media without one, as of a fog box, are passed. ``object_name``: no other's."""
    ray = place.ray()
    if ray is None:
        return None
    origin, direction = ray
    for _ in range(_MOST_MEDIA):
        is_met, point, _normal, polygon, thing, matrix = depsgraph.scene.ray_cast(depsgraph, origin, direction)
        if not is_met:
            return None
        if not is_medium_only(thing) and object_name in {"", thing.name}:
            return Hit(
                thing=thing.original, polygon_index=polygon, world_from_object=matrix.copy(), world_point=point.copy()
            )
        origin = point + direction * max(_STEP, _STEP * (point - origin).length)
    return None
