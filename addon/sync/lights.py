# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights in radiometric units, as the Cycles of the running version reads them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.emitter_programs import EmitterObject, EmitterPictures
from tyndall.scene_description import (
    Light,
    LightBody,
    LightKind,
    LightProjection,
    LitKinds,
    ObjectLighting,
    SpotFalloff,
)

from .area_light_nodes import emitter_of, emitter_texture, read_area_emission
from .lamp_nodes import lamp_at_distances, read_lamp_emission
from .light_nodes import at_distances
from .light_textures import read_gobo
from .random_numbers import as_unit_floats

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy.typing import NDArray

    from .images import ImageReader
    from .instances import Placement
    from .light_linking import LinkedMedia
    from .occluder_edits import OccluderEditReader
    from .reports import Reports

_IS_BLENDER_4 = bpy.app.version >= (4, 0, 0)
#: A point light of P watts sends them evenly into all directions; checked against Cycles in the tests.
_INTENSITY_PER_WATT = 1.0 / (4.0 * math.pi)
#: Of an area light in Cycles 3.x; and from where on it is none.
_LEAST_SPREAD_3_RAD, _NO_SPREAD_RAD = math.radians(1.0), 3.14159
#: Cosine between the sides of an area light from which on it is told that it is sheared.
_SHEAR = 1e-3


def read_lights(
    placement: Placement, edits: OccluderEditReader, images: ImageReader, pictures: EmitterPictures, reports: Reports
) -> Iterator[Light]:
    """One light per instance. One that no air scatters needs only those edits of its occluders that surfaces see."""
    thing, data = placement.source, placement.source.data
    if _is_portal(data):
        return
    name = placement.object_name
    strength = _strength(data)
    lit = LitKinds(thing.visible_diffuse, thing.visible_glossy, thing.visible_transmission)
    scatters_in_media = thing.visible_volume_scatter and data.tyndall.scatters_in_media
    occluder_edits = tuple(edit for edit in edits.read(data, name) if scatters_in_media or edit.affects_surfaces)
    radius_m = 0.0 if data.type in {"SUN", "AREA"} else data.shadow_soft_size
    lighting = placement.lighting or ObjectLighting()
    if data.type == "AREA":
        if thing.visible_camera:
            reports.add(f'Light "{name}"', "cameras do not see it: lights are not drawn")
        emission = read_area_emission(data, images, reports, f'Light "{name}"')
        for matrix, seen_as in zip(placement.world_from_object(), _objects(placement), strict=True):
            emitter = emitter_of(matrix, _size_m(data), seen_as, is_ellipse=_is_ellipse(data))
            picture = emission.on(emitter, pictures)
            if (light := _area_light(data, name, matrix, strength * picture.mean, reports)) is not None:
                yield replace(
                    light,
                    texture=at_distances(emitter_texture(picture, matrix), emission.distance, LightProjection.EMITTER),
                    casts_shadow=_casts_shadow(data),
                    lights_surfaces=lit,
                    lights_catchers=placement.is_shadow_catcher,
                    scatters_in_media=scatters_in_media,
                    occluder_edits=occluder_edits,
                    light_group=lighting.light_group,
                    links=lighting.links,
                )
        return
    lamp = read_lamp_emission(data, images, reports, f'Light "{name}"')
    for matrix, seen_as in zip(placement.world_from_object(), _objects(placement), strict=True):
        texture = read_gobo(data, images, reports, f'Light "{name}"', matrix)
        if texture is None or lamp.is_constant:
            colour, shown = lamp.on(matrix, seen_as, pictures)
            texture = texture or shown
        else:
            reports.add(f'Light "{name}"', "its gobo takes the place of its nodes' pattern")
            colour = np.ones(3)
        yield Light(
            name=name,
            kind=LightKind[data.type],
            strength=tuple(float(channel) for channel in strength * colour),
            world_from_light=matrix,
            half_angle_rad=data.angle / 2 if data.type == "SUN" else 0.0,
            radius_m=radius_m,
            spot_half_angle_rad=data.spot_size / 2 if data.type == "SPOT" else 0.0,
            spot_blend=data.spot_blend if data.type == "SPOT" else 0.0,
            spot_falloff=SpotFalloff.BLENDER_4 if _IS_BLENDER_4 else SpotFalloff.BLENDER_3,
            body=_body(data),
            casts_shadow=_casts_shadow(data),
            lights_surfaces=lit,
            lights_catchers=placement.is_shadow_catcher,
            scatters_in_media=scatters_in_media,
            occluder_edits=occluder_edits,
            texture=lamp_at_distances(texture, lamp),
            light_group=lighting.light_group,
            links=lighting.links,
        )


def _objects(placement: Placement) -> list[EmitterObject]:
    """What Object Info says of each instance."""
    return [
        EmitterObject(color=placement.color, pass_index=float(placement.pass_index), random=float(random))
        for random in as_unit_floats(placement.random_numbers)
    ]


