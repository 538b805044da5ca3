# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of clear skies over a round Earth, computed on the native side."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

from . import _native

if TYPE_CHECKING:
    from numpy.typing import NDArray


class SkyModel(IntEnum):
    """Numbered as in native/shading/sky/sky_model.hpp."""

    SINGLE_SCATTERING_3 = 0  #: Blender up to 4.5.
    SINGLE_SCATTERING = 1
    MULTIPLE_SCATTERING = 2


@dataclass(frozen=True, kw_only=True)
class Air:
    """Densities are multiples of Earth's."""

    altitude_m: float = 0.0
    molecules: float = 1.0
    aerosols: float = 1.0
    ozone: float = 1.0


def sky_picture(model: SkyModel, air: Air, sun_elevation_rad: float) -> NDArray[np.float32]:
    """CIE XYZ radiance, (256, 512, 3); from row to row by the root of the elevation, the sun's side in the middle."""
    picture: NDArray[np.float32] = _native.sky_picture(
        int(model), air.altitude_m, air.molecules, air.aerosols, air.ozone, sun_elevation_rad, _native.Progress()
    )
    return picture


def sun_irradiance_xyz(model: SkyModel, air: Air, elevation_rad: float) -> NDArray[np.float64]:
    """Of a sun seen at this height through the air, on a plane that faces it, (3,)."""
    xyz = _native.sun_irradiance_xyz(int(model), air.altitude_m, air.molecules, air.aerosols, air.ozone, elevation_rad)
    return np.array(xyz)
