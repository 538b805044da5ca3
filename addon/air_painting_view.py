# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D view shows while the air is painted: the plane in its box, the brush, and what is painted so far."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import bpy
from bpy.types import SpaceView3D
from mathutils import Matrix, Vector

from .air_painting import DIAL_PX, AirPainting, active_painting
from .air_plane import axes_of, normal_of
from .painted_air import content_key, read_volume, world_from_unit

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.types import Context, Object

    Rgba = tuple[float, float, float, float]

#: A texel of the picture of the paint covers so many pixels: it is soft, and follows the view at once.
_TEXEL_PX = 6
_MOST_TEXELS = 200
_CORNERS = 64
_BRUSH_COLOURS = {"": (1.0, 1.0, 1.0), "ERASE": (1.0, 0.45, 0.4), "SMOOTH": (0.5, 0.8, 1.0)}

_texture: Any = None
_texture_of: tuple[object, ...] = ()


def _draw_in_space() -> None:
    """The plane behind what stands before it, the brush before all."""
    import gpu

    context, painting = bpy.context, active_painting()
    if painting is None or not _is_drawn_here(painting, context):
        return
    view, plane = context.region.data, painting.plane
    if painting.box_in(context) is None or plane is None or not plane.keep_in(view):
        return
    gpu.state.blend_set("ALPHA")
    if context.space_data.shading.type != "RENDERED":  # which leaves no depths to compare with
        gpu.state.depth_test_set("LESS_EQUAL")
    _draw_lines([end for line in plane.grid(view) for end in line], (1.0, 1.0, 1.0, 0.12), "LINES")
    gpu.state.depth_test_set("NONE")
    rim = plane.outline(view)
    _draw_wide_line([*rim, *rim[:1]], (1.0, 0.75, 0.3, 0.8), 1.5)
    brush = context.scene.tyndall.air_brush
    place = painting.place_under(context.region, painting.centre_px)
    if place is not None:
        across, up, normal = axes_of(view)
        colour = _colour(painting, context)
        for one, other, alpha in (
            (across, up, 0.9),
            (across, normal * brush.depth, 0.35),
            (up, normal * brush.depth, 0.35),
        ):
            ring = _ring(place, one * brush.radius_m, other * brush.radius_m)
            _draw_wide_line(ring, (*colour, alpha), 1.0)
    gpu.state.blend_set("NONE")


def _draw_on_screen() -> None:
    import gpu

    context, painting = bpy.context, active_painting()
    if painting is None or not _is_drawn_here(painting, context):
        return
    box = painting.box_in(context)
    if box is None or painting.plane is None or not painting.plane.keep_in(context.region.data):
        return
    brush, region = context.scene.tyndall.air_brush, context.region
    if brush.shows_paint:
        _draw_paint(painting, context, box)
    gpu.state.blend_set("ALPHA")
    colour = _colour(painting, context)
    dial = painting.dial
    centre_px = painting.centre_px
    if dial is not None and dial.name in {"opacity", "hardness"}:
        value = getattr(brush, dial.name)
        _draw_disc(centre_px, DIAL_PX * value, (*colour, 0.3))
        _draw_circle(centre_px, DIAL_PX, (*colour, 0.9), 1.5)
    else:
        radius_px = painting.radius_px(brush, region)
        _draw_circle(centre_px, radius_px, (0.0, 0.0, 0.0, 0.5), 3.0)
        _draw_circle(centre_px, radius_px, (*colour, 0.9), 1.5)
        if 0.0 < brush.hardness < 1.0:
            _draw_circle(centre_px, radius_px * brush.hardness, (*colour, 0.35), 1.0)
    gpu.state.blend_set("NONE")


def _is_drawn_here(painting: AirPainting, context: Context) -> bool:
    found = painting.region_in(context)
    return found is not None and context.region == found[1]


def _colour(painting: AirPainting, context: Context) -> tuple[float, float, float]:
    mode = painting.mode or context.scene.tyndall.air_brush.mode
    return _BRUSH_COLOURS.get(mode, _BRUSH_COLOURS[""])


