# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading of a 3D viewport: what the engine's ``view_update`` and ``view_draw`` hand on.

Only this thread touches Blender. It reads changes of the scene in slices, hands them to a worker, and draws the
worker's latest picture; a timer asks for a redraw whenever there is one. The engine object dies when its area changes,
so nothing but a weak reference points to it.
"""

from __future__ import annotations

import atexit
import weakref
from dataclasses import replace
from typing import TYPE_CHECKING

import bpy
import numpy as np
from bpy.types import Context, Depsgraph, RenderEngine, SpaceView3D

from tyndall.scene_description import CameraKind

from ..frame_size import frame_size_px
from ..sync.cameras import read_camera
from ..sync.heterogeneity import read_heterogeneity
from ..sync.images import ImageReader
from ..sync.reports import Reports
from ..sync.scene import SceneReader
from ..sync.transfer_functions import read_transfer_functions
from ..viewport_passes import PLANE_OF
from .data_passes import view_data_config
from .error_texts import text_of
from .passes import exposed, film_exposure
from .reading_slices import ReadingSlices, SliceOver
from .sessions import viewport_session
from .settings import render_config
from .viewport_camera import (
    camera_frame_px,
    camera_of_view,
    frame_of_view,
    perspective_clip_m,
    window_beyond_frame,
)
from .viewport_hud import draw_hud, hud_lines
from .viewport_pictures import planes_for
from .viewport_worker import Picture, View, ViewportWorker

if TYPE_CHECKING:
    from gpu.types import GPUTexture

    from tyndall.heterogeneity import Heterogeneity
    from tyndall.scene_description import Camera
    from tyndall.transfer_functions import WeightedFunction

#: Between two looks for a new picture.
POLL_S = 0.02
#: A viewport takes no more of them: its first task is to follow.
LIGHT_SAMPLES, WORLD_SAMPLES = 8, 16


class Viewport:
    """What one engine object of one 3D viewport needs. Call ``close`` before it is dropped."""

    def __init__(self, engine: RenderEngine) -> None:
        self.engine = weakref.ref(engine)
        self.worker = ViewportWorker(viewport_session())
        self._reader = SceneReader()
        self._function_images = ImageReader()
        self._functions: tuple[WeightedFunction, ...] = ()
        self._heterogeneity: Heterogeneity | None = None
        self._is_scene_outdated = True
        self._unreadable = ""  #: Why the scene, as it is, cannot be read.
        self.status = ""  #: What the artist is told.
        self._slices = ReadingSlices(lambda: self._reader.read_count)
        self._region = 0  # where it was drawn last, by address
        self._view: View | None = None
        self._drawn: Picture | None = None
        self._texture: GPUTexture | None = None
        self._exposure = 1.0  #: That it was drawn with.

    def update(self, depsgraph: Depsgraph) -> None:
        """Note that the scene has changed; it is read when the viewport is drawn."""
        self._reader.note_updates(depsgraph)
        self._is_scene_outdated = True
        self._unreadable = ""

    def draw(self, engine: RenderEngine, context: Context, depsgraph: Depsgraph) -> None:
        """Hand on what has changed, and draw what there is: also where the scene or the view is refused."""
        error = self._unreadable
        if not error:
            try:
                self._follow(engine, context, depsgraph)
            except Exception as exception:  # noqa: BLE001  Blender would print it, at each redraw, and show nothing
                error = text_of(exception)
        self._region = context.region.as_pointer()
        self._draw_picture(engine, context)
        self.status = error or self.worker.status
        engine.update_stats("Tyndall", self.status)

    def draw_hud(self, context: Context) -> None:
        """What the picture took, if it is drawn here."""
        if context.region.as_pointer() == self._region and self.worker.work is not None:
            draw_hud(context, hud_lines(self.worker.work, self.status))

    def close(self) -> None:
        self.worker.close()
        self._texture = None

    def _follow(self, engine: RenderEngine, context: Context, depsgraph: Depsgraph) -> None:
        if self._is_scene_outdated:
            self._functions = read_transfer_functions(depsgraph.scene_eval, depsgraph, self._function_images, Reports())
            self._heterogeneity = read_heterogeneity(depsgraph, Reports(), is_viewport=True)
        view = _view_of(context, depsgraph, self._functions, self._heterogeneity)
        if self._is_scene_outdated:
            self._read_scene(engine, view, context.space_data, depsgraph)
        elif not view.is_like(self._view):
            self.worker.show(view)
        self._view = view

    def _read_scene(self, engine: RenderEngine, view: View, space: SpaceView3D, depsgraph: Depsgraph) -> None:
        self._slices.begin()
        try:
            description = self._reader.read(depsgraph, Reports(), self._slices.poll, is_live=True, viewport=space)
        except SliceOver:  # what was read stays
            engine.tag_redraw()
        except Exception as error:  # such as no room for textures: not read again before it has changed
            self._unreadable = text_of(error)
            raise
        else:
            self._is_scene_outdated = False
            self.worker.show(view, description, self._slices.end())

    def _draw_picture(self, engine: RenderEngine, context: Context) -> None:
        import gpu  # there is none without a window
        from gpu_extras.presets import draw_texture_2d

        picture = self.worker.picture
        if picture is None:
            return
        exposure = film_exposure(context.scene) if picture.is_light else 1.0
        if picture is not self._drawn or exposure != self._exposure:
            height, width = picture.rgba.shape[:2]
            rgba = np.ascontiguousarray(exposed(picture.rgba, exposure))
            pixels = gpu.types.Buffer("FLOAT", width * height * 4, rgba.reshape(-1))
            self._texture = gpu.types.GPUTexture((width, height), format="RGBA32F", data=pixels)
            self._drawn, self._exposure = picture, exposure
        left, bottom, right, top = picture.bounds
        region = context.region
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(context.scene)
        draw_texture_2d(
            self._texture,
            (left * region.width, bottom * region.height),
            (right - left) * region.width,
            (top - bottom) * region.height,
        )
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


open_viewports: dict[int, Viewport] = {}  # by identity of the engine object


def view_update(engine: RenderEngine, _context: Context, depsgraph: Depsgraph) -> None:
    """What ``RenderEngine.view_update`` does."""
    _viewport_of(engine).update(depsgraph)
    engine.tag_redraw()  # Blender itself does not redraw for settings that add-ons keep, as Cycles does a lens's in 3.4


def view_draw(engine: RenderEngine, context: Context, depsgraph: Depsgraph) -> None:
    """What ``RenderEngine.view_draw`` does."""
    _viewport_of(engine).draw(engine, context, depsgraph)


def _draw_huds() -> None:
    context = bpy.context
    if context.space_data.shading.type == "RENDERED" and context.scene.tyndall.shows_viewport_work:
        for viewport in open_viewports.values():
            viewport.draw_hud(context)


_handles: list[object] = []


def register() -> None:
    """Have viewports stopped before Blender ends."""
    _handles.append(SpaceView3D.draw_handler_add(_draw_huds, (), "WINDOW", "POST_PIXEL"))
    atexit.register(_close_all)  # a thread in native code must not outlive the interpreter


def unregister() -> None:
    SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    atexit.unregister(_close_all)
    _close_all()


def _close_all() -> None:
    while open_viewports:
        open_viewports.popitem()[1].close()


def _viewport_of(engine: RenderEngine) -> Viewport:
    viewport = open_viewports.get(id(engine))
    if viewport is not None and viewport.engine() is not engine:  # a dead engine's identity, used again
        open_viewports.pop(id(engine)).close()
        viewport = None
    if viewport is None:
        viewport = open_viewports[id(engine)] = Viewport(engine)
        if not bpy.app.timers.is_registered(_tend):
            # Persistent: when another file is opened, this is what closes the viewports of the old one.
            bpy.app.timers.register(_tend, first_interval=POLL_S, persistent=True)
    return viewport


def _tend() -> float | None:
    """Redraw where there is something new, and close what lost its engine; ends itself with the last viewport."""
    for identity, viewport in list(open_viewports.items()):
        engine = viewport.engine()
        if engine is None:
            del open_viewports[identity]
            viewport.close()
        elif viewport.worker.poll():
            engine.tag_redraw()
    return POLL_S if open_viewports else None


def _camera_of(context: Context, depsgraph: Depsgraph, size_px: tuple[int, int]) -> Camera:
    """What Blender's own drawing looks through; and in a camera's view its lens, and its panorama."""
    space, region = context.space_data, context.region_data
    matrices = np.array(region.window_matrix), np.array(region.view_matrix)
    camera = camera_of_view(*matrices, size_px, perspective_clip_m(space, region))
    thing = space.camera if region.view_perspective == "CAMERA" else None
    if thing is None or thing.type != "CAMERA" or not (thing.data.type == "PANO" or thing.data.dof.use_dof):
        return camera
    scene = depsgraph.scene_eval
    seen = read_camera(thing.evaluated_get(depsgraph), scene.render, frame_size_px(scene), Reports())
    if seen.kind != CameraKind.PANORAMIC:
        return replace(camera, lens=seen.lens)
    window = window_beyond_frame(seen.window, camera_frame_px(context, size_px), size_px)
    return replace(seen, window=window, size_px=size_px)


def _view_of(
    context: Context,
    depsgraph: Depsgraph,
    functions: tuple[WeightedFunction, ...],
    heterogeneity: Heterogeneity | None,
) -> View:
    scene = depsgraph.scene_eval
    frame = frame_of_view(context)
    config = render_config(scene, depsgraph.view_layer_eval, frame, functions, heterogeneity)
    tyndall = scene.tyndall
    plane = PLANE_OF[context.space_data.shading.tyndall.render_pass]
    return View(
        camera=_camera_of(context, depsgraph, frame.size_px),
        config=replace(
            config,
            pixel_samples=tyndall.viewport_samples,
            passes=planes_for(plane),
            data=view_data_config(scene.world if plane == "Mist" else None),
            keeps_light_groups=False,
            shafts=replace(
                config.shafts,
                method=tyndall.shafts.viewport_method,
                light_samples=min(config.shafts.light_samples, LIGHT_SAMPLES),
                world_samples=min(config.shafts.world_samples, WORLD_SAMPLES),
            ),
        ),
        plane=plane,
    )
