# SPDX-License-Identifier: GPL-3.0-or-later
"""What values may vary over, and what stands for one that cannot be had."""

from __future__ import annotations

from enum import Enum, auto

from .program import Value, grey

MID_GREY: Value = grey(0.5)  #: Stands for what cannot be evaluated.


class Domain(Enum):
    """What values may vary over."""

    SURFACE = auto()
    WORLD = auto()  #: Directions, and only through an environment texture.
    LIGHT = auto()  #: Directions, through images.
    CONSTANT = auto()  #: Media.
