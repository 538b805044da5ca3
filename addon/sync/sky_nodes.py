# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky textures as values of a world's program: a picture of half the sky around the sun, or a formula.

Based on: Preetham, Shirley and Smits 1999, A Practical Analytic Model for Daylight; Hosek and Wilkie 2012, An Analytic
          Model for Full Spectral Sky-Dome Radiance; how blender/cycles v3.4.0, v4.5.0 and v5.0.0, kernel/svm/sky.h,
          look a direction up and draw the sun's disc.
Differs:  angles to the sun are taken from chords.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from mathutils import Vector

from tyndall.scene_description import Code, Extension, Image, TextureUse
from tyndall.skies import Air, SkyModel, sky_picture, sun_irradiance_xyz
from tyndall.surface_inputs import ImageProjection, PointInput

from .coordinates import point_input
from .hosek_sky import LOWEST_COSINE, coefficients
from .math_nodes import math_operation, vector_operation
from .program import BLACK, Program, Value, grey
from .texture_mapping import mapped
from .working_space import rgb_from_xyz

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .node_graph import Socket
    from .world_nodes import WorldReader

_IS_BLENDER_5 = bpy.app.version >= (5, 0, 0)
_MODELS = {
    "NISHITA": SkyModel.SINGLE_SCATTERING_3,
    "SINGLE_SCATTERING": SkyModel.SINGLE_SCATTERING,
    "MULTIPLE_SCATTERING": SkyModel.MULTIPLE_SCATTERING,
}
_LEAST_SUN_RAD = 0.0005  #: Cycles draws no smaller one.
_EARTH_RADIUS_M = {SkyModel.SINGLE_SCATTERING: 6371e3, SkyModel.MULTIPLE_SCATTERING: 6371e3}
_LOWEST_PREETHAM_RAD = 0.5 * math.pi - 0.001
#: Perez' five coefficients of luminance and of chromaticities x and y: per turbidity, and without.
_PEREZ = np.array(
    [
        [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
        [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
        [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
    ]
)
#: Chromaticities at the zenith: rows by powers 2, 1, 0 of the turbidity, columns by powers 3 to 0 of the sun's angle.
_ZENITH_X = np.array(
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]]
)
_ZENITH_Y = np.array(
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]]
)


@dataclass(frozen=True)
class SunDisc:
    """Of one node: where its Vector input has to point."""

    vector: Value
    towards: tuple[float, float, float]  #: Unit.
    half_angle_rad: float


class _Numbers:
    """What a node is set to, as Blender has it but finite, with a note."""

    def __init__(self, reader: WorldReader, node: bpy.types.Node) -> None:
        self._reader, self._node = reader, node

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  of numbers, vectors, switches and names
        value = getattr(self._node, name)
        if isinstance(value, float):
            return self._reader.finite(self._node, grey(value))[0]
        return self._reader.finite(self._node, (*value,)) if isinstance(value, Vector) else value


def sky_value(reader: WorldReader, at: Socket) -> Value:
    node, program = _Numbers(reader, at.node), reader.program
    place = at.input("Vector")
    is_linked = place is not None and place.is_connected()  # it is of use to some models only
    vector = reader.colour(place) if is_linked else point_input(program, PointInput.POSITION)
    vector = mapped(reader, at, vector)
    if node.sky_type in _MODELS:
        return _scattered(reader, node, vector)
    if node.sky_type == "HOSEK_WILKIE":
        return _hosek(program, vector, node)
    return _preetham(program, vector, node.sun_direction, node.turbidity)


def _scattered(reader: WorldReader, node: _Numbers, vector: Value) -> Value:
    program, model = reader.program, _MODELS[node.sky_type]
    air = Air(
        altitude_m=node.altitude,
        molecules=node.air_density,
        aerosols=node.aerosol_density if _IS_BLENDER_5 else node.dust_density,
        ozone=node.ozone_density,
    )
    elevation_rad, rotation_rad = _sun_angles(node)
    sine, cosine = math.sin(rotation_rad), math.cos(rotation_rad)
    # Along the sun's azimuth, across it, and up.
    local = program.operation(Code.AFFINE, vector, uv_matrix=(sine, cosine, 0.0, cosine, -sine, 0.0, 0.0, 0.0, 1.0))
    along, across, up = (program.channel(local, axis) for axis in range(3))
    elevation = math_operation(program, "ARCSINE", up)
    u = program.multiply(math_operation(program, "ARCTAN2", across, along), grey(0.5 / math.pi))
    root = math_operation(
        program, "SQRT", program.multiply(math_operation(program, "ABSOLUTE", elevation), grey(2.0 / math.pi))
    )
    v = program.multiply(program.multiply(math_operation(program, "SIGN", elevation), root), grey(0.5))
    place = program.add(program.combine([u, v, BLACK]), (0.5, 0.5, 0.0))
    use = TextureUse(image=_picture(model, air, elevation_rad), extension=Extension.EXTEND)
    sky = program.operation(Code.IMAGE_AT, place, option=int(ImageProjection.FLAT), texture=program.texture_index(use))
    size_rad = max(node.sun_size, _LEAST_SUN_RAD)
    if node.sun_disc and (elevation_rad + 0.5 * size_rad > 0.0 or model is SkyModel.MULTIPLE_SCATTERING):
        flat = math.cos(elevation_rad)
        towards = (sine * flat, cosine * flat, math.sin(elevation_rad))
        reader.discs.append(SunDisc(vector, towards, 0.5 * size_rad))
        if reader.draws_discs:
            angle = _angle_between(program, vector, towards)
            sky = _with_disc(program, sky, elevation, angle, _Disc(model, air, elevation_rad, size_rad, node))
    return vector_operation(program, "MAXIMUM", sky, BLACK)