def _area_light(
    data: bpy.types.AreaLight, name: str, matrix: NDArray[np.float64], strength: NDArray[np.float64], reports: Reports
) -> Light | None:
    """The same of an area light; ``strength`` is that of 1 m^2, if it grows with the area."""
    sides = matrix[:3, 0], matrix[:3, 1]
    lengths_m = [float(np.linalg.norm(side)) for side in sides]
    is_ellipse, size_m = _is_ellipse(data), _size_m(data)
    area_m2 = size_m[0] * size_m[1] * lengths_m[0] * lengths_m[1] * (math.pi / 4 if is_ellipse else 1.0)
    if not area_m2 > 0.0:
        reports.add(f'Light "{name}"', "left out: it has no area, and Cycles gives it no light")
        return None
    if abs(float(sides[0] @ sides[1])) > _SHEAR * lengths_m[0] * lengths_m[1]:
        reports.add(f'Light "{name}"', "its transform shears it: it shines as if its sides stood upright on each other")
    if not getattr(data, "normalize", True):
        strength = strength * area_m2
    return Light(
        name=name,
        kind=LightKind.AREA,
        strength=tuple(float(channel) for channel in strength),
        world_from_light=matrix,
        size_m=size_m,
        is_ellipse=is_ellipse,
        spread_rad=data.spread if _IS_BLENDER_4 else max(data.spread, _LEAST_SPREAD_3_RAD),
    )


def _is_ellipse(data: bpy.types.AreaLight) -> bool:
    return data.shape in {"DISK", "ELLIPSE"}


def _size_m(data: bpy.types.AreaLight) -> tuple[float, float]:
    """Before the object's scale."""
    return data.size, data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size


def _intensity_per_watt(data: bpy.types.AreaLight) -> float:
    """Along its axis. Up to 3.x Cycles sent only pi / 4 of an area light's watts, and more than that in narrow spreads.

    There it finds what a spread holds back as a difference in float32: 25 % of it is wrong at 1 degree, 3 % at 2.
    """
    if _IS_BLENDER_4:
        return 1.0 / math.pi
    spread = np.float32(max(data.spread, _LEAST_SPREAD_3_RAD))
    if spread >= _NO_SPREAD_RAD:
        return 0.25
    slats = np.float32(0.5) * (np.float32(math.pi) - spread)
    passing = np.float32(1.0) + (slats - np.float32(math.pi / 2)) * np.tan(slats)
    half = 0.5 * float(spread)
    return 0.25 * (1.0 - half / math.tan(half)) / float(passing)


def _strength(data: bpy.types.Light) -> NDArray[np.float64]:
    """Sun: irradiance, W/m^2; others: radiant intensity, W/sr. Without its nodes."""
    strength: NDArray[np.float64] = np.array(data.color) * data.energy
    if hasattr(data, "exposure"):  # from 4.5 on
        strength *= 2.0**data.exposure
        if data.use_temperature:
            strength *= np.array(data.temperature_color)
        if not data.normalize and data.type != "AREA":
            strength *= _emitting_measure(data)
    if data.type == "AREA":
        return np.multiply(strength, _intensity_per_watt(data))
    return np.multiply(strength, irradiance_share(data.angle / 2) if data.type == "SUN" else _INTENSITY_PER_WATT)


def _emitting_measure(data: bpy.types.Light) -> float:
    """What multiplies the strength of a light that is not normalised: its projected solid angle, or its area in m^2."""
    if data.type == "SUN":
        return math.pi * math.sin(min(data.angle / 2, math.pi / 2)) ** 2 or 1.0
    return 4.0 * (math.pi * data.shadow_soft_size**2 or 1.0)


def irradiance_share(half_angle_rad: float) -> float:
    """Cycles 3.x spreads a sun evenly over a disc at distance 1: the mean cosine over the disc is left."""
    cosine = math.cos(min(half_angle_rad, 1.57))
    return 1.0 if _IS_BLENDER_4 else 2.0 * cosine / (1.0 + cosine)


def _body(data: bpy.types.Light) -> LightBody:
    """4.0 made lights spheres; from 4.1 on, soft falloff, which is the default, brings the disc of 3.x back.

    A sun of 3.x is a disc, too: evenly bright by area, not by solid angle.
    """
    if _IS_BLENDER_4 and not getattr(data, "use_soft_falloff", False):
        return LightBody.SPHERE
    return LightBody.FACING_DISC


def _is_portal(data: bpy.types.Light) -> bool:
    """It shines nowhere: Cycles looks for the world through it."""
    return data.type == "AREA" and getattr(getattr(data, "cycles", None), "is_portal", False)


def _casts_shadow(data: bpy.types.Light) -> bool:
    if bpy.app.version >= (4, 2, 0):
        return data.use_shadow
    return data.cycles.cast_shadow if hasattr(data, "cycles") else True


def lights_of(
    placements: Iterable[Placement],
    edits: OccluderEditReader,
    media: LinkedMedia,
    images_and_pictures: tuple[ImageReader, EmitterPictures],
    reports: Reports,
) -> tuple[Light, ...]:
    """Those that are drawn, with the media that they do not light."""
    return tuple(
        replace(light, unlit_media=media.unlit_by(light.links)) if light.links is not None else light
        for placement in placements
        if placement.data is None
        for light in read_lights(placement, edits, *images_and_pictures, reports)
    )
