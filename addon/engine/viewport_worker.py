# SPDX-License-Identifier: GPL-3.0-or-later
"""The thread behind a rendered viewport: first a coarse picture, then finer ones, until something changes.

It owns the native session and knows no Blender. The main thread leaves a view here and takes pictures away; neither
ever waits for a render.
"""

from __future__ import annotations

import math
import os
import threading
import time
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from tyndall import Cancelled, Progress
from tyndall.light_paths import is_light
from tyndall.renderer import Film, RenderConfig, Session

from .error_texts import text_of
from .viewport_pictures import shown

if TYPE_CHECKING:
    from tyndall.scene_description import Camera, FloatArray, SceneDescription

#: Pixels of the region per pixel of the first pictures, along each side.
SCALES = (8, 4, 2)
#: A finer picture that will probably be there within this time is not announced by a coarser one.
SOON_S = 0.1
#: A first picture is left to complete for this time, or a moving view would never show one. Each one that is cut short
#: nevertheless doubles it, for scenes and machines that need longer.
PATIENCE_S = 0.5
#: Of the scene's update, which a picture's statistics repeat.
UPDATE_STAGES = ("scene update", "scene", "scene: tree")
UPDATE_COUNTS = ("scene rebuilt", "scene moved", "scene relit")


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """A camera for the whole region, and the settings of the finished picture."""

    camera: Camera
    #: With ``thread_count`` 0, the first picture takes all threads, for it is there at once; finer ones leave one to
    #: the window.
    config: RenderConfig
    plane: str = "Combined"  #: Which one is shown, as viewport_pictures has it; the settings ask for it.

    def is_like(self, other: View | None) -> bool:
        """Whether both show the same picture of the same scene."""
        return other is not None and self.key() == other.key()

    def key(self) -> tuple[object, ...]:
        """Everything that the picture depends on."""
        camera, matrix = self.camera, "world_from_camera"
        rest = (getattr(camera, entry.name) for entry in fields(camera) if entry.name != matrix)
        return camera.world_from_camera.tobytes(), *rest, self.config, self.plane


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """Something to draw until a better one comes."""

    rgba: FloatArray  #: (height, width, 4), scene-linear, alpha premultiplied, rows bottom to top.
    bounds: tuple[float, float, float, float]  #: Left, bottom, right, top as shares of the region.
    scale: int = 1  #: Pixels of the region per pixel, along each side.
    is_light: bool = True  #: The film's exposure multiplies it.


@dataclass(frozen=True, kw_only=True, eq=False)
class Work:
    """What was done for a picture."""

    statistics: dict[str, Any]  #: As ``Film.statistics``; of the update before it, if it is the first one after it.
    scale: int  #: Pixels of the region per pixel of the picture, along each side.
    first_s: float = 0.0  #: From the change that it shows to its first, perhaps coarse picture.


