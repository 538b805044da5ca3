# SPDX-License-Identifier: GPL-3.0-or-later
"""Planes of light by what sends it to the camera, as Cycles shows them: without the colour of what sends it.

Films hold them with it, so that means of films and pictures put together of tiles are right.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: By the plane of light, that of its colour.
COLOUR_OF = {f"{kind}{part}": f"{kind}Col" for kind in ("Diff", "Gloss", "Trans") for part in ("Dir", "Ind")}


def is_light(plane: str) -> bool:
    """Whether it is radiance, which a film's exposure multiplies, as it does in Cycles; those of light groups are."""
    return (
        plane in {"Combined", "Emit", "Env", "Shafts"}
        or plane in COLOUR_OF
        or plane.startswith(("Combined_", "Shafts_"))
    )


def without_colour(light: NDArray[np.float32], colour: NDArray[np.float32]) -> NDArray[np.float32]:
    """(height, width, 3) both; where a channel has no colour, the mean of the others, as in Cycles."""
    has_colour = colour != 0
    without = np.divide(light, colour, out=np.zeros_like(light), where=has_colour)
    grey = without.sum(-1, keepdims=True) / np.maximum(has_colour.sum(-1, keepdims=True), np.float32(1))
    return np.where(has_colour, without, grey.astype(np.float32))
