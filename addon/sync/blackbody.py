# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of a glowing body, for Blackbody nodes and the flames of a Principled Volume.

Based on: Planck's law; the CIE 1931 standard observer.
Differs:  Cycles uses a rational fit to the same curve.
Bound:    81 wavelengths.
"""

from __future__ import annotations

import numpy as np

from tyndall.scene_description import Rgb

from .cie_1931 import FIRST_NM, LAST_NM, matching_functions

COLDEST_K, HOTTEST_K = 800.0, 12000.0  #: Beyond which colours stay as they are.
_REC709_FROM_XYZ = np.array(
    ((3.2404542, -1.5371385, -0.4985314), (-0.9692660, 1.8760108, 0.0415560), (0.0556434, -0.2040259, 1.0572252))
)
_SECOND_RADIATION_CONSTANT_NM_K = 1.438776877e7


def blackbody(temperature_k: float) -> Rgb:
    """Linear Rec. 709 of luminance 1; from 800 to 12,000 K, as in Cycles; may leave the gamut below 1,900 K."""
    kelvin = min(max(temperature_k, COLDEST_K), HOTTEST_K)
    matching = matching_functions()
    wavelengths_nm = np.linspace(FIRST_NM, LAST_NM, len(matching))
    ratio = _SECOND_RADIATION_CONSTANT_NM_K / (wavelengths_nm * kelvin)
    xyz = ((wavelengths_nm / 560.0) ** -5.0 / np.expm1(ratio)) @ matching
    red, green, blue = _REC709_FROM_XYZ @ (xyz / xyz[1])
    return float(red), float(green), float(blue)
