# SPDX-License-Identifier: GPL-3.0-or-later
"""The final render of one view layer of one frame: read Blender's scene, render it natively, deliver the passes.

Whatever happens, Blender gets a frame first and the error after it (see failures.py).
"""

from __future__ import annotations

import resource
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tyndall import Cancelled, Progress

from .. import last_render
from ..sync.cameras import read_camera
from ..sync.heterogeneity import read_heterogeneity
from ..sync.reports import Reports
from ..sync.transfer_functions import read_transfer_functions
from . import data_passes, failures, film_parts, over_engine, passes
from .native_call import NativeCall
from .sessions import kept_frame
from .settings import FrameWindow, frame_window, render_config

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Depsgraph, RenderEngine, RenderResult, Scene

    from tyndall.renderer import Film
    from tyndall.scene_description import Camera, SceneDescription

_POLL_S = 0.05  #: Between two looks at Esc while Blender's scene is read.


def render(engine: RenderEngine, depsgraph: Depsgraph) -> None:
    """What ``RenderEngine.render`` does."""
    failures.clear()
    layer_name = depsgraph.view_layer_eval.name
    # The engine knows the frame's size: a scene that a compositor reads is given that of another one.
    settings = over_engine.master_of(depsgraph) or depsgraph.scene_eval
    window = frame_window(settings.render, (engine.resolution_x, engine.resolution_y))
    result = engine.begin_result(0, 0, *window.region_size_px, layer=layer_name, view=engine.active_view_get())
    error: str | None = None
    is_whole = False
    try:
        _Frame(engine, depsgraph, settings, window, result).render()
        is_whole = True
    except Cancelled:
        pass
    except KeyboardInterrupt:  # Ctrl-C in a script: the main thread is the one that watches
        error = failures.INTERRUPTED
    except BaseException as exception:  # noqa: BLE001  whatever it is, the frame is delivered, and the caller told
        error = _message(exception)
    engine.end_result(result, cancel=not is_whole)  # what is cancelled is not saved: no empty picture on disk
    if error is not None:
        failures.fail(engine, error)
        if settings != depsgraph.scene_eval:  # of that, Blender tells nobody
            last_render.record(settings.name, {"reports": [error]})


def is_esc_pressed(engine: RenderEngine) -> bool:
    """Blender's own question, which tests answer in its place."""
    return bool(engine.test_break())


def _message(exception: BaseException) -> str:
    text = str(exception)
    return f"Tyndall: {text}" if text else f"Tyndall: {type(exception).__name__}"


