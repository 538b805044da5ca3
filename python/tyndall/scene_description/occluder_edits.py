# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist changes of the shadows in a light's shafts."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class EditKind(IntEnum):
    """What is done to the occluders before a light."""

    CLOSE = 0  #: Holes up to a size vanish.
    EPIPOLAR_CLOSE = 1  #: The same along the light's planes through the camera only: no halo in mid-air.
    SILHOUETTE = 2  #: Occluders grow away from the camera, behind what it sees of them.
    HOLES = 3  #: Thresholded Perlin noise.


class KernelShape(IntEnum):
    """Of the largest hole that CLOSE fills."""

    DISC = 0
    SQUARE = 1


@dataclass(frozen=True, kw_only=True)
class HoleNoise:
    """Perlin noise in the light's own metres; the native side checks the ranges."""

    scale_m: float = 1.0  #: Of its coarsest octave, (0, 1e6].
    octaves: int = 3  #: [1, 12]; each has twice the frequency of the one before.
    persistence: float = 0.5  #: [0, 1]: amplitude of an octave, of the one before.
    probability: float = 0.3  #: [0, 1]: share of holes.
    sway: float = 0.0  #: [0, 100]: how far the noise moves its own lookup, in units of scale_m; 0: none.
    turn_rad: float = 0.0  #: Turns the first lookup: over time, holes drift and change their form.
    seed: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class LightMask:
    """A picture in the light's space: an edit works where it is at least 1/2, and not outside of it.

    Sun: size_m wide, upright along the light's axes, its middle on the line through the light's origin. Spot: as wide
    as its cone. Point: all directions, equirectangular around the light's Z.
    """

    name: str
    values: NDArray[np.float32]  #: (height, width), rows bottom to top, [0, 1].
    size_m: float = 10.0


@dataclass(frozen=True, kw_only=True, eq=False)
class OccluderEdit:
    """An edit of what stands between a light and the air; surfaces see the occluders as they are, unless it says so."""

    name: str
    kind: EditKind
    shape: KernelShape = KernelShape.DISC  #: CLOSE.
    #: CLOSE: diameter of the largest holes that vanish. EPIPOLAR_CLOSE: their length. SILHOUETTE: by how much.
    size_m: float = 0.1
    distance_m: float = 5.0  #: Lamps: sizes are measured this far from the light, and grow with the distance.
    noise: HoleNoise = field(default_factory=HoleNoise)  #: HOLES.
    affects_surfaces: bool = False  #: Surfaces see what it does, too: light through holes, the shadows of the others.
    objects: tuple[str, ...] | None = None  #: Names of the objects that it means; None: all.
    mask: LightMask | None = None
