# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that colour the beams of lights, as the native side takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import _native
from .native_textures import build_texture

if TYPE_CHECKING:
    from collections.abc import Callable

    from .native_scene import NativeParts
    from .scene_description import Light, LightTexture, TextureUse


def build_light_textures(
    lights: tuple[Light, ...], parts: NativeParts, reports: list[str]
) -> dict[int, _native.LightTexture]:
    """By the ``id`` of the light that each colours; new pictures go into ``parts``, those that are gone leave it."""
    kept: dict[tuple[str, int, int], _native.FilteredTexture] = {}

    def filtered(use: TextureUse) -> _native.FilteredTexture:
        key = (use.image.key, int(use.extension), int(use.interpolation))
        if key not in kept:
            native = parts.light_textures.get(key)
            parts.counts["images sent" if native is None else "images reused"] += 1
            kept[key] = (
                native if native is not None else _native.FilteredTexture(build_texture(use, reports, in_memory=True))
            )
        return kept[key]

    built = {}
    for light in lights:
        if light.texture is not None:
            try:
                built[id(light)] = _build(light.texture, filtered)
            except _native.InvalidInput as error:
                reports.append(f'Light "{light.name}": its texture is left out: {error}')
    parts.light_textures = kept
    return built


def _build(texture: LightTexture, filtered: Callable[[TextureUse], _native.FilteredTexture]) -> _native.LightTexture:
    return _native.LightTexture(
        image=filtered(texture.use),
        projection=int(texture.projection),
        width_m=texture.width_m,
        centre_m=texture.centre_m,
        follows_normal=texture.follows_normal,
        axes_from_world=texture.axes_from_world.ravel().tolist(),
        place_from_axes=texture.place_from_axes.ravel().tolist(),
        uv_from_projected=texture.uv_from_projected.ravel().tolist(),
        offset=texture.offset,
        gain=texture.gain.ravel().tolist(),
        distance_power=texture.distance_power,
        smooth_m2=texture.smooth_m2,
    )