@dataclass(eq=False)
class _Frame:
    engine: RenderEngine
    depsgraph: Depsgraph
    settings: Scene  #: Evaluated; another one than the depsgraph's where that renders for it.
    window: FrameWindow
    result: RenderResult

    def render(self) -> None:
        scene, view_layer = self.settings, self.depsgraph.view_layer_eval
        is_over_engine = scene != self.depsgraph.scene_eval
        if is_over_engine and scene.render.engine == self.engine.bl_idname:
            passes.write(self.result.layers[0], over_engine.nothing(*self.window.region_size_px))
            return  # that scene has its light shafts already
        if (given := film_parts.given_for(scene.name)) is not None and not is_over_engine:
            passes.write(self.result.layers[0], given.planes(view_layer.name, self.engine.active_view_get()))
            self._stamp(given.stamps.get(view_layer.name, {}))
            last_render.record(scene.name, given.statistics)
            return
        taken = None if is_over_engine else film_parts.taken_of(scene.name)
        if taken is not None and taken.layer_name != view_layer.name:
            return  # another job's
        # Of a still, nothing is asked for twice.
        keeps_maps = self.engine.is_animation or scene.render.use_persistent_data
        kept = kept_frame(scene.name, view_layer.name, keeps_maps=keeps_maps)
        started = time.perf_counter()
        self.engine.update_stats("", "Tyndall: reading the scene")
        reports = Reports()
        camera = self._camera(reports)
        functions = read_transfer_functions(scene, self.depsgraph, kept.function_images, reports)
        heterogeneity = read_heterogeneity(self.depsgraph, reports, scene)
        description = kept.reader.read(self.depsgraph, reports, self._poll(), is_lit=not is_over_engine)
        description = self._with_report_of_lens(description, camera, reports)
        read_s = time.perf_counter() - started
        config = render_config(scene, view_layer, self.window, functions, heterogeneity)
        config = replace(config, data=data_passes.data_config(self.depsgraph, view_layer))
        stamps = data_passes.stamps(self.depsgraph, view_layer, description)
        if is_over_engine:
            config = over_engine.air_config(config)
        if taken is not None:
            region_px = taken.tile.region_px(self.window)
            config = replace(config, region_px=region_px, is_tile=not taken.tile.is_all)

        def work(progress: Progress, show: Callable[[Film], None]) -> Film:
            kept.session.update(description, progress)
            return kept.session.render(camera, config, progress, show if taken is None else None)

        film = NativeCall(work).watch(is_cancelled=lambda: is_esc_pressed(self.engine), tick=self._tick)
        if is_over_engine:
            film = over_engine.marked_as_rendered(film)
        if taken is not None:
            taken.films[self.engine.active_view_get()] = film.planes
            taken.stamps.update(stamps)
        else:
            self._show(film)
            self._stamp(stamps)
        last_render.record(scene.name, _statistics(film, description, read_s))
        for line in description.reports:
            self.engine.report({"WARNING"}, f"Tyndall: {line}")

    def _camera(self, reports: Reports) -> Camera:
        thing = self.depsgraph.scene_eval.camera
        if thing is None:
            raise ValueError("the scene has no camera")
        return read_camera(
            thing,
            self.settings.render,
            self.window.size_px,
            reports,
            world_from_camera=np.array(self.engine.camera_model_matrix(thing)),
            shift_x=self.engine.camera_shift_x(thing),
        )

    def _with_report_of_lens(self, description: SceneDescription, camera: Camera, reports: Reports) -> SceneDescription:
        if camera.lens is None or not description.media:
            return description
        name = self.depsgraph.scene_eval.camera.name
        reports.add(f'Camera "{name}"', "its depth of field blurs surfaces; light shafts stay sharp")
        return replace(description, reports=reports.lines())

    def _poll(self) -> Callable[[], None]:
        last = time.monotonic()

        def poll() -> None:
            nonlocal last
            if time.monotonic() - last >= _POLL_S:
                last = time.monotonic()
                if is_esc_pressed(self.engine):
                    raise Cancelled

        return poll

    def _tick(self, progress: Progress, film: Film | None) -> None:
        self.engine.update_progress(progress.fraction)
        peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        self.engine.update_memory_stats(memory_used=peak_mib, memory_peak=peak_mib)
        self.engine.update_stats("", f"Tyndall: {progress.message}{_time_left(progress)}")
        if film is not None:
            self._show(film)
            self.engine.update_result(self.result)

    def _show(self, film: Film) -> None:
        passes.write(self.result.layers[0], film.planes)

    def _stamp(self, fields: dict[str, str]) -> None:
        """The compositor and files have them with the picture."""
        for name, text in fields.items():
            self.engine.get_result().stamp_data_add_field(name, text)


def _time_left(progress: Progress) -> str:
    remaining_s = progress.remaining_s
    return "" if remaining_s < 1.0 else f", {int(remaining_s) // 60:02d}:{int(remaining_s) % 60:02d} left"


def _statistics(film: Film, description: SceneDescription, read_s: float) -> dict[str, object]:
    statistics = dict(film.statistics)
    statistics["stages"] = [{"name": "Blender's scene read", "seconds": read_s}, *statistics.get("stages", ())]
    known = list(statistics.get("reports", ()))
    statistics["reports"] = known + [line for line in description.reports if line not in known]
    return statistics
