# SPDX-License-Identifier: GPL-3.0-or-later
"""A small plot for panels of how a fit's error fell, step by step, on a logarithmic scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy.utils.previews

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

WIDTH_PX, HEIGHT_PX = 128, 128
_BACKGROUND, _LINE = (0.11, 0.11, 0.11, 1.0), (0.95, 0.65, 0.2, 1.0)
#: Decades that the plot shows at least, so that a fit that hardly moves looks like one.
_LEAST_DECADES = 1.0

_icons: bpy.utils.previews.ImagePreviewCollection | None = None
_shown: list[float] = []


def plot_of(residuals: list[float]) -> int:
    """An icon for ``template_icon``. Headless, icons have no number: all are 0."""
    if _icons is None:
        return 0
    picture = _icons.get("residuals") or _icons.new("residuals")
    if residuals != _shown:
        _shown[:] = residuals
        picture.image_size[:] = WIDTH_PX, HEIGHT_PX
        picture.image_pixels_float.foreach_set(drawn(residuals).ravel())
    return int(picture.icon_id)


def drawn(residuals: list[float]) -> NDArray[np.float32]:
    """(height, width, 4), rows bottom to top: the largest value at the top, a decade or more below it at the bottom."""
    import numpy as np  # Debian's Blender comes without: the add-on must load, and say so

    pixels = np.full((HEIGHT_PX, WIDTH_PX, 4), _BACKGROUND, np.float32)
    values = np.log10(np.maximum(np.array(residuals, np.float64), 1e-12))
    top = values.max()
    bottom = min(values.min(), top - _LEAST_DECADES)
    columns = np.arange(WIDTH_PX)
    steps = columns / (WIDTH_PX - 1) * (len(values) - 1)
    heights = (np.interp(steps, np.arange(len(values)), values) - bottom) / (top - bottom) * (HEIGHT_PX - 5) + 2
    before = np.concatenate((heights[:1], heights[:-1]))
    rows = np.arange(HEIGHT_PX)[:, None]
    is_line = (rows >= np.minimum(heights, before) - 1.0) & (rows <= np.maximum(heights, before) + 1.0)
    pixels[is_line] = _LINE
    return pixels


def register() -> None:
    global _icons  # noqa: PLW0603  one per registration of the add-on
    _icons = bpy.utils.previews.new()


def unregister() -> None:
    global _icons  # noqa: PLW0603
    bpy.utils.previews.remove(_icons)
    _icons = None
    _shown.clear()
