# SPDX-License-Identifier: GPL-3.0-or-later
"""Images as masks in a light's space; one that has not changed is not weighed again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tyndall.scene_description import Image

#: Rec. 709, as of scene-linear colours; but a mask is weighed as it is stored, which is as the artist sees it.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


class MaskReader:
    """Keeps the masks that the next frame may use."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, str], NDArray[np.float32]] = {}
        self._used: set[tuple[str, str]] = set()

    def start_frame(self) -> None:
        self._used.clear()

    def end_frame(self) -> None:
        """Forgets the masks that this frame did not use."""
        self._kept = {key: values for key, values in self._kept.items() if key in self._used}

    def read(self, image: Image, channel: str) -> NDArray[np.float32]:
        """(height, width), [0, 1], of ``LUMINANCE`` or ``ALPHA``."""
        key = image.key, channel
        if key not in self._kept:
            self._kept[key] = _weighed(image, channel)
        self._used.add(key)
        return self._kept[key]


def _weighed(image: Image, channel: str) -> NDArray[np.float32]:
    if channel == "ALPHA" and not image.has_alpha:
        return np.ones(image.pixels.shape[:2], np.float32)
    values: NDArray[Any] = image.pixels[..., 3] if channel == "ALPHA" else image.pixels[..., :3] @ _LUMINANCE
    if image.pixels.dtype == np.uint8:
        values = values / np.float32(255)
    return np.ascontiguousarray(np.clip(np.nan_to_num(values), 0.0, 1.0), np.float32)
