# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture that a light has to throw so that its shafts look as somebody painted them (Kol 2018, section 5.4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from .render_config import ShaftConfig, native_shafts
from .renderer import Session
from .scene_description import (
    Camera,
    Extension,
    FloatArray,
    Image,
    Light,
    LightKind,
    LightProjection,
    LightTexture,
    TextureUse,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class StrokeView:
    """Desired shaft colours, painted over what a camera shows."""

    name: str
    camera: Camera
    #: float32 (height, width, 4), rows bottom to top, over the camera's full frame, of any size. Scene-linear colours
    #: that are not multiplied with alpha: 1 is the light's own. Alpha is how much a pixel matters; 0: not painted.
    texels: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class LightMap:
    """A square picture that a light's strength is multiplied by.

    A sun's lies across it, along the light's own X and Y. A spot's fills its cone, and a point light's is all around
    it, by longitude and latitude: ``size_m`` and ``centre_m`` are then those of the whole picture, 1 and (0.5, 0.5).
    """

    texels: FloatArray  #: float32 (n, n, 3), rows bottom to top, >= 0.
    size_m: float = 1.0  #: Of a side.
    centre_m: tuple[float, float] = (0.5, 0.5)  #: From the light's origin.

    def texture_of(self, light: Light, key: str) -> LightTexture:
        """The map as the light's ``texture``. ``key``: of its pixels; another one where they changed."""
        texels = np.ones((*self.texels.shape[:2], 4), np.float32)
        texels[..., :3] = self.texels
        use = TextureUse(image=Image(key=key, name=key, pixels=texels, is_srgb=False), extension=Extension.EXTEND)
        if light.kind is LightKind.SUN:
            return LightTexture(use=use, width_m=self.size_m, centre_m=self.centre_m)
        axes_from_world = np.linalg.inv(light.world_from_light[:3, :3]).astype(np.float64)
        if light.kind is LightKind.POINT:
            return LightTexture(
                use=TextureUse(image=use.image, extension=Extension.REPEAT),
                projection=LightProjection.SPHERE,
                follows_normal=True,
                axes_from_world=axes_from_world,
            )
        half_cotangent = 0.5 / np.tan(light.spot_half_angle_rad)
        return LightTexture(
            use=use,
            projection=LightProjection.PERSPECTIVE,
            axes_from_world=axes_from_world,
            place_from_axes=np.array(
                [[half_cotangent, 0, -0.5, 0], [0, half_cotangent, -0.5, 0], [0, 0, -1.0, 0]], np.float64
            ),
        )


@dataclass(frozen=True, kw_only=True)
class LightMapFitConfig:
    """Settings of a fit; the native side checks the ranges and raises ``InvalidInput``."""

    resolution: int = 512  #: Texels per side, [16, 4096].
    #: How much the map stays what it is, [0, 1e6]; 1 weighs a texel's change as much as what the strokes say of it.
    regularisation: float = 1e-3
    most_pixels: int = 131072  #: Of one view; where more are painted, neighbours are taken together.
    shafts: ShaftConfig = field(default_factory=ShaftConfig)
    thread_count: int = 0  #: 0: all.


class LightMapFit:
    """A fit under way: take steps until the map is good enough. Not for two threads at once."""

    def __init__(
        self,
        session: Session,
        light_name: str,
        views: Sequence[StrokeView],
        progress: _native.Progress,
        *,
        current: LightMap | None = None,
        config: LightMapFitConfig | None = None,
    ) -> None:
        """Find what the strokes see in the scene as last updated, and how the map's texels make it; no step yet.

        ``current`` is what the map stays close to where strokes do not say otherwise, and its first guess; None: white.
        Its place and texels are kept where its resolution is the configuration's and it covers what the strokes see. A
        picture that the light has already does not count: the map takes its place.
        Raises ``InvalidInput``, which names what is missing, and ``Cancelled``.
        """
        config = config or LightMapFitConfig()
        scene, light = session.native_light(light_name)
        self._native = _native.LightMapFit(
            scene=scene,
            views=[(session.native_camera(view.camera), _native_picture(view)) for view in views],
            current=_native.LightMap() if current is None else _native_map(current),
            light=light,
            resolution=config.resolution,
            regularisation=config.regularisation,
            most_pixels=config.most_pixels,
            shafts=native_shafts(config.shafts, session.kept_maps),
            thread_count=config.thread_count,
            progress=progress,
        )

    def iterate(self, step_count: int, progress: _native.Progress) -> bool:
        """Take at most so many steps; False: the map is as good as it gets.

        Raises ``Cancelled``, after which the map is that of the last whole step, and further steps may follow.
        """
        return bool(self._native.iterate(step_count, progress))

    @property
    def light_map(self) -> LightMap:
        """The map so far."""
        return LightMap(texels=self._native.texels, size_m=self._native.size_m, centre_m=self._native.centre_m)

    @property
    def residuals(self) -> NDArray[np.float64]:
        """Of the first map and after each step, (steps + 1,): how far the strokes' pixels are from what was painted.

        Weighted RMS of the difference, as a share of what a white map gives.
        """
        history: NDArray[np.float64] = self._native.history
        return history[:, 0]

    @property
    def objectives(self) -> NDArray[np.float64]:
        """What each step lowers, or leaves, (steps + 1, 3): per channel, squares of the residual and of the changes."""
        history: NDArray[np.float64] = self._native.history
        return history[:, 1:]

    @property
    def statistics(self) -> dict[str, Any]:
        """``stages``, ``skipped``, ``counts`` and ``reports``, as of a film."""
        statistics: dict[str, Any] = self._native.statistics.to_dict()
        return statistics


def _native_picture(view: StrokeView) -> _native.StrokePicture:
    return _native.StrokePicture(name=view.name, texels=np.ascontiguousarray(view.texels, np.float32))


def _native_map(current: LightMap) -> _native.LightMap:
    texels = np.nan_to_num(current.texels, nan=1.0, posinf=1.0, neginf=0.0)
    return _native.LightMap(
        texels=np.ascontiguousarray(texels, np.float32), size_m=current.size_m, centre_m=current.centre_m
    )
