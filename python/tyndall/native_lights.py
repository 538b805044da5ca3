# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, as the native side takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import _native
from .native_light_links import link_masks
from .occluder_edits import build_occluder_edits
from .scene_description import LightKind, LightProjection

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .scene_description import Light


#: A point light shines all around, and a sun along its axis, whatever scales of 0 make of the rest.
_SHINES_WHEN_FLAT = {LightKind.POINT, LightKind.SUN}


def _filled(rotation_and_scale: NDArray[np.float64], *, keeps_axis: bool) -> NDArray[np.float64]:
    """With a length of 1 where it has none: a regular matrix stays as it is, and so does one whose axis is lost."""
    if not np.isfinite(rotation_and_scale).all() or (keeps_axis and not rotation_and_scale[:, 2].any()):
        return rotation_and_scale
    if rotation_and_scale.any(axis=0).all():
        return rotation_and_scale
    left, lengths, right = np.linalg.svd(rotation_and_scale)
    filled: NDArray[np.float64] = (left * np.where(lengths > 1e-12 * lengths[0], lengths, 1.0)) @ right
    return filled


def build_light(
    light: Light,
    origin: NDArray[np.float64],
    object_names: Sequence[str],
    texture: _native.LightTexture | None,
    light_group: int,
    reports: list[str],
) -> _native.Light:
    """The native light, relative to the origin. Raises InvalidInput; an edit that cannot be used is reported only."""
    rotation_and_scale = light.world_from_light[:3, :3]
    if light.kind in _SHINES_WHEN_FLAT:
        rotation_and_scale = _filled(rotation_and_scale, keeps_axis=light.kind is LightKind.SUN)
    axis = -rotation_and_scale[:, 2]
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        raise _native.InvalidInput("its matrix has no direction (scale 0)")
    try:
        light_from_world = np.linalg.inv(rotation_and_scale)
    except np.linalg.LinAlgError:
        raise _native.InvalidInput("its matrix is singular (scale 0)") from None
    is_on_emitter = light.texture is not None and light.texture.projection is LightProjection.EMITTER
    if light.texture is not None and is_on_emitter != (light.kind is LightKind.AREA):
        raise _native.InvalidInput("area lights, and no others, show a picture where the light leaves them")
    half_size_m = np.zeros(2)
    if light.kind is LightKind.AREA:
        half_size_m = 0.5 * np.array(light.size_m) * np.linalg.norm(rotation_and_scale[:, :2], axis=0)
    return _native.Light(
        name=light.name,
        kind=int(light.kind),
        strength=light.strength,
        position=tuple(light.world_from_light[:3, 3] - origin),
        axis=tuple(axis / length),
        light_from_world_directions=light_from_world.astype(np.float32, order="C"),
        half_angle_rad=light.half_angle_rad,
        radius_m=light.radius_m,
        spot_half_angle_rad=light.spread_rad / 2 if light.kind is LightKind.AREA else light.spot_half_angle_rad,
        spot_blend=light.spot_blend,
        spot_falloff=int(light.spot_falloff),
        body=int(light.body),
        half_size_m=tuple(half_size_m),
        is_ellipse=light.is_ellipse,
        casts_shadow=light.casts_shadow,
        lights_surfaces=light.lights_surfaces,
        lights_catchers=light.lights_catchers,
        scatters_in_media=light.scatters_in_media,
        occluder_edits=build_occluder_edits(light, object_names, reports),
        texture=texture,
        light_group=light_group,
        links=link_masks(light.links),
        unlit_media=list(light.unlit_media),
    )
