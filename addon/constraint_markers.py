# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings in 3D views, and on the render, where the active layer's constraints follow a surface."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import SpaceImageEditor, SpaceView3D

from .function_trees import edited_function
from .panels.base import ENGINE
from .surface_points import anchor_of, follow

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Context, Depsgraph

    from .properties.transfer_layers import TyndallTransferLayer

    #: Place in a region, pixels; colour; whether it is the active constraint's.
    Marker = tuple[float, float, tuple[float, float, float], bool]

_RADIUS_PX = 7.0
_CORNERS = 24

#: World positions of the constraints of a layer, by index; only kept until anything changes.
_points: dict[int, tuple[float, float, float]] = {}
_points_of: tuple[str, int] | None = None


def shown_layer(context: Context) -> TyndallTransferLayer | None:
    """The active layer of the edited function, while it is one that has markers."""
    if context.engine != ENGINE or not context.scene.tyndall.shafts.use_transfer_functions:
        return None
    tree = edited_function(context)
    if tree is None or tree.tyndall.active_layer >= len(tree.tyndall.layers):
        return None
    layer = tree.tyndall.layers[tree.tyndall.active_layer]
    return layer if layer.kind == "DIFFUSION" else None


def points_of(layer: TyndallTransferLayer, depsgraph: Depsgraph) -> dict[int, tuple[float, float, float]]:
    """World positions of those of its constraints that follow a surface, by index."""
    global _points_of  # noqa: PLW0603  a cache for redraws, which come with every move of the mouse
    owner = layer.id_data.name_full, layer.id_data.tyndall.active_layer
    if _points_of != owner:
        _points.clear()
        for index, constraint in enumerate(layer.constraints):
            thing = constraint.tracked_object
            if constraint.is_tracked and thing is not None and depsgraph.scene in thing.users_scene:
                followed = follow(anchor_of(constraint), thing.evaluated_get(depsgraph))
                if followed is not None:
                    _points[index] = followed.world_point
        _points_of = owner
    return _points


def _markers_in_view(context: Context) -> Iterator[Marker]:
    from bpy_extras.view3d_utils import location_3d_to_region_2d

    layer = shown_layer(context)
    if layer is None or not context.space_data.overlay.show_overlays:
        return
    for index, point in points_of(layer, context.view_layer.depsgraph).items():
        place = location_3d_to_region_2d(context.region, context.region_data, point)
        if place is not None:
            yield _marker(layer, index, place.x, place.y)


def _markers_on_render(context: Context) -> Iterator[Marker]:
    from .engine.view_rays import marker_on_render, shows_render

    layer, camera = shown_layer(context), context.scene.camera
    if layer is None or camera is None or camera.type != "CAMERA" or not shows_render(context.area):
        return
    for index, point in points_of(layer, context.view_layer.depsgraph).items():
        place = marker_on_render(context, point)
        if place is not None:
            yield _marker(layer, index, *place)


def _marker(layer: TyndallTransferLayer, index: int, x: float, y: float) -> Marker:
    return x, y, tuple(layer.constraints[index].colour[:3]), index == layer.active_constraint


def _draw(markers: Iterator[Marker]) -> None:
    import gpu  # there is none without a window
    from gpu_extras.batch import batch_for_shader

    filled = gpu.shader.from_builtin("UNIFORM_COLOR")
    line = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    for x, y, colour, is_active in markers:
        ring = _circle(x, y)
        fan = [corner for one, two in pairwise(ring) for corner in ((x, y, 0.0), one, two)]
        filled.uniform_float("color", (*colour, 1.0))
        batch_for_shader(filled, "TRIS", {"pos": fan}).draw(filled)
        line.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        line.uniform_float("lineWidth", 3.0 if is_active else 1.5)
        line.uniform_float("color", (1.0, 1.0, 1.0, 1.0) if is_active else (0.0, 0.0, 0.0, 0.8))
        batch_for_shader(line, "LINE_STRIP", {"pos": ring}).draw(line)
    gpu.state.blend_set("NONE")


def _draw_in_view() -> None:
    _draw(_markers_in_view(bpy.context))


def _draw_on_render() -> None:
    _draw(_markers_on_render(bpy.context))


def _circle(x: float, y: float) -> list[tuple[float, float, float]]:
    angles_rad = (2.0 * math.pi * corner / _CORNERS for corner in range(_CORNERS + 1))
    return [(x + _RADIUS_PX * math.cos(angle), y + _RADIUS_PX * math.sin(angle), 0.0) for angle in angles_rad]


@persistent
def _forget(*_: object) -> None:
    global _points_of  # noqa: PLW0603
    _points_of = None


_EVENTS = ("depsgraph_update_post", "frame_change_post", "undo_post", "redo_post", "load_post")
_drawn: list[tuple[Any, object]] = []


def register() -> None:
    for event in _EVENTS:
        getattr(bpy.app.handlers, event).append(_forget)
    for space, draw in ((SpaceView3D, _draw_in_view), (SpaceImageEditor, _draw_on_render)):
        _drawn.append((space, space.draw_handler_add(draw, (), "WINDOW", "POST_PIXEL")))


def unregister() -> None:
    while _drawn:
        space, handle = _drawn.pop()
        space.draw_handler_remove(handle, "WINDOW")
    for event in _EVENTS:
        getattr(bpy.app.handlers, event).remove(_forget)
