# SPDX-License-Identifier: GPL-3.0-or-later
"""The discs of sky textures as suns: their light casts sharp shadows and shafts, cameras see them in the sky."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from mathutils import Vector

from tyndall.direction_programs import radiance_towards
from tyndall.scene_description import Light, LightKind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tyndall.scene_description import Material

_RINGS, _SPOKES = 48, 96


@dataclass(frozen=True)
class SkySun:
    """A disc as the world's nodes leave it."""

    name: str
    towards: tuple[float, float, float]  #: Unit, in the world.
    half_angle_rad: float
    irradiance: tuple[float, float, float]  #: W/m^2 on a plane that faces it.

    def light(self) -> Light:
        matrix = np.array(Vector(self.towards).to_track_quat("Z", "Y").to_matrix().to_4x4(), np.float64)
        return Light(
            name=self.name,
            kind=LightKind.SUN,
            strength=self.irradiance,
            world_from_light=matrix,
            half_angle_rad=self.half_angle_rad,
        )


def sky_sun(
    name: str, with_disc: Material, without: Material, towards: NDArray[np.float64], half_angle_rad: float
) -> SkySun | None:
    """The light that the disc adds, found on rings around its middle; None: the horizon, or the nodes, hide it."""
    towards = towards / np.linalg.norm(towards)
    around = Vector(towards).to_track_quat("Z", "Y").to_matrix()
    # Rings of equal solid angle: from the middle's height, 1, to the rim's.
    heights = 1.0 - (1.0 - math.cos(half_angle_rad)) * (np.arange(_RINGS) + 0.5) / _RINGS
    turns = 2.0 * math.pi * (np.arange(_SPOKES) + 0.5) / _SPOKES
    radii = np.sqrt(1.0 - heights**2)
    local = np.stack(
        [
            radii[:, None] * np.cos(turns),
            radii[:, None] * np.sin(turns),
            np.broadcast_to(heights[:, None], (_RINGS, _SPOKES)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    directions = local @ np.array(around, np.float64).T
    solid_angle_sr = 2.0 * math.pi * (1.0 - math.cos(half_angle_rad)) / len(directions)
    radiance = radiance_towards(with_disc, directions) - radiance_towards(without, directions)
    flux = radiance * solid_angle_sr
    middle = directions.T @ flux.mean(axis=1)
    if not np.linalg.norm(middle) > 0.0:
        return None
    middle /= np.linalg.norm(middle)
    irradiance = flux.T @ (directions @ middle)
    if not irradiance.max() > 0.0:
        return None
    return SkySun(name, _triple(middle), half_angle_rad, _triple(irradiance.clip(min=0.0)))


def _triple(values: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])
