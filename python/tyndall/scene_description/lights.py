# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps, their pictures, and the world."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arrays import Rgb
from .geometry import LightLinks
from .images import Image
from .materials import Material, TextureUse
from .occluder_edits import OccluderEdit


class LightKind(IntEnum):
    """Where a light sends its light from."""

    SUN = 0
    POINT = 1
    SPOT = 2
    AREA = 3


class SpotFalloff(IntEnum):
    """How a spot fades towards its cone, which changed between Blender 3 and 4."""

    BLENDER_3 = 0
    BLENDER_4 = 1


class LightBody(IntEnum):
    """The shape of a point or spot light that has a radius."""

    FACING_DISC = 0
    SPHERE = 1


class LightProjection(IntEnum):
    """How a place in a light's space becomes a place in the picture that colours it."""

    PLANAR = 0  #: Sun: across the light, in metres.
    DIRECT = 1  #: Its first two components.
    PERSPECTIVE = 2  #: Those divided by the third: how a slide is thrown.
    SPHERE = 3  #: Longitude and latitude, as Cycles' ``map_to_sphere``.
    EMITTER = 4  #: Area light: where the light leaves it; its box along its axes is (0, 0) to (1, 1).
    DIRECTIONS = 5  #: As SPHERE, of a picture whose rows are an angle apart, without a seam.


@dataclass(frozen=True, kw_only=True, eq=False)
class LightTexture:
    """A picture that colours the beam of a light: its strength is multiplied by ``offset + gain @ picture``.

    ``PLANAR``: ``width_m`` wide, upright along the light's axes, its middle ``centre_m`` along them from the line
    through the light's origin. ``EMITTER``: the place on an area light, (u, v, 1), times ``uv_from_projected``. Else,
    of the direction in which the light leaves, or of the normal of the sphere that emits it: the unit vector along
    ``axes_from_world @ vector``, extended by 1, times ``place_from_axes``, projected to (u, v), extended by 1, times
    ``uv_from_projected``.
    """

    use: TextureUse
    projection: LightProjection = LightProjection.PLANAR
    width_m: float = 10.0
    centre_m: tuple[float, float] = (0.0, 0.0)
    follows_normal: bool = False
    axes_from_world: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3)
    place_from_axes: NDArray[np.float64] = field(default_factory=lambda: np.eye(3, 4))  #: (3, 4)
    uv_from_projected: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3), affine.
    offset: Rgb = (0.0, 0.0, 0.0)
    gain: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3)
    #: Of lamps: times the distance d from where the light leaves to this power, 0 to 2, and d^2 / (d^2 + smooth_m2).
    distance_power: int = 0
    smooth_m2: float = 0.0


class LitKinds(NamedTuple):
    """The surfaces' shaders that an emitter lights."""

    diffuse: bool = True  #: Translucent ones, sheen and toon, too.
    glossy: bool = True
    transmission: bool = True  #: Hair's; and it shows through what bends rays.


_ALL_KINDS = LitKinds()


@dataclass(frozen=True, kw_only=True, eq=False)
class Light:
    """A light in radiometric units."""

    name: str
    kind: LightKind
    #: Sun: irradiance on a plane that faces it, W/m^2. Point and spot: radiant intensity, W/sr. Area: the same along
    #: its axis if it spread over half a turn, radiance times area; a pi-th of the watts that it sends, at any spread.
    strength: Rgb
    #: (4, 4); the light shines along its -Z; scale shapes a spot's cone and an area light's sides.
    world_from_light: NDArray[np.float64]
    half_angle_rad: float = 0.0  #: Sun: angular radius.
    radius_m: float = 0.0
    spot_half_angle_rad: float = 0.7
    spot_blend: float = 0.0
    spot_falloff: SpotFalloff = SpotFalloff.BLENDER_4
    body: LightBody = LightBody.SPHERE
    size_m: tuple[float, float] = (1.0, 1.0)  #: Area: along its X and Y, before the scale in its matrix; > 0.
    is_ellipse: bool = False  #: Area: an ellipse with these axes; else a rectangle.
    spread_rad: float = math.pi  #: Area: between the outermost directions in which it shines, [0, pi].
    casts_shadow: bool = True
    lights_surfaces: LitKinds = _ALL_KINDS
    #: Shadows of its light show on shadow catchers; else it only brightens what they show.
    lights_catchers: bool = True
    scatters_in_media: bool = True
    occluder_edits: tuple[OccluderEdit, ...] = ()  #: In the order in which they are made.
    texture: LightTexture | None = None  #: Colours its beam.
    light_group: str = ""  #: One of SceneDescription.light_groups, or none.
    links: LightLinks | None = None  #: Which objects it lights, and which block it; None: all.
    #: Into SceneDescription.media: one in which it scatters nothing, and one that only dims, as much as that does.
    unlit_media: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class World:
    """Radiance from infinity: a colour, times an equirectangular image if there is one."""

    name: str = "World"
    radiance: Rgb = (0.0, 0.0, 0.0)
    image: Image | None = None
    image_from_world: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3) rotation.
    seen_image: Image | None = None  #: What cameras see in place of the image, without its light.
    seen_program: Material | None = None  #: Or the emission of this: its points are directions.
    medium: int = -1  #: Into SceneDescription.media: fills all space; -1: none.
    lights_surfaces: LitKinds = _ALL_KINDS  #: What rays see of it is in the program.
    scatters_in_media: bool = True
    light_group: str = ""  #: One of SceneDescription.light_groups, or none.
