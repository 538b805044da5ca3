# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene-linear colours of an image's pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .scene_description import Image

_BYTE = np.arange(256) / 255.0
#: IEC 61966-2-1: linear below 0.04045.
_SRGB_TO_LINEAR = np.where(_BYTE <= 0.04045, _BYTE / 12.92, ((_BYTE + 0.055) / 1.055) ** 2.4)  # noqa: PLR2004


def linear_colours(image: Image) -> NDArray[np.float32]:
    """Float32 ``(height, width, 3)``, contiguous; not multiplied with alpha, nor divided by it."""
    encoded = image.pixels[:, :, :3]
    linear: NDArray[Any] = encoded
    if encoded.dtype == np.uint8:
        linear = _SRGB_TO_LINEAR[encoded] if image.is_srgb else encoded / np.float32(255)
    return np.ascontiguousarray(linear, dtype=np.float32)
