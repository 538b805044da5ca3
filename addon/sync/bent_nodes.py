# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass and water that bend what cameras see through them: see LobeModel.BENT_GLASS. To lamps they stay transparent."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import LobeModel

from .film_nodes import film_of
from .lobe_values import LobeNormals, LobeValues
from .math_nodes import math_operation
from .program import BLACK, WHITE, Program, Term, Value

if TYPE_CHECKING:
    from .node_graph import Socket
    from .surface_nodes import Shares, SharpSurfaces
    from .value_nodes import ValueReader

_IS_3 = bpy.app.version < (4, 0, 0)
_GLASS = LobeModel.BENT_GLASS_3 if _IS_3 else LobeModel.BENT_GLASS


def is_sharp(reader: ValueReader, at: Socket, shares: Shares) -> bool:
    """Whether a shader's reflection is as sharp as a mirror's, and mirrors are asked for."""
    if shares.sharp is None:
        return False
    if getattr(at.node, "distribution", "") == "SHARP":  # up to 3.x
        return True
    return _is_at_most(reader.number(at.input("Roughness"), 0.5), shares.sharp.roughness)


def _is_at_most(roughness: Value, most: float) -> bool:
    return not isinstance(roughness, Term) and roughness[0] <= most + 1e-6


def through_one_side(program: Program, base: Value) -> Value:
    """What a Principled BSDF that transmits lets in, or out: from 4.0 on both together make its base colour."""
    return base if _IS_3 else program.combine([_root(program, program.channel(base, axis)) for axis in range(3)])


def _root(program: Program, value: Value) -> Value:
    return math_operation(program, "SQRT", math_operation(program, "MAXIMUM", value, BLACK))


def _bending(reader: ValueReader, at: Socket, shares: Shares) -> SharpSurfaces | None:
    """By what, if a shader is to bend what is seen through it; voxels do not."""
    may_bend = shares.sharp is not None and shares.sharp.bend and shares.lobes is not None
    return shares.sharp if may_bend and is_sharp(reader, at, shares) else None


def add_bent_glass(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    """Whether a Glass or Refraction shader bends; then what it does is added to the shares."""
    if _bending(reader, at, shares) is None:
        return False
    program, colour = reader.program, reader.colour(at.input("Color"), WHITE)
    shares.has_glass = True
    shares.transparent = program.add(shares.transparent, program.multiply(weight, colour))
    ior = reader.number(at.input("IOR"), 1.45)
    if at.node.type == "BSDF_REFRACTION":
        _push(reader, at, shares, LobeModel.REFRACTION, weight, colour, ior)
    else:
        _push(reader, at, shares, _GLASS, weight, colour, colour, WHITE, ior)
    return True


def bends_transmission(reader: ValueReader, at: Socket, shares: Shares) -> bool:
    """Whether a Principled shader bends what it transmits; up to 3.x that may be rougher than its reflections."""
    sharp = _bending(reader, at, shares)
    if sharp is None:
        return False
    roughness = reader.number(at.input("Transmission Roughness"))
    return at.node.distribution != "GGX" or _is_at_most(roughness, sharp.roughness)


def add_bent_transmission(reader: ValueReader, at: Socket, weight: Value, base: Value, shares: Shares) -> None:
    """``weight`` is the share of what is transmitted, which is among what is transparent already."""
    program = reader.program
    if _IS_3:
        tint = program.mix(WHITE, base, program.clamp(reader.number(at.input("Specular Tint"))))
    else:
        tint = reader.colour(at.input("Specular Tint"), WHITE)
    ior = reader.number(at.input("IOR"), 1.45)
    _push(reader, at, shares, _GLASS, weight, WHITE, through_one_side(program, base), tint, ior)


def _push(reader: ValueReader, at: Socket, shares: Shares, model: LobeModel, *inputs: Value) -> None:
    reader.note("the light of lamps passes straight through what bends it")
    normals = LobeNormals(facets=reader.normal(at.input("Normal"), is_specular=True))
    if shares.lobes is not None:
        shares.lobes.append(LobeValues(model, inputs, normals=normals, film=film_of(reader, at)))
