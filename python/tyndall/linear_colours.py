# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene-linear colours of an image's pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._native import shared_array

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .scene_description import Image


def linear_from_srgb(encoded: NDArray[Any]) -> NDArray[Any]:
    """IEC 61966-2-1: linear below 0.04045."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((np.maximum(encoded, 0) + 0.055) / 1.055) ** 2.4)  # noqa: PLR2004


def srgb_from_linear(linear: NDArray[Any]) -> NDArray[Any]:
    """The inverse, of values from 0 on."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055)  # noqa: PLR2004


_SRGB_TO_LINEAR = linear_from_srgb(np.arange(256) / 255.0)


def linear_texels(image: Image) -> NDArray[np.float32]:
    """Float32 ``(height, width, 4)`` for a world: linear colours, and what alpha there is; of floats the pixels."""
    texels = image.pixels
    if texels.dtype == np.float32:
        return np.ascontiguousarray(texels)
    linear: NDArray[np.float32] = shared_array(texels.shape, np.dtype(np.float32))
    table = (_SRGB_TO_LINEAR if image.is_srgb else np.arange(256) / 255.0).astype(np.float32)
    table.take(texels, out=linear, mode="clip")
    return linear


def linear_colours(image: Image) -> NDArray[np.float32]:
    """Float32 ``(height, width, 3)``, contiguous; not multiplied with alpha, nor divided by it."""
    encoded = image.pixels[:, :, :3]
    linear: NDArray[Any] = encoded
    if encoded.dtype == np.uint8:
        linear = _SRGB_TO_LINEAR[encoded] if image.is_srgb else encoded / np.float32(255)
    return np.ascontiguousarray(linear, dtype=np.float32)
