# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights in radiometric units, as the Cycles of the running version reads them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.scene_description import Light, LightBody, LightKind, SpotFalloff

from .light_nodes import emission_of_light
from .light_textures import read_gobo

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from .images import ImageReader
    from .instances import Placement
    from .occluder_edits import OccluderEditReader
    from .reports import Reports

_IS_BLENDER_4 = bpy.app.version >= (4, 0, 0)
#: A point light of P watts sends them evenly into all directions; checked against Cycles in the tests.
_INTENSITY_PER_WATT = 1.0 / (4.0 * math.pi)


def read_lights(
    placement: Placement, edits: OccluderEditReader, images: ImageReader, reports: Reports
) -> Iterator[Light]:
    """One light per instance. One that no air scatters needs only those edits of its occluders that surfaces see."""
    thing, data = placement.source, placement.source.data
    name = placement.object_name
    if data.type == "AREA":
        reports.add(f'Light "{name}"', "left out: area lights are not supported yet")
        return
    if getattr(thing, "light_linking", None) and (
        thing.light_linking.receiver_collection or thing.light_linking.blocker_collection
    ):
        reports.add(f'Light "{name}"', "lights everything: light linking is not supported")
    colour, nodes = emission_of_light(data, images, reports, f'Light "{name}"')
    strength = _strength(data)
    if colour.texture is None:
        strength *= colour.offset
    scatters_in_media = thing.visible_volume_scatter and data.tyndall.scatters_in_media
    occluder_edits = tuple(edit for edit in edits.read(data, name) if scatters_in_media or edit.affects_surfaces)
    radius_m = 0.0 if data.type == "SUN" else data.shadow_soft_size
    for matrix in placement.world_from_object():
        texture = nodes.texture(colour, matrix)
        gobo = read_gobo(data, images, reports, f'Light "{name}"', matrix)
        if texture is not None and gobo is not None:
            reports.add(f'Light "{name}"', "its gobo takes the place of its nodes' image")
        yield Light(
            name=name,
            kind=LightKind[data.type],
            strength=tuple(float(channel) for channel in strength),
            world_from_light=matrix,
            half_angle_rad=data.angle / 2 if data.type == "SUN" else 0.0,
            radius_m=radius_m,
            spot_half_angle_rad=data.spot_size / 2 if data.type == "SPOT" else 0.0,
            spot_blend=data.spot_blend if data.type == "SPOT" else 0.0,
            spot_falloff=SpotFalloff.BLENDER_4 if _IS_BLENDER_4 else SpotFalloff.BLENDER_3,
            body=_body(data),
            casts_shadow=_casts_shadow(data),
            lights_surfaces=thing.visible_diffuse,
            scatters_in_media=scatters_in_media,
            occluder_edits=occluder_edits,
            texture=gobo or texture,
        )


def _strength(data: bpy.types.Light) -> NDArray[np.float64]:
    """Sun: irradiance, W/m^2; others: radiant intensity, W/sr. Without its nodes."""
    strength: NDArray[np.float64] = np.array(data.color) * data.energy
    if hasattr(data, "exposure"):  # from 4.5 on
        strength *= 2.0**data.exposure
        if data.use_temperature:
            strength *= np.array(data.temperature_color)
        if not data.normalize:
            strength *= _emitting_measure(data)
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


def _casts_shadow(data: bpy.types.Light) -> bool:
    if bpy.app.version >= (4, 2, 0):
        return data.use_shadow
    return data.cycles.cast_shadow if hasattr(data, "cycles") else True
