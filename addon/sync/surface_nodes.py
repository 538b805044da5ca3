# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface shaders as diffuse, transparent and emitted shares: the closures that this version draws.

A closure without a counterpart takes the nearest one and a note: reflections become diffuse unless they are as sharp as
mirrors, and mirrors are asked for; glass becomes transparent, unless it is asked to bend what is seen through it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

from .bent_nodes import add_bent_transmission, bends_transmission, is_sharp, through_one_side
from .film_nodes import film_of
from .hair_nodes import principled_hair_colour
from .lobe_nodes import add_lobes
from .program import BLACK, WHITE, GlossValues, Value, grey
from .shader_limits import followed

if TYPE_CHECKING:
    from collections.abc import Callable

    from .lobe_values import LobeValues
    from .node_graph import Socket
    from .value_nodes import ValueReader

_DIFFUSE_LIKE = {
    "BSDF_VELVET", "BSDF_SHEEN", "BSDF_TOON", "BSDF_TRANSLUCENT",
    "BSDF_HAIR", "BSDF_HAIR_PRINCIPLED", "SUBSURFACE_SCATTERING", "EEVEE_SPECULAR",
}  # fmt: skip
_GREY = (0.8, 0.8, 0.8)
_GLOSSY = {"BSDF_GLOSSY", "BSDF_ANISOTROPIC", "BSDF_METALLIC"}
_CAN_MIRROR = {*_GLOSSY, "BSDF_PRINCIPLED"}
_OF_VOLUMES = {"VOLUME_ABSORPTION", "VOLUME_SCATTER", "PRINCIPLED_VOLUME", "VOLUME_COEFFICIENTS"}
_OPAQUE_GLASS = "glass is opaque on voxels, in its colour"
_MOST_PASSING = 1.001  #: Of light: above rounding.


@dataclass(frozen=True)
class SharpSurfaces:
    """What mirrors."""

    roughness: float  #: It is no rougher.
    bend: bool = False  #: Glass among it bends what is seen through it.


@dataclass
class Shares:
    """What a surface does, each a colour: results of a surface program."""

    diffuse: Value = BLACK
    transparent: Value = BLACK
    has_glass: bool = False  #: What is transparent is so in place of glass, at least in part.
    emission: Value = BLACK
    held_out: Value = BLACK
    gloss: GlossValues | None = None
    lobes: list[LobeValues] | None = None  #: None, on voxels: shaders with lobes take the nearest share.
    sharp: SharpSurfaces | None = None  #: What mirrors; None: nothing does.
    finish: Finish | None = None  #: What voxels keep; None: of other surfaces.


@dataclass
class Finish:
    """What scatters or bends light, summed up over closures by their share of the surface."""

    weight: Value = BLACK  #: Sum of the shares.
    colour: Value = BLACK
    roughness: Value = BLACK
    metallic: Value = BLACK
    reflectance: Value = BLACK  #: Of Blender's Specular: 0.5 reflects 4 % of what comes from ahead.


def read_surface(
    reader: ValueReader,
    at: Socket,
    sharp: SharpSurfaces | None = None,
    *,
    is_voxels: bool = False,
) -> Shares:
    """``at`` is the Surface input of an output node."""
    shares = Shares(
        sharp=sharp,
        lobes=None if is_voxels else [],
        finish=Finish() if is_voxels else None,
    )
    _add(reader, at, WHITE, shares)
    if isinstance(shares.transparent, tuple) and max(shares.transparent) > _MOST_PASSING:
        reader.note("lets more light through than meets it: all of it passes")
    return shares


