# SPDX-License-Identifier: GPL-3.0-or-later
"""From the strokes of a light to its fitted map: read from Blender, solved beside it, written back as a gobo.

What reads and writes Blender's data runs in the main thread; ``PreparedFit.run`` may run in any.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy
from bpy.app.handlers import persistent

from .frame_size import frame_size_px

if TYPE_CHECKING:
    from bpy.types import Context, Image, Light, Object

    from tyndall import Progress
    from tyndall.light_map_fit import LightMap, LightMapFit, LightMapFitConfig, StrokeView
    from tyndall.renderer import Session
    from tyndall.scene_description import SceneDescription

#: Fits that may go on, by the full name of their light; in memory only.
_kept: dict[str, LightMapFit] = {}
#: The scene as the last fit saw it: the next one takes over what has not changed. One at most; none while a fit begins.
_idle_sessions: list[Session] = []


#: Bytes of maps that a session keeps: no map has room, but the scene's occluders are gathered once.
_OCCLUDERS_ALONE = 1


@dataclass(eq=False)
class PreparedFit:
    """A fit that may run."""

    step_count: int
    fit: LightMapFit | None = None  #: Under way.
    reports: tuple[str, ...] = ()

    def run(self, progress: Progress) -> None:
        """Raises InvalidInput, and Cancelled, after which the fit has its last whole step."""
        self.begin(progress)
        assert self.fit is not None  # noqa: S101  begin has made it
        self.fit.iterate(self.step_count, progress)

    def begin(self, progress: Progress) -> None:
        """Find what the strokes see, unless that is known."""


@dataclass(eq=False, kw_only=True)
class _NewFit(PreparedFit):
    light_name: str  #: Of the object, as the description has it.
    description: SceneDescription
    views: list[StrokeView] = field(default_factory=list)
    current: LightMap | None = None
    config: LightMapFitConfig

    def begin(self, progress: Progress) -> None:
        from tyndall.light_map_fit import LightMapFit
        from tyndall.renderer import Session

        session = _idle_sessions.pop() if _idle_sessions else Session(kept_maps_bytes=_OCCLUDERS_ALONE)
        session.update(self.description, progress)
        self.fit = LightMapFit(session, self.light_name, self.views, progress, current=self.current, config=self.config)
        _idle_sessions[:] = [session]


def kept_fit(light: Light) -> LightMapFit | None:
    """What Continue goes on with."""
    return _kept.get(light.name_full)


def keep(light: Light, fit: LightMapFit) -> None:
    _kept[light.name_full] = fit


def continued_fit(light: Light) -> PreparedFit:
    """More steps of the light's last fit. Raises ValueError where there is none."""
    fit = kept_fit(light)
    if fit is None:
        raise ValueError(f'Light "{light.name}" has no fit to go on with: fit its map first')
    return PreparedFit(step_count=light.tyndall.light_map_fit.steps, fit=fit)


def new_fit(context: Context, light: Light, thing: Object) -> PreparedFit:
    """A fit of the strokes over the scene as it is now. Raises ValueError, which names what is missing."""
    from tyndall import Progress
    from tyndall.light_map_fit import LightMapFitConfig

    from .engine.settings import shaft_config
    from .sync.light_map_fit import read_current_map, read_views
    from .sync.reports import Reports
    from .sync.scene import SceneReader

    settings, scene = light.tyndall.light_map_fit, context.scene
    depsgraph = context.evaluated_depsgraph_get()
    reports = Reports()
    enabled = [view for view in settings.views if view.is_enabled]
    if not enabled:
        raise ValueError(f'Light "{light.name}": nothing is painted: Paint Strokes begins')
    views = read_views(enabled, depsgraph, frame_size_px(scene), reports)
    current = read_current_map(light, reports)
    notes = reports.lines()
    if not views:
        raise ValueError("; ".join(notes))
    return _NewFit(
        step_count=settings.steps,
        reports=notes,
        light_name=thing.name,
        description=SceneReader().read(depsgraph, Reports(), Progress().poll),
        views=views,
        current=current,
        config=LightMapFitConfig(
            resolution=settings.resolution,
            regularisation=settings.regularisation,
            shafts=shaft_config(scene),
            thread_count=scene.tyndall.thread_count,
        ),
    )


def write_back(light: Light, fit: LightMapFit) -> Image:
    """Make the fitted map the light's gobo, in the image that it had from its last fit if it still has that."""
    import numpy as np  # Debian's Blender comes without: the add-on must load, and say so

    light_map = fit.light_map
    count = len(light_map.texels)
    settings = light.tyndall
    image: Image | None = settings.gobo_image
    if image is None or image.library is not None or not image.get(_IS_FITTED):
        image = bpy.data.images.new(f"{light.name} light map", count, count, float_buffer=True)
        image[_IS_FITTED] = True
    elif tuple(image.size) != (count, count):
        image.scale(count, count)
    texels = np.ones((count, count, 4), np.float32)
    texels[..., :3] = light_map.texels
    image.pixels.foreach_set(texels.ravel())
    image.update()
    image.pack()
    settings.gobo_image = image
    if light.type == "SUN":
        settings.gobo_size_m = light_map.size_m
        settings.gobo_offset_m = light_map.centre_m
    settings.gobo_extension = "EXTEND"
    settings.gobo_strength = 1.0
    settings.light_map_fit.residuals = " ".join(f"{residual:.5g}" for residual in fit.residuals)
    light.update_tag()
    keep(light, fit)
    return image


#: A mark on images that a fit may write to again.
_IS_FITTED = "tyndall_is_fitted"


def residuals_of(light: Light) -> list[float]:
    """Of the last fit's first map and each of its steps; nothing before the first fit."""
    return [float(residual) for residual in light.tyndall.light_map_fit.residuals.split()]


@persistent
def _forget(*_: object) -> None:
    _kept.clear()
    _idle_sessions.clear()


def register() -> None:
    bpy.app.handlers.load_pre.append(_forget)


def unregister() -> None:
    bpy.app.handlers.load_pre.remove(_forget)
    _forget()
