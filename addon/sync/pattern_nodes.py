# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that draw patterns: what they pack into the registers of an operation is told in shading/op_patterns.hpp."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import Code

from .domains import MID_GREY, Domain
from .program import BLACK, Value
from .texture_mapping import mapped

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .value_nodes import ValueReader

_FRACTALS = ("MULTIFRACTAL", "FBM", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN")
_GRADIENTS = ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "RADIAL", "QUADRATIC_SPHERE", "SPHERICAL")
_FEATURES = ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS")
_METRICS = ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")
_VORONOI_OUTPUTS = {"Distance": 0, "Radius": 0, "Color": 1, "Position": 2, "W": 3}
_PROFILES = ("SIN", "SAW", "TRI")
_PERMUTED_POINTS, _NOTHING_FAR = 8, 16  #: Of Voronoi's selector.


def _vector(reader: ValueReader, at: Socket) -> Value:
    return mapped(reader, at, reader.vector(at.input("Vector")))


def _packed(reader: ValueReader, at: Socket, *inputs: tuple[str, float]) -> Value:
    """Up to three numbers in one register; a version or kind without that input has the number beside it."""
    numbers = [reader.number(at.input(name), default) for name, default in inputs]
    return reader.program.combine([*numbers, BLACK, BLACK][:3])


def _dimensions(kind: str) -> int:
    """Less one."""
    return int(kind[0]) - 1


def _noise(reader: ValueReader, at: Socket) -> Value:
    node, program = at.node, reader.program
    fractal = getattr(node, "noise_type", "FBM")
    is_normalized = getattr(node, "normalize", True)
    roughness = reader.number(at.input("Roughness"), 0.5)
    if bpy.app.version < (4, 0):
        roughness = program.clamp(roughness)
    lacunarity, distortion = reader.number(at.input("Lacunarity"), 2.0), reader.number(at.input("Distortion"))
    return program.operation(
        Code.NOISE,
        _vector(reader, at),
        _packed(reader, at, ("W", 0.0), ("Scale", 5.0), ("Detail", 2.0)),
        program.combine([roughness, lacunarity, distortion]),
        _packed(reader, at, ("Offset", 0.0), ("Gain", 1.0)),
        option=_dimensions(node.noise_dimensions) | _FRACTALS.index(fractal) << 2 | is_normalized << 5,
        selector=1 if at.socket.identifier == "Color" else 0,
    )


def _musgrave(reader: ValueReader, at: Socket) -> Value:
    node = at.node
    return reader.program.operation(
        Code.MUSGRAVE,
        _vector(reader, at),
        _packed(reader, at, ("W", 0.0), ("Scale", 5.0), ("Detail", 2.0)),
        _packed(reader, at, ("Dimension", 2.0), ("Lacunarity", 2.0), ("Offset", 0.0)),
        _packed(reader, at, ("Gain", 1.0)),
        option=_dimensions(node.musgrave_dimensions) | _FRACTALS.index(node.musgrave_type) << 2,
    )


def _voronoi(reader: ValueReader, at: Socket) -> Value:
    node = at.node
    feature, metric = _FEATURES.index(node.feature), _METRICS.index(node.distance)
    is_normalized = getattr(node, "normalize", False)
    version = (_PERMUTED_POINTS if bpy.app.version >= (5, 0) else 0) | (_NOTHING_FAR if bpy.app.version < (4, 0) else 0)
    return reader.program.operation(
        Code.VORONOI,
        _vector(reader, at),
        _packed(reader, at, ("W", 0.0), ("Scale", 5.0), ("Randomness", 1.0)),
        _packed(reader, at, ("Smoothness", 1.0), ("Exponent", 0.5), ("Detail", 0.0)),
        _packed(reader, at, ("Roughness", 0.5), ("Lacunarity", 2.0)),
        option=_dimensions(node.voronoi_dimensions) | feature << 2 | metric << 5 | is_normalized << 7,
        selector=_VORONOI_OUTPUTS[at.socket.identifier] | version,
    )