def coarser(view: View, scale: int) -> View:
    """The same view with ``scale`` squared times fewer pixels, one sample in each, and rougher shafts."""
    config, shafts = view.config, view.config.shafts
    width, height = (math.ceil(side / scale) for side in view.camera.size_px)
    region_px = config.region_px
    if region_px:
        x0, y0, x1, y1 = region_px
        region_px = x0 // scale, y0 // scale, math.ceil(x1 / scale), math.ceil(y1 / scale)
    shafts = replace(
        shafts,
        error_target=min(shafts.error_target * scale, 0.1),
        grid_error_target=min(shafts.grid_error_target * scale, 0.3),
        walks_maps=True,
        light_samples=min(shafts.light_samples, SCALES[0] // scale),  # places on each lamp, a map for each
        world_samples=min(shafts.world_samples, 8),
    )
    air = config.heterogeneity
    if air is not None:  # a pixel is as large as several of the finished picture
        air = replace(air, upsampling=max(1, air.upsampling // scale))
    # Each side is rounded up to whole pixels, so the window grows by the share that they stick out.
    grown_x, grown_y = width * scale / view.camera.size_px[0], height * scale / view.camera.size_px[1]
    left, right, bottom, top = view.camera.window
    window = left, left + (right - left) * grown_x, bottom, bottom + (top - bottom) * grown_y
    return replace(
        view,
        camera=replace(view.camera, size_px=(width, height), window=window),
        config=replace(
            config,
            region_px=region_px,
            pixel_samples=1,
            shafts=shafts,
            heterogeneity=air,
            indirect=replace(config.indirect, ambient_samples=1, bounce_samples=min(config.indirect.bounce_samples, 1)),
            adapts_shadow_rays=scale < SCALES[0],  # the pilot would take as long as the coarsest picture
        ),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Job:
    view: View
    description: SceneDescription | None  #: None: the session has it.
    read_s: float  #: What reading the description took.
    asked_at: float  #: When it was first asked for, as time.monotonic().
    progress: Progress


class ViewportWorker:
    """All public methods are for the main thread; they return at once."""

    def __init__(self, session: Session) -> None:
        self._session = session  # the thread's alone from here on
        self._changed = threading.Condition()
        self._view: View | None = None
        self._description: SceneDescription | None = None  # that the session has not seen
        self._is_outdated = False  # the job at work, by a later one
        self._is_closed = False
        self._progress = Progress()  # of the job at work
        self._is_disturbed = False  # a call came while trees were finished
        self._patience_s = PATIENCE_S
        self._patience_ends = 0.0  # before this moment the job at work is left alone
        self._read_s = 0.0  # of the description
        self._asked_at = 0.0  # by the oldest call that no job has taken
        self._first_s = 0.0
        self._picture: Picture | None = None
        self._work: Work | None = None
        self._update_stages: list[dict[str, Any]] = []  # of the update that no picture has told of yet
        self._status = ""
        self._has_news = False
        self._thread = threading.Thread(target=self._run, name="tyndall viewport", daemon=True)
        self._thread.start()

    def show(self, view: View, description: SceneDescription | None = None, read_s: float = 0.0) -> None:
        """Ask for a view of the scene, or of a new state of it, which took ``read_s`` to read."""
        with self._changed:
            if not self._is_outdated:
                self._asked_at = time.monotonic() - read_s
            self._view = view
            self._description, self._read_s = description or self._description, self._read_s + read_s
            self._is_outdated = True
            self._changed.notify()
        self.poll()

    def poll(self) -> bool:
        """Call it often: stops what is outdated. Whether picture or status changed since the last call."""
        with self._changed:
            if self._is_outdated and time.monotonic() >= self._patience_ends:
                self._progress.cancel()
            has_news, self._has_news = self._has_news, False
            return has_news

    @property
    def picture(self) -> Picture | None:
        """The latest picture, perhaps of the view before."""
        return self._picture

    @property
    def work(self) -> Work | None:
        """What the latest picture took that is as fine as it was asked for: not of one that still grows."""
        return self._work

    @property
    def status(self) -> str:
        """What the artist should read: what is being done, or what went wrong."""
        return self._status

    def close(self) -> None:
        """Stop the thread and wait for it: as long as the native side takes between two polls."""
        with self._changed:
            self._is_closed = True
            self._progress.cancel()
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        session = self._session
        finished: View | None = None
        while (job := self._next_job()) is not None:
            try:
                if job.description is not None and self._update(session, job.description, job):
                    finished = None
                if not job.view.is_like(finished):
                    finished = None
                    self._refine(session, job)
                    finished = job.view
                self._publish(None, "")
            except Cancelled:
                finished = None
            except Exception as error:  # noqa: BLE001  nobody waits for it here: the message goes on the screen
                finished = None
                self._publish(None, text_of(error))

    def _next_job(self) -> _Job | None:
        """Wait for something to do; None when there will be nothing any more."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_outdated or self._is_closed)
            if self._is_closed:
                return None
            self._is_outdated = False
            description, self._description = self._description, None
            read_s, self._read_s = self._read_s, 0.0
            self._progress = Progress()
            return _Job(
                view=self._view,
                description=description,
                read_s=read_s,
                asked_at=self._asked_at,
                progress=self._progress,
            )

    def _update(self, session: Session, description: SceneDescription, job: _Job) -> bool:
        """Bring the session up to date, never cut short: a moving view does not void it. Whether anything changed."""
        self._patience_ends = math.inf
        self._publish(None, "Updating the scene")
        try:
            session.update(description, job.progress)
        finally:
            self._patience_ends = 0.0
        self._update_stages = [{"name": "scene reading", "seconds": job.read_s}]
        counts = session.statistics["counts"]
        return any(counts.get(name) for name in UPDATE_COUNTS)

    def _refine(self, session: Session, job: _Job) -> None:
        """Show one picture after the other, each finer than the last; Cancelled once outdated."""
        view, progress = job.view, job.progress
        self._first_s = 0.0
        finished = _beside_the_window(view)
        # Where only colours of light shafts changed, the finished picture takes less time than a coarse one.
        scale = 1 if session.has_picture(finished.camera, finished.config) else SCALES[0]
        self._patience_ends = time.monotonic() + self._patience_s
        self._patience_s *= 2.0
        while scale > 1:
            started = time.monotonic()
            rough = coarser(view if scale == SCALES[0] else finished, scale)
            film = session.render(rough.camera, rough.config, progress)
            self._first_s = self._first_s or time.monotonic() - job.asked_at
            if scale == SCALES[0]:
                self._patience_ends, self._patience_s = 0.0, max(PATIENCE_S, 2.0 * (time.monotonic() - started))
            self._publish(_picture(film, rough, view, scale), f"Rendering 1/{scale}", film)
            if self._is_outdated:
                raise Cancelled
            scale = _next_scale(scale, seconds=time.monotonic() - started)

        def show_so_far(film: Film) -> None:
            self._publish(_picture(film, view, view, 1), "Rendering")

        if not self._is_disturbed:
            self._finish_trees(session, progress)
        film = session.render(finished.camera, finished.config, progress, show_so_far)
        self._first_s = self._first_s or time.monotonic() - job.asked_at
        self._publish(_picture(film, view, view, 1), "", film)
        self._finish_trees(session, progress)

    def _finish_trees(self, session: Session, progress: Progress) -> None:
        """A view that moves is not held up twice: after that they wait for a finished picture."""
        if session.has_hasty_trees:
            self._publish(None, "Finishing the scene")
            self._is_disturbed = True
            session.finish_trees(progress)
            self._publish(None, "Rendering")  # a picture so far may not come for long
        self._is_disturbed = False

    def _publish(self, picture: Picture | None, status: str, film: Film | None = None) -> None:
        """``film``: complete, with its statistics."""
        work = self._work if picture is None or film is None else self._work_for(film, picture.scale)
        with self._changed:
            self._picture = picture or self._picture
            self._work = work
            self._has_news = self._has_news or picture is not None or status != self._status
            self._status = status

    def _work_for(self, film: Film, scale: int) -> Work:
        """Only the first picture after an update tells of it."""
        statistics = film.statistics
        stages = statistics.get("stages", [])
        if not self._update_stages:
            stages = [stage for stage in stages if stage["name"] not in UPDATE_STAGES]
            counts = {name: n for name, n in statistics.get("counts", {}).items() if name not in UPDATE_COUNTS}
            statistics = statistics | {"counts": counts}
        stages, self._update_stages = [*self._update_stages, *stages], []
        return Work(statistics=statistics | {"stages": stages}, scale=scale, first_s=self._first_s)


def _beside_the_window(view: View) -> View:
    """With one thread less than there are, unless the artist has set their number."""
    count = view.config.thread_count or max(1, (os.cpu_count() or 1) - 1)
    return replace(view, config=replace(view.config, thread_count=count))


def _next_scale(scale: int, *, seconds: float) -> int:
    """The finest that will be there soon, going by the pixels' cost so far; or else the next finer one."""
    finer = [finer for finer in (*SCALES, 1) if finer < scale]
    soon = [finer for finer in finer if seconds * (scale / finer) ** 2 < SOON_S]
    return min(soon, default=max(finer))


def _picture(film: Film, rendered: View, view: View, scale: int) -> Picture:
    width, height = view.camera.size_px
    x0, y0, x1, y1 = rendered.config.region_px or (0, 0, *rendered.camera.size_px)
    return Picture(
        rgba=shown(film.planes, view.plane),
        bounds=(x0 * scale / width, y0 * scale / height, x1 * scale / width, y1 * scale / height),
        scale=scale,
        is_light=is_light(view.plane),
    )
