# SPDX-License-Identifier: GPL-3.0-or-later
"""The final render of one view layer of one frame: read Blender's scene, render it natively, deliver the passes.

Whatever happens, Blender gets a frame first and the error after it (see failures.py).
"""

from __future__ import annotations

import resource
import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from tyndall import Cancelled, Progress
from tyndall._native import return_free_memory
from tyndall.memory_estimate import picture_part, require_room
from tyndall.neighbour_frames import Neighbour, Neighbours

from .. import last_render
from ..sync.reports import Reports
from . import data_passes, failures, film_parts, over_engine, passes
from .error_texts import text_of
from .exposures import ExposedFilm, Exposure, exposures, lens_exposures, lens_step_count
from .frame_looks import LookReader
from .native_call import NativeCall
from .sessions import kept_frame
from .settings import FrameWindow, frame_window, render_config
from .shutters import frame_parts, read_shutter, report_unfollowed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from bpy.types import Depsgraph, Object, RenderEngine, RenderResult, Scene, ViewLayer

    from tyndall.renderer import Film, RenderConfig, Session
    from tyndall.scene_description import SceneDescription

    from .frame_looks import Look
    from .shutters import Shutter

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
        error = f"Tyndall: {text_of(exception)}"
    engine.end_result(result, cancel=not is_whole)  # what is cancelled is not saved: no empty picture on disk
    if error is not None:
        failures.fail(engine, error)
        if settings != depsgraph.scene_eval:  # of that, Blender tells nobody
            last_render.record(settings.name, {"reports": [error]})


def is_esc_pressed(engine: RenderEngine) -> bool:
    """Blender's own question, which tests answer in its place."""
    return bool(engine.test_break())


