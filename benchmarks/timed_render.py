# SPDX-License-Identifier: GPL-3.0-or-later
"""A render as F12 makes it, and the processor's time that it took."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.cycles_reference import rendered_pixels


def timed_pixels(scene: bpy.types.Scene) -> tuple[NDArray[np.float64], float]:
    """The picture, and the CPU seconds of all threads."""
    begin = time.process_time()
    picture = rendered_pixels(scene)
    return picture, time.process_time() - begin
