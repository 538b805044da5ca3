# SPDX-License-Identifier: GPL-3.0-or-later
"""Images, as the native side takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from .scene_description import Image, Material, TextureUse


def move_to_file(image: Image, cache: _native.TileCache) -> None:
    """Its texels go to the cache's file, and out of memory. Raises IoError: the disk is full."""
    pixels, broken = _finite(image.pixels)
    image.lie_in(_native.TiledTexels(cache, image.name, np.ascontiguousarray(pixels)), broken)


def _finite(pixels: NDArray[Any]) -> tuple[NDArray[Any], int]:
    """With black in place of what is not finite, and of how many pixels that was so.

    Row by row: for a large image a mask of all its pixels is large, too.
    """
    broken = 0
    if pixels.dtype != np.uint8:
        with np.errstate(over="ignore", invalid="ignore"):
            suspects = [row for row in pixels if not np.isfinite(row.sum())]
        broken = sum(int((~np.isfinite(row).all(axis=1)).sum()) for row in suspects)
    return (np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0) if broken else pixels), broken


def build_texture(use: TextureUse, reports: list[str], *, in_memory: bool = False) -> _native.Texture:
    """The native image; pixels that are not finite become black, with a report. Raises InvalidInput without pixels.

    ``in_memory``: even that of an image in a file.
    """
    image = use.image
    texels: NDArray[Any] | _native.TiledTexels | None = image.tiles
    broken = image.broken_pixel_count
    if texels is None or in_memory:
        texels, found = _finite(image.pixels)
        broken += found
    if broken:
        reports.append(f'Image "{image.name}": {broken} pixels that are not finite are drawn black')
    return _native.Texture(
        name=image.name,
        pixels=texels,
        is_srgb=image.is_srgb,
        has_alpha=image.has_alpha,
        extension=int(use.extension),
        interpolation=int(use.interpolation),
    )


def require_whole(program: Material) -> None:
    """Raises IoError where a texel of its images was not to be had."""
    for use in program.textures:
        if use.image.tiles is not None:
            use.image.tiles.cache.require_whole()


class TextureFiles:
    """The files that a scene's textures are looked up in, and what a picture took of them."""

    def __init__(self, materials: Iterable[Material] = ()) -> None:
        images = {id(use.image): use.image for material in materials for use in material.textures}
        tiled = [image.tiles for image in images.values() if image.tiles is not None]
        self._file_bytes = sum(one.file_bytes for one in tiled)
        self._image_count = len(tiled)
        self._caches = list({id(one.cache): one.cache for one in tiled}.values())
        self._tiles_read = 0

    def begin_picture(self) -> None:
        """Tiles that are read from now on are the picture's."""
        self._tiles_read = sum(cache.tiles_read for cache in self._caches)

    def end_picture(self) -> dict[str, float]:
        """Counts for its statistics. Raises IoError where a texel was not to be had."""
        for cache in self._caches:
            cache.require_whole()
        if not self._caches:
            return {}
        mib = 1024.0 * 1024.0
        return {
            "images in a file": self._image_count,
            "images in a file: MiB": self._file_bytes / mib,
            "texture tiles read": sum(cache.tiles_read for cache in self._caches) - self._tiles_read,
            "texture tiles in memory, MiB": sum(cache.resident_bytes for cache in self._caches) / mib,
            "texture tiles in memory at most, MiB": sum(cache.budget_bytes for cache in self._caches) / mib,
        }