def _sun_angles(node: _Numbers) -> tuple[float, float]:
    """Elevation, between -90 and 90 degrees, and rotation."""
    elevation = math.remainder(node.sun_elevation, 2.0 * math.pi)
    if abs(elevation) < 0.5 * math.pi:
        return elevation, node.sun_rotation
    return math.copysign(math.pi, elevation) - elevation, node.sun_rotation + math.pi


@lru_cache(maxsize=8)
def _picture(model: SkyModel, air: Air, sun_elevation_rad: float) -> Image:
    """2 MiB each: turning the sun, or the strength of its disc, takes no new one."""
    xyz = sky_picture(model, air, sun_elevation_rad)
    pixels = np.ones((*xyz.shape[:2], 4), np.float32)
    pixels[..., :3] = xyz @ rgb_from_xyz().T
    return Image(key=f"sky {model!r} {air!r} {sun_elevation_rad!r}", name="Sky Texture", pixels=pixels, is_srgb=False)


def _angle_between(program: Program, vector: Value, towards: tuple[float, float, float]) -> Value:
    """By the chord: a cosine would not tell small angles apart."""
    chord = vector_operation(program, "DISTANCE", vector_operation(program, "NORMALIZE", vector), towards)
    half = math_operation(program, "ARCSINE", program.multiply(chord, grey(0.5)))
    return program.multiply(half, grey(2.0))


class _Disc:
    """What Cycles draws it by: colours at its upper and lower end."""

    def __init__(self, model: SkyModel, air: Air, elevation_rad: float, size_rad: float, node: _Numbers) -> None:
        half_rad = 0.5 * size_rad
        self.size_rad, self.is_added = size_rad, model is not SkyModel.SINGLE_SCATTERING_3
        ends = np.array([elevation_rad - half_rad, elevation_rad + half_rad])
        if model is not SkyModel.MULTIPLE_SCATTERING:
            ends = np.maximum(ends, 0.0)
        solid_angle_sr = 2.0 * math.pi * (1.0 - math.cos(half_rad))
        lower, upper = (
            rgb_from_xyz() @ sun_irradiance_xyz(model, air, float(end)) * node.sun_intensity / solid_angle_sr
            for end in ends
        )
        self.lower, self.difference = _rgb(lower), _rgb(upper - lower)
        self.low_rad = elevation_rad - half_rad
        self.span_rad = size_rad
        self.horizon_rad = 0.0
        if model in _EARTH_RADIUS_M:
            radius_m = _EARTH_RADIUS_M[model]
            self.horizon_rad = math.asin(radius_m / (radius_m + air.altitude_m)) - 0.5 * math.pi
        elif self.low_rad <= 0.0:
            self.low_rad, self.span_rad = 0.0, elevation_rad + half_rad


def _with_disc(program: Program, sky: Value, elevation: Value, angle: Value, disc: _Disc) -> Value:
    share = program.multiply(program.subtract(elevation, grey(disc.low_rad)), grey(1.0 / disc.span_rad))
    colour = program.add(disc.lower, program.multiply(share, disc.difference))
    across = program.multiply(angle, grey(2.0 / disc.size_rad))
    inward = program.subtract(grey(1.0), program.multiply(across, across))
    rim = math_operation(program, "SQRT", math_operation(program, "MAXIMUM", inward, BLACK))
    colour = program.multiply(colour, program.add(program.multiply(rim, grey(0.6)), grey(0.4)))  # a darker limb
    inside = program.multiply(
        math_operation(program, "LESS_THAN", angle, grey(0.5 * disc.size_rad)),
        program.complement(math_operation(program, "LESS_THAN", elevation, grey(disc.horizon_rad))),
    )
    if disc.is_added:
        return program.add(sky, program.multiply(inside, colour))
    return program.mix(sky, colour, inside)


