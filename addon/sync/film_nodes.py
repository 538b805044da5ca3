# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin films of Principled, Metallic and Glass shaders, and what channels see of their interference, by version.

Based on: Belcour and Barla, A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence, TOG
          36(4), 2017: the Fourier transform of an observer's sensitivity; four Gaussians for it, from its supplement.
Differs:  from 5.0 on the transform is that of the CIE's table itself, as in Cycles; a channel's sensitivity is that of
          the colours that Blender works in.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.scene_description import FilmSpectra

from .cie_1931 import FIRST_NM, LAST_NM, matching_functions
from .lobe_values import Film
from .program import BLACK
from .working_space import rgb_from_xyz

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .node_graph import Socket
    from .value_nodes import ValueReader

_IS_FITTED = bpy.app.version < (5, 0, 0)
_REACH_NM = 60000.0 / (2.0 * np.pi)  #: Beyond, an observer sees none of it, to 1e-3.
#: From 5.0 on as many as Cycles has, between which it is linear, too: up to half a percent of a wave's height.
_STEPS = 4096 if _IS_FITTED else 511
#: Over the wave number, X by two: which of X, Y and Z, height, and in 1 / m middle and variance.
_GAUSSIANS = (
    (0, 5.4856e-13, 1.6810e6, 4.3278e9),
    (0, 1.64408e-8 / np.sqrt(2 * np.pi * 4.5282e9), 2.2399e6, 4.5282e9),
    (1, 4.4201e-13, 1.7953e6, 9.3046e9),
    (2, 5.2481e-13, 2.2084e6, 6.6121e9),
)
_GAUSSIAN_SUM = 1.0685e-7


def film_of(reader: ValueReader, at: Socket) -> Film | None:
    """A shader's thin film."""
    thickness = reader.number(at.input("Thin Film Thickness"))
    if thickness == BLACK:
        return None
    return Film(spectra(), thickness, reader.number(at.input("Thin Film IOR"), 1.33))


@lru_cache(maxsize=1)
def spectra() -> FilmSpectra:
    """Of this Blender."""
    ways_nm = np.linspace(0.0, _REACH_NM, _STEPS + 1)
    waves = _fitted(ways_nm) if _IS_FITTED else _of_observer(ways_nm)
    seen = np.hstack([waves.real, -waves.imag]).astype(np.float32)
    return FilmSpectra(
        seen=seen, reach_nm=_REACH_NM, fades_below_nm=30.0 if _IS_FITTED else 1.0, covers_metals=not _IS_FITTED
    )


def _of_observer(ways_nm: NDArray[np.float64]) -> NDArray[np.complex128]:
    """(n, 3), 1 where there is no way."""
    matching = matching_functions()
    wavelengths_nm = np.linspace(FIRST_NM, LAST_NM, len(matching))
    waves: NDArray[np.complex128] = np.exp(-2j * np.pi * ways_nm[:, None] / wavelengths_nm) @ matching
    waves = waves @ rgb_from_xyz().T
    waves /= waves[0]
    return waves


def _fitted(ways_nm: NDArray[np.float64]) -> NDArray[np.complex128]:
    """The same of the Gaussians, whose white is that of the working space."""
    phase = 2.0 * np.pi * ways_nm * 1e-9
    xyz = np.zeros((len(ways_nm), 3), np.complex128)
    for axis, height, middle, variance in _GAUSSIANS:
        size = height * np.sqrt(2.0 * np.pi * variance) / _GAUSSIAN_SUM
        xyz[:, axis] += size * np.exp(-1j * middle * phase - variance * phase**2)
    xyz *= np.linalg.solve(rgb_from_xyz(), np.ones(3))
    waves: NDArray[np.complex128] = xyz @ rgb_from_xyz().T
    return waves
