# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air inside of its painted box, baked into one volume: what painting, noise and wind amount to."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from . import _native
from .native_heterogeneity import KeptAir

if TYPE_CHECKING:
    from .air_tiles import Resolution
    from .heterogeneity import Heterogeneity
    from .scene_description import FloatArray


def bake_air(heterogeneity: Heterogeneity, resolution: Resolution, progress: _native.Progress) -> FloatArray:
    """I(x) (a(x) N(x, f(x)) / mean(N) + 1 - a(x)), float32 (nz, ny, nx), at the voxels' centres.

    Without ``heterogeneity.intensity``, which goes on to multiply it. With ``intensity`` of the box painted so, its
    ``amount`` -1 and its ``level`` neutral, the air is the same at the voxels' centres, where noise is no finer than
    the voxels, at that moment. Raises ``InvalidInput``: nothing to bake in, or what is painted cannot be used.
    """
    if heterogeneity.painted is None:
        raise _native.InvalidInput("there is no painted box to bake the air in")
    centre_m = np.array(heterogeneity.painted.world_from_unit) @ [0.5, 0.5, 0.5, 1.0]
    reports: list[str] = []
    native = KeptAir().build(replace(heterogeneity, intensity=1.0), centre_m[:3], reports)
    if reports or native is None:
        raise _native.InvalidInput("; ".join(reports))
    values: FloatArray = native.baked(resolution, progress)
    return values
