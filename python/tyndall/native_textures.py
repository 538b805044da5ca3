# SPDX-License-Identifier: GPL-3.0-or-later
"""Images, as the native side takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .scene_description import TextureUse


def build_texture(use: TextureUse, reports: list[str]) -> _native.Texture:
    """The native image; pixels that are not finite become black, with a report. Raises InvalidInput without pixels."""
    pixels: NDArray[Any] = use.image.pixels
    broken = 0 if pixels.dtype == np.uint8 else int((~np.isfinite(pixels).all(axis=2)).sum())
    if broken:
        pixels = np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0)
        reports.append(f'Image "{use.image.name}": {broken} pixels that are not finite are drawn black')
    return _native.Texture(
        name=use.image.name,
        pixels=pixels,
        is_srgb=use.image.is_srgb,
        has_alpha=use.image.has_alpha,
        extension=int(use.extension),
        interpolation=int(use.interpolation),
    )
