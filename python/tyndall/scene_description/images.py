# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures, and how texels become colours."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tyndall import _native


class Image:
    """Pixels as Blender's ``Image.pixels`` orders them: rows bottom to top, RGBA, alpha unassociated.

    ``key``: the same key in the next frame promises the same content. uint8 is encoded as ``is_srgb`` says, float32 is
    scene-linear. What ``_native.shared_array`` made is shared with textures, any other array copied into each.
    """

    def __init__(
        self,
        *,
        key: str,
        name: str,
        pixels: NDArray[np.uint8] | NDArray[np.float32],
        is_srgb: bool = True,
        has_alpha: bool = False,
    ) -> None:
        self.key = key
        self.name = name
        self.is_srgb = is_srgb
        self.has_alpha = has_alpha
        self.shape: tuple[int, ...] = pixels.shape  #: (height, width, 4).
        self.is_float = pixels.dtype != np.uint8
        self.broken_pixel_count = 0  #: Of one in a file: those that were not finite, and are black.
        self._texels: NDArray[Any] | _native.TiledTexels = pixels

    @property
    def byte_count(self) -> int:
        """Of its texels."""
        return int(np.prod(self.shape)) * (4 if self.is_float else 1)

    @property
    def tiles(self) -> _native.TiledTexels | None:
        """Where it lies; None: in memory."""
        return None if isinstance(self._texels, np.ndarray) else self._texels

    @property
    def pixels(self) -> NDArray[Any]:
        """All of them; read from its file, anew each time, where it lies in one. Raises IoError."""
        return self._texels if isinstance(self._texels, np.ndarray) else self._texels.whole()

    def lie_in(self, tiles: _native.TiledTexels, broken_pixel_count: int) -> None:
        """Let go of the memory. The key changes: who has the old one keeps what it has."""
        # In this order: whoever reads both meanwhile has the old key of the new texels, which are the same.
        self.broken_pixel_count = broken_pixel_count
        self._texels = tiles
        self.key += f" in file {id(tiles.cache)}"


class Extension(IntEnum):
    """What lies outside of an image, in Blender's words."""

    REPEAT = 0
    EXTEND = 1
    CLIP = 2
    MIRROR = 3


class Interpolation(IntEnum):
    """How texels become a colour between their centres."""

    CLOSEST = 0
    LINEAR = 1
    CUBIC = 2  #: B-spline, Blender's Smart too.