def _preetham(program: Program, vector: Value, sun_direction: tuple[float, float, float], turbidity: float) -> Value:
    """In 1/16 of kcd/m^2 and thereabouts, as Cycles scales it."""
    towards = _unit(sun_direction)
    sun_rad = math.acos(min(1.0, max(-1.0, float(towards[2]))))
    of_sky = _PEREZ @ (turbidity, 1.0)  # (3, 5)
    scale = _zenith(turbidity, sun_rad) / _perez(of_sky, 1.0, sun_rad)
    # Towards the horizon and below it the sky stays as it is just above.
    up = vector_operation(program, "NORMALIZE", vector)
    cosine = math_operation(program, "MAXIMUM", program.channel(up, 2), grey(math.cos(_LOWEST_PREETHAM_RAD)))
    angle = _angle_between(program, vector, _rgb(towards))
    sun_cosine = math_operation(program, "COSINE", angle)
    a, b, c, d, e = (_rgb(of_sky[:, column]) for column in range(5))
    one_by_cosine = math_operation(program, "DIVIDE", grey(1.0), cosine)
    by_height = program.add(grey(1.0), program.multiply(a, _exp(program, program.multiply(one_by_cosine, b))))
    by_sun = program.add(program.multiply(c, _exp(program, program.multiply(angle, d))), grey(1.0))
    by_sun = program.add(by_sun, program.multiply(e, program.multiply(sun_cosine, sun_cosine)))
    luminance_x_y = program.multiply(program.multiply(by_height, by_sun), _rgb(scale))
    luminance, x, y = (program.channel(luminance_x_y, index) for index in range(3))
    per_y = math_operation(program, "DIVIDE", luminance, y)
    z = program.subtract(program.complement(x), y)
    return _rgb_from_xyz(program, program.combine([program.multiply(x, per_y), luminance, program.multiply(z, per_y)]))


def _hosek(program: Program, vector: Value, node: _Numbers) -> Value:
    """As hosek_sky.sky_xyz, in W/m^2; a sun below the horizon lies on it."""
    towards = _unit(node.sun_direction)
    towards[2] = max(towards[2], 0.0)
    towards = _unit(towards)
    elevation_deg = math.degrees(math.asin(min(1.0, towards[2])))
    found = coefficients(node.turbidity, node.ground_albedo, elevation_deg)
    a, b, c, d, e, f, g, _, i, radiance = (_rgb(row) for row in found)
    steepness, offset = _rgb(-2.0 * found[7]), _rgb(1.0 + found[7] ** 2)  # of H
    height = program.channel(vector_operation(program, "NORMALIZE", vector), 2)
    up = math_operation(program, "MAXIMUM", height, grey(LOWEST_COSINE))
    angle = _angle_between(program, vector, _rgb(towards))
    cosine = math_operation(program, "COSINE", angle)
    square = program.multiply(cosine, cosine)
    by_height = math_operation(program, "DIVIDE", grey(1.0), program.add(up, grey(0.01)))
    by_height = program.add(grey(1.0), program.multiply(a, _exp(program, program.multiply(by_height, b))))
    spread = program.add(offset, program.multiply(cosine, steepness))
    spread = program.multiply(spread, _each(program, "SQRT", spread))
    glow = vector_operation(program, "DIVIDE", program.add(grey(1.0), square), spread)
    shape = program.add(c, program.multiply(d, _exp(program, program.multiply(angle, e))))
    shape = program.add(shape, program.multiply(f, square))
    shape = program.add(shape, program.multiply(g, glow))
    shape = program.add(shape, program.multiply(i, math_operation(program, "SQRT", up)))
    return _rgb_from_xyz(program, program.multiply(program.multiply(by_height, shape), radiance))


def _rgb_from_xyz(program: Program, xyz: Value) -> Value:
    rows = tuple(float(number) for number in rgb_from_xyz().ravel())
    return vector_operation(program, "MAXIMUM", program.operation(Code.AFFINE, xyz, uv_matrix=rows), BLACK)


def _unit(direction: ArrayLike) -> NDArray[np.float64]:
    of_any_length = np.array(direction, np.float64)
    unit: NDArray[np.float64] = of_any_length / (np.linalg.norm(of_any_length) or 1.0)
    return unit


def _zenith(turbidity: float, sun_rad: float) -> NDArray[np.float64]:
    """Luminance and chromaticities there."""
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * sun_rad)
    luminance = 0.06 * ((4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192)
    turbidities, angles = turbidity ** np.arange(2, -1, -1), sun_rad ** np.arange(3, -1, -1)
    return np.array([luminance, turbidities @ _ZENITH_X @ angles, turbidities @ _ZENITH_Y @ angles])


def _perez(of_sky: NDArray[np.float64], cosine: float, sun_rad: float) -> NDArray[np.float64]:
    a, b, c, d, e = of_sky.T
    values: NDArray[np.float64] = (1.0 + a * np.exp(b / cosine)) * (
        1.0 + c * np.exp(d * sun_rad) + e * math.cos(sun_rad) ** 2
    )
    return values


def _exp(program: Program, exponents: Value) -> Value:
    return _each(program, "EXPONENT", exponents)


def _each(program: Program, operation: str, values: Value) -> Value:
    return program.combine([math_operation(program, operation, program.channel(values, index)) for index in range(3)])


def _rgb(values: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])
