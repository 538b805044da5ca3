# SPDX-License-Identifier: GPL-3.0-or-later
"""The dominant light of an environment image as a sun, and the image without it.

Differs: what the sun takes is what it stands out by from a ring around it, texel by texel, and its irradiance is the
sum of just that: a surface that faces it receives as much from the sun and the rest as from the image. Its size is that
of the even disc with the same spread.
Bound: a few passes over the image's luminance, and one step per texel of the light's radius.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_Places = NDArray[np.intp]
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
#: Texels around the light that take part: what is interpolated or was resampled lies there.
_FRINGE_TEXELS = 2
_RING_TEXELS = 3
#: On average, of the ring around it: clouds and gradients are no suns.
_LEAST_CONTRAST = 2.0
_WIDEST_HALF_ANGLE_RAD = np.pi / 4


class NoDominantLightError(ValueError):
    """The image has none; the message says why."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ImageSun:
    """What stands out of an environment image, in the image's space: u runs against longitude, v is latitude."""

    direction: NDArray[np.float64]  #: (3,): unit vector to its middle.
    irradiance: NDArray[np.float64]  #: (3,): W/m^2 on a plane that faces it, if radiances are those of the image.
    half_angle_rad: float  #: Of the even disc that is as spread out.
    texels: _Places  #: (n,): its texels in the flat image.
    surroundings: NDArray[np.float32]  #: (n, 3): the radiances that are left there.


def find_sun(colours: NDArray[np.float32], threshold: float = 0.5) -> ImageSun:
    """The brightest light of an equirectangular image, rows bottom to top, (height, width, 3), scene-linear.

    It is what hangs together around the brightest texel and is brighter than a share ``threshold`` of the way from the
    image's mean to that texel, with a fringe. Raises :class:`NoDominantLightError`.
    """
    height, width, _ = colours.shape
    finite = np.nan_to_num(colours, nan=0.0, posinf=0.0, neginf=0.0)
    luminance = finite @ _LUMINANCE
    mean = float(np.average(luminance.mean(axis=1, dtype=np.float64), weights=_solid_angles(height, width)))
    peak_texel = int(luminance.argmax())
    peak = float(luminance.flat[peak_texel])
    if not peak > mean:
        raise NoDominantLightError("it is equally bright everywhere")
    light = _connected(luminance > mean + threshold * (peak - mean), peak_texel)
    texels = _dilated(light, _FRINGE_TEXELS, height, width)
    ring = np.setdiff1d(_dilated(texels, _RING_TEXELS, height, width), texels, assume_unique=True)
    flat = finite.reshape(-1, 3)
    if ring.size == 0:
        raise NoDominantLightError("what is bright fills all of it")
    around = np.median(flat[ring], axis=0)
    contrast = _mean_luminance(flat, light, height, width) / max(float(around @ _LUMINANCE), 1e-30)
    if contrast < _LEAST_CONTRAST:
        raise NoDominantLightError("nothing in it is twice as bright as what surrounds it")
    surroundings = np.minimum(flat[texels], around).astype(np.float32)
    return _measured(flat[texels].astype(np.float64) - surroundings, texels, surroundings, height, width)


def without_sun(colours: NDArray[np.float32], sun: ImageSun) -> NDArray[np.float32]:
    """A copy of the image whose sun is as bright as what surrounds it."""
    rest = np.array(colours, np.float32)
    rest.reshape(-1, 3)[sun.texels] = sun.surroundings
    return rest


def _measured(
    taken: NDArray[np.float64], texels: _Places, surroundings: NDArray[np.float32], height: int, width: int
) -> ImageSun:
    """``taken``: radiances, (n, 3)."""
    rows, columns = np.divmod(texels, width)
    latitude = ((rows + 0.5) / height - 0.5) * np.pi
    longitude = (0.5 - (columns + 0.5) / width) * 2 * np.pi
    directions = np.stack(
        [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], axis=1
    )
    flux = taken * _solid_angles(height, width)[rows][:, None]
    weight = flux @ _LUMINANCE
    middle = weight @ directions
    middle /= np.linalg.norm(middle)
    # Of an even disc of half angle a the mean of 1 - cos is (1 - cos a) / 2; a texel has a spread of its own.
    own = ((np.pi / height) ** 2 + (2 * np.pi / width * np.cos(latitude)) ** 2) / 24
    spread = float(np.average(0.5 * ((directions - middle) ** 2).sum(axis=1) + own, weights=weight))
    half_angle_rad = float(np.arccos(np.clip(1.0 - 2.0 * spread, -1.0, 1.0)))
    if half_angle_rad > _WIDEST_HALF_ANGLE_RAD:
        raise NoDominantLightError("what is bright in it is wider than a quarter of the sky")
    return ImageSun(
        direction=middle,
        irradiance=(directions @ middle) @ flux,
        half_angle_rad=half_angle_rad,
        texels=texels,
        surroundings=surroundings,
    )


def _solid_angles(height: int, width: int) -> NDArray[np.float64]:
    """Of a texel of each row, (height,)."""
    heights = np.sin((np.arange(height + 1) / height - 0.5) * np.pi)
    return np.diff(heights) * 2 * np.pi / width


def _mean_luminance(flat: NDArray[np.float32], texels: _Places, height: int, width: int) -> float:
    weights = _solid_angles(height, width)[texels // width]
    return float(np.average(flat[texels].astype(np.float64) @ _LUMINANCE, weights=weights))


def _neighbours(texels: _Places, height: int, width: int) -> _Places:
    """Those above, below and beside, each once; at a pole all texels touch."""
    rows, columns = np.divmod(texels, width)
    beside = [rows * width + (columns + step) % width for step in (-1, 1)]
    above = [np.clip(rows + step, 0, height - 1) * width + columns for step in (-1, 1)]
    found = np.concatenate([*beside, *above])
    for pole in (0, height - 1):
        if (rows == pole).any():
            found = np.concatenate([found, pole * width + np.arange(width)])
    return np.unique(found)


def _connected(is_bright: NDArray[np.bool_], first: int) -> _Places:
    """Bright texels that hang together with the first, rising."""
    height, width = is_bright.shape
    is_new = is_bright.reshape(-1).copy()
    frontier = np.array([first], np.intp)
    is_new[first] = False
    found = [frontier]
    while frontier.size:
        frontier = _neighbours(frontier, height, width)
        frontier = frontier[is_new[frontier]]
        is_new[frontier] = False
        found.append(frontier)
    return np.sort(np.concatenate(found))


def _dilated(texels: _Places, steps: int, height: int, width: int) -> _Places:
    """With all that are so many steps away, rising."""
    for _ in range(steps):
        texels = np.union1d(texels, _neighbours(texels, height, width))
    return texels
