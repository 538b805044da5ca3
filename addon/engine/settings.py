# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render is asked for: Blender's settings as a ``RenderConfig``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tyndall.renderer import IndirectConfig, RenderConfig, ShaftConfig

from ..sync.worlds import occlusion_reach_m
from .passes import wanted_planes

if TYPE_CHECKING:
    from bpy.types import RenderSettings, Scene, ViewLayer

    from tyndall.heterogeneity import Heterogeneity
    from tyndall.transfer_functions import WeightedFunction

#: Of lights' depth maps and slope rows, in a viewport and from frame to frame of an animation.
KEPT_MAPS_BYTES = 512 << 20
#: Of what camera rays met, in a viewport: a sample of full HD, with points to be lit, beside its coarse pictures.
KEPT_SURFACES_BYTES = 1 << 30
_LEAST_RESOLUTION = 16  #: The property starts at 0, which picks a resolution; between them lies nothing useful.
_LEAST_REACH_M = 1e-6  #: Of a world whose distance is 0, within which nothing stands.


@dataclass(frozen=True, kw_only=True)
class FrameWindow:
    """The full frame, and the part of it that renders: x from left, y from bottom, in pixels."""

    size_px: tuple[int, int]
    region_px: tuple[int, int, int, int]  #: x0, y0, x1, y1

    @property
    def region_size_px(self) -> tuple[int, int]:
        x0, y0, x1, y1 = self.region_px
        return x1 - x0, y1 - y0


def frame_window(render: RenderSettings, size_px: tuple[int, int]) -> FrameWindow:
    """The part of a frame inside the border, cut to whole pixels as Blender cuts its buffers: in single precision."""
    if not render.use_border:
        return FrameWindow(size_px=size_px, region_px=(0, 0, *size_px))
    width, height = (np.float32(size) for size in size_px)
    x0, x1 = (int(np.float32(edge) * width) for edge in (render.border_min_x, render.border_max_x))
    y0, y1 = (int(np.float32(edge) * height) for edge in (render.border_min_y, render.border_max_y))
    return FrameWindow(size_px=size_px, region_px=(x0, y0, x1, y1))


def shaft_config(scene: Scene) -> ShaftConfig:
    """How final renders find shafts."""
    shafts = scene.tyndall.shafts
    return ShaftConfig(
        method=shafts.method,
        error_target=shafts.error_target,
        resolution=shafts.resolution and max(shafts.resolution, _LEAST_RESOLUTION),
        light_samples=shafts.light_samples,
        world_samples=shafts.world_samples,
        attenuates_light=shafts.attenuates_light,
        adapts_strata=shafts.adapts_strata,
        shares_strata=shafts.shares_strata,
        grid_method=shafts.grid_method,
        grid_error_target=shafts.grid_error_target,
        seed=scene.tyndall.seed,
    )


def indirect_config(scene: Scene) -> IndirectConfig:
    """What surfaces see of one another."""
    indirect = scene.tyndall.indirect
    has_ambient_occlusion = indirect.has_ambient_occlusion
    return IndirectConfig(
        ambient_occlusion=has_ambient_occlusion,
        ambient_distance_m=(
            indirect.ambient_distance_m if has_ambient_occlusion else max(occlusion_reach_m(scene), _LEAST_REACH_M)
        ),
        ambient_samples=indirect.ambient_samples,
        bounce=indirect.has_bounce,
        bounce_samples=indirect.bounce_samples,
        mirror_depth=indirect.mirror_depth if indirect.has_mirrors else 0,
        refraction_depth=indirect.refraction_depth if indirect.has_mirrors and indirect.has_refraction else 0,
    )


def render_config(
    scene: Scene,
    view_layer: ViewLayer,
    window: FrameWindow,
    functions: tuple[WeightedFunction, ...] = (),
    heterogeneity: Heterogeneity | None = None,
) -> RenderConfig:
    """The settings of a final render of one view layer."""
    tyndall = scene.tyndall
    light = scene.original.tyndall.shafts.transfer_light  # that of the evaluated scene may dangle
    return RenderConfig(
        pixel_samples=tyndall.pixel_samples,
        pixel_filter=tyndall.pixel_filter,
        filter_width_px=tyndall.filter_width_px,
        noise_threshold=tyndall.noise_threshold,
        voxel_detail_px=tyndall.voxel_detail_px,
        region_px=window.region_px,
        film_transparent=scene.render.film_transparent,
        passes=wanted_planes(view_layer),
        pass_alpha_threshold=view_layer.pass_alpha_threshold,
        keeps_light_groups=bool(view_layer.lightgroups),
        shafts=shaft_config(scene),
        transfer_functions=functions,
        reference_light=light.name if light is not None else "",
        heterogeneity=heterogeneity,
        indirect=indirect_config(scene),
        seed=tyndall.seed,
        thread_count=tyndall.thread_count,
    )