def _wave(reader: ValueReader, at: Socket) -> Value:
    node = at.node
    is_rings = node.wave_type == "RINGS"
    direction = node.rings_direction if is_rings else node.bands_direction
    axis = "XYZ".index(direction) if direction in "XYZ" else 3
    return reader.program.operation(
        Code.WAVE,
        _vector(reader, at),
        _packed(reader, at, ("Scale", 5.0), ("Distortion", 0.0), ("Detail", 2.0)),
        _packed(reader, at, ("Detail Scale", 1.0), ("Detail Roughness", 0.5), ("Phase Offset", 0.0)),
        option=is_rings | axis << 1 | _PROFILES.index(node.wave_profile) << 3,
    )


def _magic(reader: ValueReader, at: Socket) -> Value:
    return reader.program.operation(
        Code.MAGIC,
        _vector(reader, at),
        _packed(reader, at, ("Scale", 5.0), ("Distortion", 1.0)),
        option=at.node.turbulence_depth,
        selector=1 if at.socket.identifier == "Fac" else 0,
    )


def _gradient(reader: ValueReader, at: Socket) -> Value:
    kind = _GRADIENTS.index(at.node.gradient_type)
    return reader.program.operation(Code.GRADIENT, _vector(reader, at), option=kind)


def _checker(reader: ValueReader, at: Socket) -> Value:
    is_number = at.socket.identifier == "Fac"
    colours = [BLACK if is_number else reader.colour(at.input(name)) for name in ("Color1", "Color2")]
    return reader.program.operation(
        Code.CHECKER, _vector(reader, at), *colours, reader.number(at.input("Scale")), selector=int(is_number)
    )


def _brick(reader: ValueReader, at: Socket) -> Value:
    node, is_number = at.node, at.socket.identifier == "Fac"
    colours = [BLACK if is_number else reader.colour(at.input(name)) for name in ("Color1", "Color2", "Mortar")]
    return reader.program.operation(
        Code.BRICK,
        _vector(reader, at),
        *colours,
        _packed(reader, at, ("Scale", 5.0), ("Mortar Size", 0.02), ("Mortar Smooth", 0.1)),
        _packed(reader, at, ("Bias", 0.0), ("Brick Width", 0.5), ("Row Height", 0.25)),
        option=node.offset_frequency,
        selector=int(is_number),
        value=(node.offset, node.squash, float(node.squash_frequency)),
    )


def _white_noise(reader: ValueReader, at: Socket) -> Value:
    return reader.program.operation(
        Code.WHITE_NOISE,
        reader.vector(at.input("Vector")),
        reader.number(at.input("W")),
        option=_dimensions(at.node.noise_dimensions),
        selector=1 if at.socket.identifier == "Color" else 0,
    )


def _gabor(reader: ValueReader, at: Socket) -> Value:
    is_flat = at.node.gabor_type == "2D"
    direction = reader.number(at.input("Orientation 2D")) if is_flat else reader.vector(at.input("Orientation 3D"))
    return reader.program.operation(
        Code.GABOR,
        _vector(reader, at),
        _packed(reader, at, ("Scale", 5.0), ("Frequency", 2.0), ("Anisotropy", 1.0)),
        direction,
        option=0 if is_flat else 1,
        selector=("Value", "Phase", "Intensity").index(at.socket.identifier),
    )


def _drawn(draw: Callable[[ValueReader, Socket], Value]) -> Callable[[ValueReader, Socket], Value]:
    """Patterns need a place, which surfaces have."""

    def value(reader: ValueReader, at: Socket) -> Value:
        if reader.domain is not Domain.SURFACE:
            reader.unsupported(at, "is read as mid grey: patterns do not reach here")
            return MID_GREY
        return draw(reader, at)

    return value


NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "TEX_CHECKER": _drawn(_checker),
    "TEX_NOISE": _drawn(_noise),
    "TEX_VORONOI": _drawn(_voronoi),
    "TEX_WAVE": _drawn(_wave),
    "TEX_MAGIC": _drawn(_magic),
    "TEX_GRADIENT": _drawn(_gradient),
    "TEX_BRICK": _drawn(_brick),
    "TEX_MUSGRAVE": _drawn(_musgrave),
    "TEX_WHITE_NOISE": _drawn(_white_noise),
    "TEX_GABOR": _drawn(_gabor),
}
