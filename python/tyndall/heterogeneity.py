# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air: noise and painted volumes that the light shafts are multiplied by (Kol 2018, 5.4.3).

``RenderConfig.heterogeneity`` takes it; native/volume/heterogeneity.hpp says what the numbers do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .scene_description import FloatArray

WEIGHTINGS = ("LIT_PARTS", "WHOLE_RAY")

Matrix = tuple[tuple[float, float, float, float], ...]

#: Of the noise's coarsest octave, along an edge of its cube.
_CELLS_PER_SIDE = 8


@dataclass(frozen=True, kw_only=True)
class AirNoise:
    """Perlin noise in a periodic cube that tiles space."""

    scale_m: float = 1.0  #: Size of its largest features, (0, 1e6].
    octaves: int = 5  #: [1, 8].
    persistence: float = 0.5  #: Weight of an octave relative to the one before, [0, 1].
    contrast: float = 1.0  #: 1: three deviations fill its range; higher ones cut what is beyond, [0, 10].
    resolution: int = 256  #: Texels per side of the cube, a power of two, [16, 512].
    seed: int = 0

    @property
    def periods_m(self) -> NDArray[np.float64]:
        """Float64 (3, 3), metres: moved by whole multiples of its rows, the noise is what it was.

        They are the edges of its cube, which lies askew in the scene: native/volume/air_texture.cpp.
        """
        return _CELLS_PER_SIDE * self.scale_m * _turned((0.0, 0.0, 1.0), 0.6) @ _turned((1.0, 2.0, 0.5), 0.8)


@dataclass(frozen=True, kw_only=True)
class PaintedAir:
    """What is painted inside a box; arrays are float32 ``(nz, ny, nx)``, None: nothing is. Told apart by its key."""

    key: str  #: Another one when any array changes.
    world_from_unit: Matrix  #: The box is [0, 1]^3 of it, metres.
    amount: FloatArray | None = field(default=None, compare=False)  #: Added to ``Heterogeneity.amount``, [-1, 1].
    level: FloatArray | None = field(default=None, compare=False)  #: Added to ``Heterogeneity.level``, [-8, 8].
    intensity: FloatArray | None = field(
        default=None, compare=False
    )  #: Multiplied with ``Heterogeneity.intensity``, [0, 1000].


@dataclass(frozen=True, kw_only=True)
class Heterogeneity:
    """How much more or less than a homogeneous medium each point of the air scatters; amount 0 changes no bit."""

    noise: AirNoise = field(default_factory=AirNoise)
    moved_m: tuple[float, float, float] = (0.0, 0.0, 0.0)  #: How far the wind has carried the noise.
    amount: float = 1.0  #: [0, 1]; 0: homogeneous.
    level: float = 0.0  #: Mip level of the noise, [0, 8]; higher ones are smoother.
    intensity: float = 1.0  #: [0, 1000].
    weighting: str = "LIT_PARTS"  #: One of WEIGHTINGS: mean over what is lit of a ray, or over all of it.
    step_count: int = 64  #: Per ray, [1, 4096].
    upsampling: int = 1  #: Pixels per side that share a ray's texture, guided by depth: 1, 2, 4, 8 or 16.
    painted: PaintedAir | None = None


def _turned(axis: tuple[float, float, float], angle_rad: float) -> NDArray[np.float64]:
    """Float64 (3, 3): the rotation about an axis (Rodrigues)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: NDArray[np.float64] = (
        np.eye(3) + math.sin(angle_rad) * across + (1.0 - math.cos(angle_rad)) * across @ across
    )
    return turned
