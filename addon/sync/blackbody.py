# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of a glowing body, for Blackbody nodes and the flames of a Principled Volume.

Based on: Planck's law; Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
          Functions", JCGT 2(2), 2013, the multi-lobe fit.
Differs:  Cycles uses a rational fit to the same curve.
Bound:    81 wavelengths.
"""

from __future__ import annotations

import numpy as np

from tyndall.scene_description import Rgb

_WAVELENGTHS_NM = np.arange(380.0, 781.0, 5.0)
_SECOND_RADIATION_CONSTANT_NM_K = 1.438776877e7
_REC709_FROM_XYZ = np.array(
    ((3.2404542, -1.5371385, -0.4985314), (-0.9692660, 1.8760108, 0.0415560), (0.0556434, -0.2040259, 1.0572252))
)
#: Per curve: height, centre, and inverse widths below and above the centre, all in nm.
_LOBES = (
    ((0.362, 442.0, 0.0624, 0.0374), (1.056, 599.8, 0.0264, 0.0323), (-0.065, 501.1, 0.0490, 0.0382)),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)


def blackbody(temperature_k: float) -> Rgb:
    """Linear Rec. 709 of luminance 1; from 800 to 12,000 K, as in Cycles; may leave the gamut below 1,900 K."""
    kelvin = min(max(temperature_k, 800.0), 12000.0)
    ratio = _SECOND_RADIATION_CONSTANT_NM_K / (_WAVELENGTHS_NM * kelvin)
    radiance = (_WAVELENGTHS_NM / 560.0) ** -5.0 / np.expm1(ratio)
    xyz = np.array([sum(_lobe(*lobe) for lobe in curve) @ radiance for curve in _LOBES])
    red, green, blue = _REC709_FROM_XYZ @ (xyz / xyz[1])
    return float(red), float(green), float(blue)


def _lobe(height: float, centre_nm: float, below: float, above: float) -> np.ndarray:
    offset = _WAVELENGTHS_NM - centre_nm
    return height * np.exp(-0.5 * (offset * np.where(offset < 0.0, below, above)) ** 2)
