# SPDX-License-Identifier: GPL-3.0-or-later
"""Phase functions of scatter nodes as sums of Draine's.

Based on: Draine, Scattering by Interstellar Dust Grains I, Astrophysical Journal 598, 2003; Jendersie and d'Eon, An
Approximate Mie Scattering Function for Fog and Cloud Rendering, SIGGRAPH Talks 2023, with its supplemental; Fournier
and Jonasz, Computer-based Underwater Imaging Analysis, SPIE 3761, 1999, by the share of light that goes back (Mobley,
Sundman and Boss, Applied Optics 41, 2002, eq. 3).
Differs: Fournier and Forand's is fitted by lobes each half as wide as the one before (Lawson and Hanson, Solving Least
Squares Problems, 1974, chapter 23): of a backscatter of a hundredth and more within 2 % in the mean of the angles from
a fifth of a degree on, and 5 % at any. What it sends closer to straight on than that is taken for absorbed: only a
light itself is seen there.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_LARGEST_ASYMMETRY = 0.999  #: Cycles, too, keeps away from the limit, at which all light goes straight on.
_LARGEST_ALPHA = 1e6  #: All is the squared cosine by then.
_LEAST_SHARE = 1e-6  #: Of a lobe that counts.
_MIE_DIAMETERS_UM = (0.1, 1.5, 5.0)  #: Between which other fits hold.


class Phase(NamedTuple):
    """Draine's function, which without an alpha is Henyey and Greenstein's."""

    asymmetry_g: float
    draine_alpha: float = 0.0


#: Of the light that is scattered, how much by which function.
Shares = tuple[tuple[float, Phase], ...]


def draine(asymmetry_g: float, alpha: float = 0.0) -> Shares:
    """Of any asymmetry."""
    asymmetry_g = min(max(asymmetry_g, -_LARGEST_ASYMMETRY), _LARGEST_ASYMMETRY)
    return ((1.0, Phase(asymmetry_g, min(max(alpha, 0.0), _LARGEST_ALPHA))),)


RAYLEIGH = draine(0.0, 1.0)


def mie(diameter_um: float) -> Shares:
    """Of drops of water."""
    forward_g, draine_g, alpha, share = _mie_parameters(max(diameter_um, 0.0))
    ((_, forward),), ((_, broad),) = draine(forward_g), draine(draine_g, alpha)
    return (1.0 - share, forward), (share, broad)


def _mie_parameters(d: float) -> tuple[float, float, float, float]:
    """Henyey and Greenstein's asymmetry, Draine's, his alpha and his share. Equations of the supplemental."""
    smallest, small, middle = _MIE_DIAMETERS_UM
    if d <= smallest:  # 11 to 14
        return 13.8 * d * d, 1.1456 * d * math.sin(9.29044 * d), 250.0, 0.252977 - 312.983 * d**4.3
    log_d = math.log(d)
    if d < small:  # 15 to 18
        turn = (log_d - 0.238604) * (log_d + 1.00667) / (0.507522 - 0.15677 * log_d)
        draine_g = 0.379685 * math.cos(1.19692 * math.cos(turn) + 1.37932 * log_d + 0.0625835) + 0.344213
        share = 0.146209 * math.cos(3.38707 * log_d + 2.11193) + 0.316072 + 0.0778917 * log_d
        return 0.862 - 0.143 * log_d**2, draine_g, 250.0, share
    if d < middle:  # 19 to 22
        twice = math.log(log_d)
        draine_g = 0.500411 - 0.081287 / (-2.0 * log_d + math.tan(log_d) + 1.27551)
        share = 0.026914 * (log_d - math.cos(5.68947 * (twice - 0.0292149))) + 0.3764
        return 0.0604931 * twice + 0.940256, draine_g, 7.30354 * log_d + 6.31675, share
    forward_g = math.exp(-0.0990567 / (d - 1.67154))  # 7 to 10
    draine_g = math.exp(-2.20679 / (d + 3.91029) - 0.428934)
    return (
        forward_g,
        draine_g,
        math.exp(3.62489 - 8.29288 / (d + 5.52825)),
        math.exp(-0.599085 / (d - 0.641583) - 0.665888),
    )


@lru_cache(maxsize=64)
def fournier_forand(backscatter: float, ior: float) -> Shares:
    """``backscatter``: of the light, what goes back. Shares of a sum of 1 at most; none where all goes straight on."""
    cosine = np.cos(np.radians(np.concatenate([np.geomspace(0.2, 5.0, 60), np.linspace(5.0, 179.5, 200)])))
    wanted = _fournier_forand_per_sr(cosine, min(abs(backscatter), 0.499), max(ior, 1.001))
    if not (np.isfinite(wanted).all() and wanted.min() > 0.0):
        return ()
    forward = [Phase(1.0 - 0.5**halvings) for halvings in range(12)]
    phases = [*forward, Phase(-0.3), Phase(0.0, 20.0), Phase(-0.3, 20.0)]
    relative = np.stack([_draine_per_sr(cosine, phase) for phase in phases], axis=1) / wanted[:, np.newaxis]
    shares = _not_negative_least_squares(relative, np.ones(len(wanted)))
    if shares.sum() > 1.0:  # more light than there is: then 1 in all counts for as much as a hundred angles
        relative = np.vstack([relative, np.full(len(phases), 100.0)])
        shares = _not_negative_least_squares(relative, np.append(np.ones(len(wanted)), 100.0))
        shares /= max(shares.sum(), 1.0)
    return tuple((float(share), phase) for share, phase in zip(shares, phases, strict=True) if share > _LEAST_SHARE)


def _fournier_forand_per_sr(cosine: Floats, backscatter: float, ior: float) -> Floats:
    def delta(half_sine2: Floats | float) -> Floats:
        return np.asarray(4.0 * half_sine2 / (3.0 * (ior - 1.0) ** 2))

    half_sine2 = 0.5 * (1.0 - cosine)
    with np.errstate(all="ignore"):  # told by what comes of it
        v = -np.log(2.0 * backscatter * (delta(0.5) - 1.0) + 1.0) / np.log(delta(0.5))
        d = delta(half_sine2)
        power, rest = d**v, 1.0 - d
        main = v * rest - (1.0 - power) + (d * (1.0 - power) - v * rest) / half_sine2
        back = (delta(1.0) ** -v - 1.0) / (delta(1.0) - 1.0) * (3.0 * cosine**2 - 1.0)
        return np.asarray(main / (4.0 * np.pi * rest**2 * power) + back / (16.0 * np.pi))


def _draine_per_sr(cosine: Floats, phase: Phase) -> Floats:
    g, alpha = phase
    base = (1.0 - abs(g)) ** 2 + 2.0 * abs(g) * (1.0 - math.copysign(1.0, g) * cosine)
    total = 4.0 * np.pi * (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0)
    return np.asarray((1.0 - g * g) * (1.0 + alpha * cosine**2) / (total * base**1.5))


def _not_negative_least_squares(a: Floats, b: Floats) -> Floats:
    """Of ``a @ x = b``."""
    x, rounding = np.zeros(a.shape[1]), 1e-12
    is_free = np.zeros(len(x), bool)
    for _ in range(10 * len(x)):
        gain = np.where(is_free, 0.0, a.T @ (b - a @ x))
        if gain.max() <= rounding:
            break
        is_free[gain.argmax()] = True
        while True:
            best = np.zeros(len(x))
            best[is_free] = np.linalg.lstsq(a[:, is_free], b, rcond=None)[0]
            is_below = is_free & (best <= 0.0)
            if not is_below.any():
                break
            way = (x[is_below] / (x[is_below] - best[is_below])).min()
            x = x + way * (best - x)
            is_free &= x > rounding
        x = best
    return x