@dataclass(eq=False)
class _Frame:
    engine: RenderEngine
    depsgraph: Depsgraph
    settings: Scene  #: Evaluated; another one than the depsgraph's where that renders for it.
    window: FrameWindow
    result: RenderResult
    _exposed: ExposedFilm = field(default_factory=ExposedFilm)
    _mattes: data_passes.MatteNames = field(default_factory=data_passes.MatteNames)
    _started: float = field(default_factory=time.perf_counter)

    def render(self) -> None:
        scene, view_layer = self.settings, self.depsgraph.view_layer_eval
        is_over_engine = scene != self.depsgraph.scene_eval
        if is_over_engine and scene.render.engine == self.engine.bl_idname:
            passes.write(self.result.layers[0], over_engine.nothing(*self.window.region_size_px))
            return  # that scene has its light shafts already
        if (given := film_parts.given_for(scene.name)) is not None and not is_over_engine:
            self._show(given.planes(view_layer.name, self.engine.active_view_get()))
            self._stamp(given.stamps.get(view_layer.name, {}))
            last_render.record(scene.name, given.statistics)
            return
        taken = None if is_over_engine else film_parts.taken_of(scene.name)
        if taken is not None and taken.layer_name != view_layer.name:
            return  # another job's
        # Of a still, nothing is asked for twice.
        keeps_maps = self.engine.is_animation or scene.render.use_persistent_data
        shutter = read_shutter(scene, view_layer)
        follows_moves = shutter is not None
        kept = kept_frame(scene.name, view_layer.name, keeps_maps=keeps_maps, follows_moves=follows_moves)
        require_room([picture_part(self._rendered_size_px(taken), ())])
        started = time.perf_counter()
        self.engine.update_stats("", "Tyndall: reading the scene")
        reports = Reports()
        if shutter is not None:
            report_unfollowed(scene, self.depsgraph, view_layer, reports)
        reader = LookReader(
            engine=self.engine,
            depsgraph=self.depsgraph,
            settings=scene,
            size_px=self.window.size_px,
            kept=kept,
            poll=self._poll(),
            camera=self._camera(),
            is_lit=not is_over_engine,
        )
        wants_vectors = view_layer.use_pass_vector and shutter is None and not is_over_engine
        look = reader.read(reports, begins_moments=shutter is not None or wants_vectors)
        return_free_memory()  # that reading took for a while, before trees are built
        config = self._config(view_layer, look, taken, is_over_engine=is_over_engine)
        if wants_vectors:
            config = replace(config, data=replace(config.data, neighbours=self._neighbours(reader, look)))
        self._mattes.add(self.depsgraph, view_layer, look.description)
        read_s = time.perf_counter() - started
        shows = taken is None
        film = self._film(reader, look, shutter, config, shows=shows)
        if is_over_engine:
            film = over_engine.marked_as_rendered(film)
        stamps = self._mattes.stamps(self.depsgraph.view_layer_eval.name)
        if taken is not None:
            taken.films[self.engine.active_view_get()] = film.planes
            taken.stamps.update(stamps)
        else:
            self._show(film.planes)
            self._stamp(stamps)
        last_render.record(self.settings.name, _statistics(film, look.description, read_s))
        for line in look.description.reports:
            self.engine.report({"WARNING"}, f"Tyndall: {line}")

    def _rendered_size_px(self, taken: film_parts.Taking | None) -> tuple[int, int]:
        """Of a tile, what it renders: the frame around it is summed up elsewhere."""
        if taken is None:
            return self.window.region_size_px
        x0, y0, x1, y1 = taken.tile.region_px(self.window)
        return x1 - x0, y1 - y0

    def _config(
        self, view_layer: ViewLayer, look: Look, taken: film_parts.Taking | None, *, is_over_engine: bool
    ) -> RenderConfig:
        config = render_config(self.settings, view_layer, self.window, look.functions, look.heterogeneity)
        config = replace(config, data=data_passes.data_config(self.depsgraph, view_layer), lights_take_turns=True)
        if is_over_engine:
            config = over_engine.air_config(config)
        if taken is not None:
            region_px = taken.tile.region_px(self.window)
            config = replace(config, region_px=region_px, is_tile=not taken.tile.is_all)
        return config

    def _neighbours(self, reader: LookReader, look: Look) -> Neighbours:
        """Blender's frame is back where it was."""
        scene = self.depsgraph.scene_eval
        frame, subframe = scene.frame_current, scene.frame_subframe
        found: list[Look] = []
        try:
            for step in (-1, 1):
                self.engine.frame_set(*frame_parts(frame + subframe + step))
                there = reader.read_moment(found[-1] if found else look)
                found.append(there)
        finally:
            self.engine.frame_set(frame, subframe)
        before, after = (Neighbour(description=one.description, camera=one.camera) for one in found)
        return Neighbours(now=look.description, before=before, after=after)

    def _film(
        self, reader: LookReader, look: Look, shutter: Shutter | None, config: RenderConfig, *, shows: bool
    ) -> Film:
        session, samples = reader.kept.session, config.pixel_samples
        lens_steps = lens_step_count(look, samples, self.settings.tyndall.shafts.lens_steps)
        if shutter is not None:
            return self._blurred(reader, look, shutter, lens_steps, config, shows=shows)
        if lens_steps == 1:
            return self._expose(session, Exposure.whole(look, samples), config, shows=shows)
        self._expose_all(session, lens_exposures(look, samples, lens_steps), config, shows=shows)
        return self._exposed.finished(moment_count=None, lens_step_count=lens_steps)

    def _blurred(
        self, reader: LookReader, look: Look, shutter: Shutter, lens_steps: int, config: RenderConfig, *, shows: bool
    ) -> Film:
        """The mean over the shutter's time; Blender's frame is back where it was, whatever happens."""
        scene = self.depsgraph.scene_eval
        frame, subframe = scene.frame_current, scene.frame_subframe
        most = max(self.settings.tyndall.motion_steps, lens_steps)
        moment_count = len(shutter.moments(config.pixel_samples, most))
        sees_through_lens = lens_steps > 1
        try:
            seen = exposures(
                self.engine, reader, look, shutter, config.pixel_samples, most, sees_through_lens=sees_through_lens
            )
            self._expose_all(reader.kept.session, seen, config, shows=shows)
        finally:
            self.engine.frame_set(frame, subframe)
        return self._exposed.finished(
            moment_count=moment_count, lens_step_count=moment_count if sees_through_lens else 1
        )

    def _expose_all(self, session: Session, seen: Iterator[Exposure], config: RenderConfig, *, shows: bool) -> None:
        for exposure in seen:
            self._mattes.add(self.depsgraph, self.depsgraph.view_layer_eval, exposure.look.description)
            self._exposed.add(self._expose(session, exposure, config, shows=shows), exposure)

    def _expose(self, session: Session, exposure: Exposure, whole: RenderConfig, *, shows: bool) -> Film:
        config, camera = exposure.config(whole), exposure.look.camera

        def work(progress: Progress, show: Callable[[Film], None]) -> Film:
            session.update(exposure.look.description, progress)
            return session.render(camera, config, progress, show if shows else None)

        def tick(progress: Progress, film: Film | None) -> None:
            self._tick(progress, film, exposure)

        return NativeCall(work).watch(is_cancelled=lambda: is_esc_pressed(self.engine), tick=tick)

    def _camera(self) -> Object:
        thing = self.depsgraph.scene_eval.camera
        if thing is None:
            raise ValueError("the scene has no camera")
        return thing

    def _poll(self) -> Callable[[], None]:
        last = time.monotonic()

        def poll() -> None:
            nonlocal last
            if time.monotonic() - last >= _POLL_S:
                last = time.monotonic()
                if is_esc_pressed(self.engine):
                    raise Cancelled

        return poll

    def _tick(self, progress: Progress, film: Film | None, exposure: Exposure) -> None:
        done = (exposure.first_sample + progress.fraction * exposure.sample_count) / exposure.pixel_samples
        self.engine.update_progress(done)
        peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        self.engine.update_memory_stats(memory_used=peak_mib, memory_peak=peak_mib)
        left = _time_left(progress.remaining_s if exposure.is_whole else self._remaining_s(done))
        self.engine.update_stats("", f"Tyndall: {progress.message}{left}")
        shown = None if film is None else self._exposed.with_part(film, exposure, progress.fraction)
        if shown is not None:
            self._show(shown.planes)
            self.engine.update_result(self.result)

    def _remaining_s(self, done: float) -> float:
        """Of a frame that is rendered in parts, with what Blender takes between them."""
        return (time.perf_counter() - self._started) * (1.0 - done) / done if done > 0.0 else 0.0

    def _show(self, planes: film_parts.Planes) -> None:
        passes.write(self.result.layers[0], planes, passes.film_exposure(self.settings))

    def _stamp(self, fields: dict[str, str]) -> None:
        """The compositor and files have them with the picture."""
        for name, text in fields.items():
            self.engine.get_result().stamp_data_add_field(name, text)


def _time_left(remaining_s: float) -> str:
    return "" if remaining_s < 1.0 else f", {int(remaining_s) // 60:02d}:{int(remaining_s) % 60:02d} left"


def _statistics(film: Film, description: SceneDescription, read_s: float) -> dict[str, object]:
    statistics = dict(film.statistics)
    statistics["stages"] = [{"name": "Blender's scene read", "seconds": read_s}, *statistics.get("stages", ())]
    known = list(statistics.get("reports", ()))
    statistics["reports"] = known + [line for line in description.reports if line not in known]
    return statistics
