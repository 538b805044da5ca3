# SPDX-License-Identifier: GPL-3.0-or-later
"""What 3D views show of voxel boxes: points or blocks of a coarse level, as renders of Tyndall draw the voxels."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import SpaceView3D

from .panels.base import ENGINE
from .voxel_boxes import file_of, is_voxel_box
from .voxel_reading import read

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from bpy.types import Context, Object
    from numpy.typing import NDArray

    from tyndall import Progress
    from tyndall.voxel_dag import VoxelDag

#: Of a box: 2 million triangles at most, most of which lie between blocks and are left out.
MOST_CUBES = 150_000
_POINT_PX = 3.0
#: Of faces by the way they look, as if light came from above: down x, up x, down y and so on.
_SHADES = (0.55, 0.75, 0.5, 0.65, 0.35, 0.9)
_POINT_SHADE = 0.8

#: Previews whose geometry stays on the GPU.
_MOST_ON_GPU = 24

#: By the preview's identity, the preview, which that is of while it is here, and its geometry on the GPU.
_batches: OrderedDict[int, tuple[Preview, list[Any]]] = OrderedDict()
#: Names of the boxes of the file; None: to be looked for.
_boxes: list[str] | None = None


class Preview:
    """In the space of its box."""

    def __init__(self, dag: VoxelDag, level: int, style: str, progress: Progress) -> None:
        import numpy as np

        from tyndall.voxel_dag import exposed_cubes, exposed_faces

        cubes, self.level = dag.coarse_cubes(level, MOST_CUBES, progress)
        lower_m, upper_m = dag.bounds_m
        size_m = (upper_m - lower_m) / 2**self.level
        self.kind = style
        owners = exposed_cubes(cubes) if style == "BLOCKS" else [np.arange(len(cubes))]
        shown = exposed_faces(cubes, owners) if style == "BLOCKS" else [cubes + 0.5]
        #: Corners of quads by the way they look, (m, 4, 3) each; or points, (m, 3), at once.
        self.parts_m: list[NDArray[np.float32]] = [(lower_m + part * size_m).astype("float32") for part in shown]
        #: Of each quad or point, (m, 3), as sRGB encodes it: the mean of the voxels there. None: they have no colours.
        self.colours: list[NDArray[np.uint8]] | None = None
        if dag.has_colors and len(cubes):
            doublings = dag.resolution.bit_length() - 1 - self.level
            of_cubes = dag.colors_at(cubes << np.uint32(doublings), self.level, progress)
            self.colours = [of_cubes[owned] for owned in owners]


def preview_of(thing: Object) -> Preview | Exception | None:
    """Of a voxel box; None: it is being made."""
    settings = thing.tyndall_voxels
    level, style = settings.preview_level, settings.preview
    found: Preview | Exception | None = read(
        file_of(thing), f"{style} {level}", lambda path, progress: _preview(path, level, style, progress)
    )
    return found


def _preview(path: Path, level: int, style: str, progress: Progress) -> Preview:
    from tyndall.voxel_dag import load_coarse

    return Preview(load_coarse(path, level, MOST_CUBES, progress), level, style, progress)


def _draw() -> None:
    context = bpy.context
    if context.space_data.shading.type == "RENDERED" and context.engine == ENGINE:
        return
    for thing in _boxes_in(context):
        found = preview_of(thing)
        if isinstance(found, Preview):
            _draw_preview(thing, found)


def _boxes_in(context: Context) -> list[Object]:
    """Those that the view shows."""
    global _boxes  # noqa: PLW0603  redraws come with every move of the mouse, and a scene may have 100,000 objects
    if _boxes is None:
        _boxes = [thing.name for thing in bpy.data.objects if is_voxel_box(thing)]
    things = (context.view_layer.objects.get(name) for name in _boxes)
    return [
        thing
        for thing in things
        if thing is not None
        and thing.tyndall_voxels.preview != "NONE"
        and thing.visible_in_viewport_get(context.space_data)
    ]


def _draw_preview(thing: Object, found: Preview) -> None:
    import gpu  # there is none without a window

    shader = gpu.shader.from_builtin("UNIFORM_COLOR" if found.colours is None else "FLAT_COLOR")
    if id(found) not in _batches:
        _batches[id(found)] = found, _new_batches(shader, found)
    _batches.move_to_end(id(found))
    while len(_batches) > _MOST_ON_GPU:
        _batches.popitem(last=False)
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)
    gpu.state.point_size_set(_POINT_PX * bpy.context.preferences.system.ui_scale)
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(thing.matrix_world)
        for batch, shade in zip(_batches[id(found)][1], _shades(found), strict=True):
            shader.bind()
            if found.colours is None:
                shader.uniform_float("color", (*(shade * part for part in thing.color[:3]), 1.0))
            batch.draw(shader)
    gpu.state.point_size_set(1.0)
    gpu.state.depth_mask_set(False)
    gpu.state.depth_test_set("NONE")


def _shades(found: Preview) -> tuple[float, ...]:
    """Of its parts."""
    return _SHADES if found.kind == "BLOCKS" else (_POINT_SHADE,)


def _new_batches(shader: Any, found: Preview) -> list[Any]:  # noqa: ANN401  gpu has no types
    from gpu_extras import batch

    batch_for_shader: Any = batch.batch_for_shader  # its stub knows no arrays

    batches = []
    for index, (part_m, shade) in enumerate(zip(found.parts_m, _shades(found), strict=True)):
        content = {"pos": part_m.reshape(-1, 3)}
        if found.colours is not None:
            content["color"] = _vertex_colours(found.colours[index], 4 if found.kind == "BLOCKS" else 1, shade)
        if found.kind == "BLOCKS":
            batches.append(batch_for_shader(shader, "TRIS", content, indices=_triangles(len(part_m))))
        else:
            batches.append(batch_for_shader(shader, "POINTS", content))
    return batches


def _vertex_colours(colours: NDArray[np.uint8], vertices_each: int, shade: float) -> NDArray[np.float32]:
    """RGBA as the view shows it, in which half the light is not half the number."""
    import numpy as np

    rgba = np.ones((len(colours), 4), np.float32)
    rgba[:, :3] = colours * np.float32(shade ** (1.0 / 2.2) / 255.0)
    return rgba.repeat(vertices_each, axis=0)


def _triangles(quad_count: int) -> NDArray[np.int32]:
    """Two for each quad."""
    import numpy as np

    first = 4 * np.arange(quad_count, dtype=np.int32)[:, None, None]
    return (first + np.array([[0, 1, 2], [0, 2, 3]], np.int32)).reshape(-1, 3)


@persistent
def _forget_boxes(*_: object) -> None:
    global _boxes  # noqa: PLW0603
    _boxes = None


_EVENTS = ("depsgraph_update_post", "undo_post", "redo_post", "load_post")
_handles: list[Any] = []


def register() -> None:
    for event in _EVENTS:
        getattr(bpy.app.handlers, event).append(_forget_boxes)
    _handles.append(SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    while _handles:
        SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    for event in _EVENTS:
        getattr(bpy.app.handlers, event).remove(_forget_boxes)
    _batches.clear()
