# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface shaders as diffuse, transparent and emitted shares: the closures that this version draws.

A closure without a counterpart takes the nearest one and a note: reflections become diffuse, glass becomes transparent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .program import BLACK, WHITE, Value

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .value_nodes import ValueReader

_DIFFUSE_LIKE = {
    "BSDF_GLOSSY", "BSDF_ANISOTROPIC", "BSDF_METALLIC", "BSDF_VELVET", "BSDF_SHEEN", "BSDF_TOON", "BSDF_TRANSLUCENT",
    "BSDF_HAIR", "BSDF_HAIR_PRINCIPLED", "SUBSURFACE_SCATTERING", "EEVEE_SPECULAR",
}  # fmt: skip
_TRANSPARENT_LIKE = {"BSDF_GLASS", "BSDF_REFRACTION", "BSDF_RAY_PORTAL"}


@dataclass
class Shares:
    """What a surface does, each a colour: results of a surface program."""

    diffuse: Value = BLACK
    transparent: Value = BLACK
    emission: Value = BLACK


def read_surface(reader: ValueReader, at: Socket) -> Shares:
    """``at`` is the Surface input of an output node."""
    shares = Shares()
    _add(reader, at, WHITE, shares)
    return shares


def _add(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    """Adds the shader that feeds an input to the shares, times ``weight``."""
    if weight == BLACK:
        return
    source = at.source()
    if not source.socket.is_output:
        return  # nothing connected: black
    if source.socket.type != "SHADER":  # a colour in place of a shader glows, as in Cycles
        program = reader.program
        shares.emission = program.add(shares.emission, program.multiply(weight, reader.colour(at)))
        return
    node_type = source.node.type
    if node_type in _SHADERS:
        _SHADERS[node_type](reader, source, weight, shares)
    elif node_type in _TRANSPARENT_LIKE:
        reader.unsupported(source, "is drawn as transparent in its colour")
        _transparent(reader, source, weight, shares)
    elif node_type in _DIFFUSE_LIKE:
        reader.unsupported(source, "is drawn as diffuse in its colour")
        _diffuse(reader, source, weight, shares)
    elif node_type == "HOLDOUT":
        reader.unsupported(source, "is drawn black")
    else:
        reader.unsupported(source, "is not supported: drawn as grey diffuse")
        shares.diffuse = reader.program.add(shares.diffuse, reader.program.multiply(weight, (0.8, 0.8, 0.8)))


def _colour_of(reader: ValueReader, at: Socket) -> Value:
    return reader.colour(at.input("Color") or at.input("Base Color"), (0.8, 0.8, 0.8))


def _note_bumps(reader: ValueReader, at: Socket) -> None:
    normal = at.input("Normal")
    if normal is not None and normal.is_connected():
        reader.note("normal maps and bumps are not drawn")


def _diffuse(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    if at.node.type == "BSDF_DIFFUSE" and reader.constant(at.input("Roughness")) > 0.0:
        reader.note("the roughness of a diffuse surface is not drawn")
    _note_bumps(reader, at)
    program = reader.program
    shares.diffuse = program.add(shares.diffuse, program.multiply(weight, _colour_of(reader, at)))


def _transparent(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    program = reader.program
    shares.transparent = program.add(shares.transparent, program.multiply(weight, _colour_of(reader, at)))


def _emission(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    program = reader.program
    radiance = program.multiply(reader.colour(at.input("Color")), reader.number(at.input("Strength"), 1.0))
    shares.emission = program.add(shares.emission, program.multiply(weight, radiance))


def _principled(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    """Alpha cuts everything, emission too, as in Cycles. Metal and gloss are diffuse, transmission is transparent."""
    program = reader.program
    alpha = program.clamp(reader.number(at.input("Alpha"), 1.0))
    shares.transparent = program.add(shares.transparent, program.multiply(weight, program.complement(alpha)))
    weight = program.multiply(weight, alpha)
    _note_bumps(reader, at)

    emission = at.input("Emission Color") or at.input("Emission")  # renamed in 4.0
    radiance = program.multiply(reader.colour(emission), reader.number(at.input("Emission Strength"), 1.0))
    shares.emission = program.add(shares.emission, program.multiply(weight, radiance))

    base = reader.colour(at.input("Base Color"))
    metallic = program.clamp(reader.number(at.input("Metallic")))
    if metallic != BLACK:
        reader.note("metal is drawn as diffuse in its colour")
    transmission = program.clamp(reader.number(at.input("Transmission Weight") or at.input("Transmission")))
    transmission = program.multiply(transmission, program.complement(metallic))
    if transmission != BLACK:
        reader.note("transmission is drawn as transparent in its colour")
    passing = program.multiply(weight, program.multiply(base, transmission))
    shares.transparent = program.add(shares.transparent, passing)
    scattering = program.multiply(weight, program.multiply(base, program.complement(transmission)))
    shares.diffuse = program.add(shares.diffuse, scattering)


def _mix_shader(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    share, first, second = at.inputs()[:3]
    program = reader.program
    share_of_second = program.clamp(reader.number(share))
    _add(reader, first, program.multiply(weight, program.complement(share_of_second)), shares)
    _add(reader, second, program.multiply(weight, share_of_second), shares)


def _add_shader(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    for shader in at.inputs()[:2]:
        _add(reader, shader, weight, shares)


_SHADERS: dict[str, Callable[[ValueReader, Socket, Value, Shares], None]] = {
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_TRANSPARENT": _transparent,
    "BSDF_PRINCIPLED": _principled,
    "EMISSION": _emission,
    "MIX_SHADER": _mix_shader,
    "ADD_SHADER": _add_shader,
}
