# SPDX-License-Identifier: GPL-3.0-or-later
"""What scatters and absorbs between surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .arrays import Rgb

if TYPE_CHECKING:
    from tyndall.volumes import SparseGrid


@dataclass(frozen=True, kw_only=True, eq=False)
class ScatterLobe:
    """Scattering with one phase function: Draine's, which is Henyey and Greenstein's where its alpha is 0."""

    sigma_s_per_m: Rgb
    asymmetry_g: float = 0.0  #: (-1, 1); positive scatters forward.
    draine_alpha: float = 0.0  #: [0, 1e6]; with an asymmetry of 0, 1 is Rayleigh's.


@dataclass(frozen=True, kw_only=True, eq=False)
class Medium:
    """A participating medium: homogeneous in a mesh or in the world, and what a density of 1 is in a grid."""

    name: str
    lobes: tuple[ScatterLobe, ...] = ()
    sigma_a_per_m: Rgb = (0.0, 0.0, 0.0)
    emission_w_per_m3_sr: Rgb = (0.0, 0.0, 0.0)
    receiver_set: int = 0  #: As ObjectLighting's, of the objects that hold it.

    def sigma_t_per_m(self) -> Rgb:
        """Extinction coefficient."""
        red, green, blue = (
            absorbed + sum(lobe.sigma_s_per_m[channel] for lobe in self.lobes)
            for channel, absorbed in enumerate(self.sigma_a_per_m)
        )
        return red, green, blue


@dataclass(frozen=True, kw_only=True, eq=False)
class DensityGrid:
    """Densities in an object's space, trilinear between the centres of voxels; below 0 they are 0.

    Rays pass up to four of the same voxels together: the channels.
    """

    key: str
    grid: SparseGrid  #: Channel 0.
    further: tuple[SparseGrid, ...] = ()  #: Channels 1 to 3.


@dataclass(frozen=True, kw_only=True, eq=False)
class Volume:
    """A density grid in the scene. The coefficients and the emission of its medium are those at density 1."""

    name: str
    grid: DensityGrid
    world_from_object: NDArray[np.float64]  #: (4, 4), affine, may mirror.
    medium: int  #: Into SceneDescription.media.
    channel: int = 0  #: Of the grid.
    density_scale: float = 1.0  #: Multiplies the densities, [0, 1e9].
