# SPDX-License-Identifier: GPL-3.0-or-later
"""What a rendered viewport draws of a film: the picture, or a pass in its place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall.light_paths import COLOUR_OF, without_colour

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray


def planes_for(plane: str) -> frozenset[str]:
    """What a film must have for it beside the picture."""
    if plane == "Combined":
        return frozenset()
    return frozenset({plane, COLOUR_OF.get(plane, plane)})


def shown(planes: Mapping[str, NDArray[np.float32]], plane: str) -> NDArray[np.float32]:
    """What is drawn, (height, width, 4): a pass is opaque, and grey if it is one number."""
    values = planes[plane]
    if plane == "Combined":
        return values
    if plane in COLOUR_OF:
        values = without_colour(values, planes[COLOUR_OF[plane]])
    rgba = np.ones((*values.shape[:2], 4), np.float32)
    rgba[..., :3] = values
    return rgba
