# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's colour management says of the colours that it renders in; versions differ in the fifth digit."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from mathutils import Color

from tyndall.scene_description import Rgb

_UNITS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@lru_cache(maxsize=1)
def luminance_weights() -> Rgb:
    """By which a colour becomes a number, where it is linked to one."""
    red, green, blue = (Color(unit).from_scene_linear_to_xyz_d65()[1] for unit in _UNITS)
    return red, green, blue


@lru_cache(maxsize=1)
def rgb_from_xyz() -> np.ndarray:
    """3x3."""
    return np.array([tuple(Color(unit).from_xyz_d65_to_scene_linear()) for unit in _UNITS]).T