def _draw_paint(painting: AirPainting, context: Context, box: Object) -> None:
    """Over all of the region, drawn again only where something has changed."""
    global _texture, _texture_of
    import gpu
    from gpu_extras.presets import draw_texture_2d

    region = context.region
    shown = (
        context.scene.tyndall.air_brush.volume,
        content_key(box),
        painting.stroke_count,
        tuple(map(tuple, region.data.perspective_matrix)),
        tuple(painting.plane.point),
        world_from_unit(box),
        (region.width, region.height),
    )
    if shown != _texture_of:
        _texture, _texture_of = _picture_texture(painting, context, box), shown
    if _texture is not None:
        gpu.state.blend_set("ALPHA_PREMULT")
        draw_texture_2d(_texture, (0, 0), region.width, region.height)


def _picture_texture(painting: AirPainting, context: Context, box: Object) -> Any:  # noqa: ANN401  gpu has no types
    """None: nothing is painted."""
    import gpu
    import numpy as np

    from tyndall.air_pictures import picture

    region, view = context.region, context.region.data
    name = context.scene.tyndall.air_brush.volume.lower()
    is_stroked = painting.stroke is not None and painting.stroke.name == name
    values = painting.stroke.values if is_stroked else read_volume(box, name)
    if values is None:
        return None
    box_matrix = Matrix(world_from_unit(box))
    unit_from_clip = np.linalg.inv(np.array(view.perspective_matrix, np.float64) @ np.array(box_matrix, np.float64))
    normal = normal_of(view)
    plane = Vector((*normal, -normal.dot(painting.plane.point))) @ box_matrix
    texel_px = max(_TEXEL_PX, region.width / _MOST_TEXELS, region.height / _MOST_TEXELS)
    size = max(1, round(region.width / texel_px)), max(1, round(region.height / texel_px))
    rgba = picture(values, name, unit_from_clip, np.array(plane), size)
    return gpu.types.GPUTexture(size, format="RGBA16F", data=gpu.types.Buffer("FLOAT", rgba.size, rgba.ravel()))


def _ring(centre: Vector, across: Vector, up: Vector) -> list[Vector]:
    angles_rad = (2.0 * math.pi * corner / _CORNERS for corner in range(_CORNERS + 1))
    return [centre + across * math.cos(angle) + up * math.sin(angle) for angle in angles_rad]


def _circle(centre_px: tuple[float, float], radius_px: float) -> list[Vector]:
    return _ring(Vector((*centre_px, 0.0)), Vector((radius_px, 0.0, 0.0)), Vector((0.0, radius_px, 0.0)))


def _draw_circle(centre_px: tuple[float, float], radius_px: float, colour: Rgba, width_px: float) -> None:
    _draw_wide_line(_circle(centre_px, radius_px), colour, width_px)


def _draw_disc(centre_px: tuple[float, float], radius_px: float, colour: Rgba) -> None:
    centre = Vector((*centre_px, 0.0))
    rim = pairwise(_circle(centre_px, radius_px))
    _draw_lines([corner for one, two in rim for corner in (centre, one, two)], colour, "TRIS")


def _draw_lines(points: Iterable[Vector], colour: Rgba, kind: str) -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", colour)
    batch_for_shader(shader, kind, {"pos": [tuple(point) for point in points]}).draw(shader)


def _draw_wide_line(points: Iterable[Vector], colour: Rgba, width_px: float) -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width_px * bpy.context.preferences.system.ui_scale)
    shader.uniform_float("color", colour)
    batch_for_shader(shader, "LINE_STRIP", {"pos": [tuple(point) for point in points]}).draw(shader)


_handles: list[Any] = []


def register() -> None:
    for draw, stage in ((_draw_in_space, "POST_VIEW"), (_draw_on_screen, "POST_PIXEL")):
        _handles.append(SpaceView3D.draw_handler_add(draw, (), "WINDOW", stage))


def unregister() -> None:
    global _texture, _texture_of
    while _handles:
        SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    _texture, _texture_of = None, ()
