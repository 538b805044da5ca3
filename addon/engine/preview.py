# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews: what a material, a world or a light looks like, in a small scene that Blender makes for it.

The Properties editor and the icons of data and assets ask for them, in a thread of their own, beside whatever else is
rendered. So nothing of final renders is touched: neither what they keep nor what they recorded.
"""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tyndall import Cancelled, Progress
from tyndall.renderer import IndirectConfig, RenderConfig, Session, ShaftConfig

from ..sync.cameras import read_camera
from ..sync.reports import Reports
from ..sync.scene import SceneReader
from . import passes
from .error_texts import text_of
from .final import is_esc_pressed
from .native_call import NativeCall
from .settings import frame_window

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Depsgraph, RenderEngine, RenderResult

    from tyndall.renderer import Film

#: Those of an artist's scene are not there to be asked: a preview's scene has Blender's own settings. Pixels are few.
SAMPLES, NOISE_THRESHOLD = 32, 0.02
#: Metal shows the room that Blender's scene has for it, and glass bends it, as in Cycles; renders do so where the
#: artist asks for that.
MIRROR_DEPTH, REFRACTION_DEPTH = 4, 8
_SHAFTS = ShaftConfig(error_target=0.02, grid_error_target=0.05, light_samples=4, world_samples=8)


def render(engine: RenderEngine, depsgraph: Depsgraph) -> None:
    """What ``RenderEngine.render`` does in a preview: Blender gets its picture whatever happens, and then the error."""
    size_px = engine.resolution_x, engine.resolution_y
    result = engine.begin_result(0, 0, *size_px, layer=depsgraph.view_layer_eval.name, view=engine.active_view_get())
    error: str | None = None
    is_whole = False
    try:
        _render(engine, depsgraph, result, size_px)
        is_whole = True
    except Cancelled:
        pass
    except Exception as exception:  # noqa: BLE001  no picture is worth the editor that it is drawn in
        error = f"Tyndall: {text_of(exception)}"
    engine.end_result(result, cancel=not is_whole)
    if error is not None:
        tell(engine, error)


def tell(engine: RenderEngine, message: str) -> None:
    """Blender's console has it; tests ask here."""
    engine.error_set(message)


def _render(engine: RenderEngine, depsgraph: Depsgraph, result: RenderResult, size_px: tuple[int, int]) -> None:
    scene = depsgraph.scene_eval

    def poll() -> None:
        if is_esc_pressed(engine):
            raise Cancelled

    poll()
    reports = Reports()  # the material's render tells of them
    thing = scene.camera
    if thing is None:
        raise ValueError("the preview's scene has no camera")
    camera = read_camera(
        thing,
        scene.render,
        size_px,
        reports,
        world_from_camera=np.array(engine.camera_model_matrix(thing)),
        shift_x=engine.camera_shift_x(thing),
    )
    description = SceneReader().read(depsgraph, reports, poll, is_preview=True)
    config = RenderConfig(
        pixel_samples=SAMPLES,
        noise_threshold=NOISE_THRESHOLD,
        region_px=frame_window(scene.render, size_px).region_px,
        film_transparent=scene.render.film_transparent,
        passes=passes.wanted_planes(depsgraph.view_layer_eval),
        shafts=_SHAFTS,
        indirect=IndirectConfig(mirror_depth=MIRROR_DEPTH, refraction_depth=REFRACTION_DEPTH),
        thread_count=max(1, (os.cpu_count() or 1) - 1),  # one is the window's
    )
    session = Session()

    def work(progress: Progress, show: Callable[[Film], None]) -> Film:
        session.update(description, progress)
        show(session.render(camera, replace(config, pixel_samples=1), progress))  # at once, and whole
        return session.render(camera, config, progress)

    def show(_progress: Progress, film: Film | None) -> None:
        if film is not None:
            passes.write(result.layers[0], film.planes)
            engine.update_result(result)

    film = NativeCall(work).watch(is_cancelled=lambda: is_esc_pressed(engine), tick=show)
    passes.write(result.layers[0], film.planes)