@followed(otherwise=None)
def _add(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    """Adds the shader that feeds an input to the shares, times ``weight``."""
    if weight == BLACK:
        return
    source = at.source()
    if source.is_bare_shader():
        reader.note_left_out(at)
        return
    if source.socket.type != "SHADER":  # a colour in place of a shader glows, as in Cycles
        program = reader.program
        shares.emission = program.add(shares.emission, program.multiply(weight, reader.colour(at)))
        return
    node_type = source.node.type
    if node_type in _OF_VOLUMES:
        return  # on a surface they do nothing, as in Cycles
    if (
        shares.lobes is not None
        and not _is_mirror(reader, source, shares)
        and add_lobes(reader, source, weight, shares)
    ):
        return
    if node_type in _SHADERS:
        _SHADERS[node_type](reader, source, weight, shares)
    elif node_type in _DIFFUSE_LIKE:
        reader.unsupported(source, "is drawn as diffuse in its colour")
        _diffuse(reader, source, weight, shares)
    elif node_type == "HOLDOUT":
        shares.held_out = reader.program.add(shares.held_out, weight)
    else:
        reader.unsupported(source, "is not supported: drawn as grey diffuse")
        shares.diffuse = reader.program.add(shares.diffuse, reader.program.multiply(weight, _GREY))
        _add_finish(reader, shares, weight, _GREY)


def _is_mirror(reader: ValueReader, at: Socket, shares: Shares) -> bool:
    return at.node.type in _CAN_MIRROR and is_sharp(reader, at, shares)


def _colour_of(reader: ValueReader, at: Socket) -> Value:
    if at.node.type == "BSDF_HAIR_PRINCIPLED":
        return principled_hair_colour(reader, at)
    return reader.colour(at.input("Color") or at.input("Base Color"), _GREY)


def _note_bumps(reader: ValueReader, at: Socket) -> None:
    normal = at.input("Normal")
    if normal is not None and normal.is_connected() and reader.normal(normal) is not None:
        reader.note(f"normal maps and bumps of {at.node.bl_label} are not drawn here")


def _add_finish(
    reader: ValueReader,
    shares: Shares,
    weight: Value,
    colour: Value,
    roughness: Value = WHITE,
    metallic: Value = BLACK,
    reflectance: Value = BLACK,
) -> None:
    finish, program = shares.finish, reader.program
    if finish is None:
        return
    finish.weight = program.add(finish.weight, weight)
    finish.colour = program.add(finish.colour, program.multiply(weight, colour))
    finish.roughness = program.add(finish.roughness, program.multiply(weight, program.clamp(roughness)))
    finish.metallic = program.add(finish.metallic, program.multiply(weight, program.clamp(metallic)))
    finish.reflectance = program.add(finish.reflectance, program.multiply(weight, program.clamp(reflectance)))


def _reflectance(reader: ValueReader, at: Socket) -> Value:
    """Of a Principled BSDF; from 4.0 on its IOR counts, too, of which 1.5 reflects 4 %."""
    if (level := at.input("Specular IOR Level")) is None:
        return reader.number(at.input("Specular"))
    ior = reader.constant(at.input("IOR"), 1.5)
    facing = ((ior - 1.0) / (ior + 1.0)) ** 2 if ior > 0.0 else 0.0
    return reader.program.multiply(reader.number(level), grey(facing / 0.04))


def _diffuse(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    if at.node.type == "BSDF_DIFFUSE" and reader.constant(at.input("Roughness")) > 0.0:
        reader.note("the roughness of a diffuse surface is not drawn")
    _note_bumps(reader, at)
    program, colour = reader.program, _colour_of(reader, at)
    shares.diffuse = program.add(shares.diffuse, program.multiply(weight, colour))
    if shares.finish is not None and at.node.type in _GLOSSY:
        _add_finish(reader, shares, weight, colour, reader.number(at.input("Roughness"), 0.5), WHITE, grey(0.5))
    else:
        _add_finish(reader, shares, weight, colour)


def _note_direction(reader: ValueReader, at: Socket) -> None:
    anisotropy = reader.number(at.input("Anisotropy") or at.input("Anisotropic"))
    if anisotropy != BLACK and reader.number(at.input("Roughness"), 0.5) != BLACK:
        reader.note("what mirrors is as sharp along its tangent as across where reflections are followed")


def _mirror(reader: ValueReader, shares: Shares, facing: Value, edge: Value, ior: float) -> None:
    program = reader.program
    gloss = shares.gloss = shares.gloss or GlossValues()
    gloss.facing, gloss.edge = program.add(gloss.facing, facing), program.add(gloss.edge, edge)
    if facing != edge and gloss.indices.setdefault("mirror_ior", ior) != ior:
        reader.note("mirrors of several indices of refraction are drawn with that of the first")


def _coat(reader: ValueReader, shares: Shares, weight: Value, coated: Value, ior: float) -> None:
    program = reader.program
    gloss = shares.gloss = shares.gloss or GlossValues()
    gloss.coat, gloss.coated = program.add(gloss.coat, weight), program.add(gloss.coated, coated)
    if gloss.indices.setdefault("coat_ior", ior) != ior:
        reader.note("gloss of several indices of refraction is drawn with that of the first")


def _glossy(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    if not is_sharp(reader, at, shares):
        if shares.finish is None:
            reader.unsupported(at, "is drawn as diffuse in its colour")
        _diffuse(reader, at, weight, shares)
        return
    _note_bumps(reader, at)
    _note_direction(reader, at)
    colour = reader.program.multiply(weight, _colour_of(reader, at))
    _mirror(reader, shares, colour, colour, 0.0)


def _metallic(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    """From 4.3 on. Its edge tint bends the rise to white a little below the edge: left out."""
    if getattr(at.node, "fresnel_type", "F82") != "F82" or not is_sharp(reader, at, shares):
        if shares.finish is None:
            reader.unsupported(at, "is drawn as diffuse in its colour")
        _diffuse(reader, at, weight, shares)
        return
    _note_bumps(reader, at)
    _note_direction(reader, at)
    _note_film(reader, at)
    _mirror(reader, shares, reader.program.multiply(weight, _colour_of(reader, at)), weight, 0.0)


def _principled_index(reader: ValueReader, at: Socket) -> float:
    """Of the clear layer, whose share seen straight its specular setting scales: 1 is none."""
    if (level := at.input("Specular")) is not None:  # up to 3.x
        straight = 0.08 * reader.constant(level)
    else:
        ior = max(reader.constant(at.input("IOR"), 1.5), 1.0)
        straight = ((ior - 1.0) / (ior + 1.0)) ** 2 * 2.0 * reader.constant(at.input("Specular IOR Level"), 0.5)
    root = math.sqrt(min(max(straight, 0.0), 0.99))
    return (1.0 + root) / (1.0 - root)


def _transparent(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    program = reader.program
    shares.transparent = program.add(shares.transparent, program.multiply(weight, _colour_of(reader, at)))


def _transparent_like(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    """Glass, and a Ray Portal."""
    if shares.finish is None or at.node.type == "BSDF_RAY_PORTAL":
        reader.unsupported(at, "is drawn as transparent in its colour")
    else:
        reader.note(_OPAQUE_GLASS)
        roughness = reader.number(at.input("Roughness"))
        _add_finish(reader, shares, weight, _colour_of(reader, at), roughness, BLACK, grey(0.5))
    shares.has_glass = True
    _transparent(reader, at, weight, shares)


def _emission(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    program = reader.program
    radiance = program.multiply(reader.colour(at.input("Color")), reader.number(at.input("Strength"), 1.0))
    shares.emission = program.add(shares.emission, program.multiply(weight, radiance))


def _untinted(reader: ValueReader, at: Socket, shares: Shares, weight: Value, ior: float) -> Value:
    """What is left of a clear layer's weight once a Specular Tint has coloured what it mirrors, but at its edge."""
    if bpy.app.version < (4, 0, 0):
        is_drawn, is_tinted = False, reader.number(at.input("Specular Tint")) != BLACK
    else:
        tint = reader.colour(at.input("Specular Tint"), WHITE)
        is_drawn, is_tinted = shares.gloss is None or "mirror_ior" not in shares.gloss.indices, tint != WHITE
    if not is_tinted:
        return weight
    if not is_drawn:
        reader.note("the tint of specular reflections is not drawn here")
        return weight
    program, straight = reader.program, ((ior - 1.0) / (ior + 1.0)) ** 2
    _mirror(reader, shares, program.multiply(weight, program.multiply(tint, grey(straight))), weight, ior)
    return BLACK


def _note_layers(reader: ValueReader, at: Socket) -> None:
    for name, older in (("Sheen", "Sheen"), ("Coat", "Clearcoat")):
        if reader.number(at.input(f"{name} Weight") or at.input(older)) != BLACK:
            reader.note(f"{name.lower()} is not drawn on voxels, nor where reflections are followed")
    if reader.number(at.input("Subsurface Weight") or at.input("Subsurface")) != BLACK:
        reader.note("subsurface scattering is drawn as diffuse on voxels, and where reflections are followed")


def _note_film(reader: ValueReader, at: Socket) -> None:
    if film_of(reader, at) is not None:
        reader.note("thin films are not drawn on voxels, and where reflections are followed on glass alone")


def _transmit(reader: ValueReader, at: Socket, factors: tuple[Value, Value, Value], shares: Shares) -> bool:
    """Adds what a Principled shader transmits: its share of the surface, of that what it transmits, in its base colour.

    Whether it bends that.
    """
    weight, transmission, base = factors
    if transmission == BLACK:
        return False
    program = reader.program
    shares.has_glass = True
    passing = program.multiply(weight, program.multiply(through_one_side(program, base), transmission))
    shares.transparent = program.add(shares.transparent, passing)
    if bends_transmission(reader, at, shares):
        add_bent_transmission(reader, at, program.multiply(weight, transmission), base, shares)
        return True
    reader.note("transmission is drawn as transparent in its colour" if shares.finish is None else _OPAQUE_GLASS)
    return False


def _principled(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> None:
    """Alpha cuts everything, emission too, as in Cycles. Metal and gloss are diffuse unless they mirror.

    Transmission is transparent.
    """
    program = reader.program
    alpha = program.clamp(reader.number(at.input("Alpha"), 1.0))
    shares.transparent = program.add(shares.transparent, program.multiply(weight, program.complement(alpha)))
    weight = program.multiply(weight, alpha)
    _note_layers(reader, at)

    emission = at.input("Emission Color") or at.input("Emission")  # renamed in 4.0
    radiance = program.multiply(reader.colour(emission), reader.number(at.input("Emission Strength"), 1.0))
    shares.emission = program.add(shares.emission, program.multiply(weight, radiance))

    base = reader.colour(at.input("Base Color"))
    metallic = program.clamp(reader.number(at.input("Metallic")))
    if shares.finish is not None:
        finish = reader.number(at.input("Roughness")), metallic, _reflectance(reader, at)
        _add_finish(reader, shares, weight, base, *finish)
    mirrors = is_sharp(reader, at, shares)
    if metallic != BLACK and not mirrors and shares.finish is None:
        reader.note("metal is drawn as diffuse in its colour")
    of_rest = program.clamp(reader.number(at.input("Transmission Weight") or at.input("Transmission")))
    transmission = program.multiply(of_rest, program.complement(metallic))
    if not _transmit(reader, at, (weight, transmission, base), shares) or transmission != WHITE:
        _note_bumps(reader, at)
        _note_film(reader, at)
    opaque = program.multiply(weight, program.complement(transmission))
    scattering = program.multiply(opaque, base)
    if mirrors:
        _note_direction(reader, at)
        index, is_3 = _principled_index(reader, at), bpy.app.version < (4, 0, 0)
        metal = program.multiply(opaque if is_3 else weight, metallic)  # up to 3.x metal and coat are one layer
        below = program.multiply(program.multiply(weight, program.complement(metallic)), program.complement(of_rest))
        opaque = program.multiply(opaque, program.complement(metallic)) if is_3 else below
        scattering = program.multiply(below, base)
        if metal != BLACK:  # up to 3.x it rises as the clear layer does, from 4.0 on as metals do
            _mirror(reader, shares, program.multiply(metal, base), metal, index if is_3 else 0.0)
        if opaque != BLACK and index > 1.0:
            untinted = _untinted(reader, at, shares, opaque, index)
            _coat(reader, shares, untinted, BLACK if is_3 else scattering, index)
            scattering = scattering if is_3 else BLACK  # up to 3.x the layer keeps nothing from what lies below
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
    "BSDF_GLOSSY": _glossy,
    "BSDF_ANISOTROPIC": _glossy,
    "BSDF_METALLIC": _metallic,
    "BSDF_PRINCIPLED": _principled,
    "BSDF_GLASS": _transparent_like,
    "BSDF_REFRACTION": _transparent_like,
    "BSDF_RAY_PORTAL": _transparent_like,
    "EMISSION": _emission,
    "BACKGROUND": _emission,  # of a world: on a surface it glows, in Cycles, too
    "MIX_SHADER": _mix_shader,
    "ADD_SHADER": _add_shader,
}
