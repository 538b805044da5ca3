# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair shaders as lobes of a fibre, and the colour that they have where surfaces are drawn without lobes.

Based on: Chiang et al., A Practical and Controllable Hair and Fur Model for Production Path Tracing, 2016 (colour of
many hairs by their absorption, equation 9, and its inverse); d'Eon et al., An Energy-Conserving Hair Reflectance Model,
2011 (absorption of melanin); Cycles (how much melanin a share of it is).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.scene_description import Code, LobeModel, hair_maps

from . import coordinates
from .lobe_values import LobeValues
from .math_nodes import vector_operation
from .program import BLACK, WHITE, Program, Value, grey

if TYPE_CHECKING:
    from .node_graph import Socket
    from .value_nodes import ValueReader

_MODELS = {
    "COLOR": (LobeModel.HAIR_OF_COLOUR, "Color"),
    "MELANIN": (LobeModel.HAIR_OF_MELANIN, "Tint"),
    "ABSORPTION": (LobeModel.HAIR_OF_ABSORPTION, "Absorption Coefficient"),
}
_HAIR_COLOUR = (0.017513, 0.005763, 0.002059)

_EUMELANIN, _PHEOMELANIN = np.array((0.506, 0.841, 1.653)), np.array((0.343, 0.733, 1.924))
_ROUGHNESS = (0.245, 5.574, -10.73, 2.532, -0.215, 5.969)  #: Of a fit, its highest power first.


def principled_hair_colour(reader: ValueReader, at: Socket) -> Value:
    """Of many hairs together: what Direct Coloring asks for, and what follows from melanin or an absorption."""
    kind = at.node.parametrization
    if kind == "COLOR":
        return reader.colour(at.input("Color"))
    fit = float(np.polyval(_ROUGHNESS, reader.constant(at.input("Radial Roughness"), 0.3)))
    if kind == "ABSORPTION":
        absorption = np.array(reader.constant_colour(at.input("Absorption Coefficient")))
    else:
        melanin = -math.log(max(1.0 - reader.constant(at.input("Melanin")), 1e-4))
        redness = reader.constant(at.input("Melanin Redness"))
        tint = np.maximum(reader.constant_colour(at.input("Tint"), WHITE), 1e-6)
        absorption = melanin * ((1.0 - redness) * _EUMELANIN + redness * _PHEOMELANIN) + (np.log(tint) / fit) ** 2
    red, green, blue = np.exp(-np.sqrt(np.maximum(absorption, 0.0)) * fit)
    return float(red), float(green), float(blue)


def principled_hair(reader: ValueReader, at: Socket, weight: Value) -> LobeValues:
    """Chiang's model, which from 4.0 on is one of two."""
    if (kind := getattr(at.node, "model", "CHIANG")) != "CHIANG":
        reader.note(f"{at.node.bl_label}'s model {kind} is drawn as Chiang's")
    program = reader.program
    model, colour = _MODELS[at.node.parametrization]
    of_colour, of_roughness = (reader.number(at.input(f"Random {what}")) for what in ("Color", "Roughness"))
    of_hair: Value = grey(0.5)
    if of_colour != BLACK or of_roughness != BLACK:
        random = at.input("Random")
        is_given = random is not None and random.is_connected()
        of_hair = reader.number(random) if is_given else hair_number(program, "rt", 0)
    inputs = (
        reader.colour(at.input(colour), _HAIR_COLOUR),
        reader.number(at.input("Melanin"), 0.8),
        reader.number(at.input("Melanin Redness"), 1.0),
        reader.number(at.input("Roughness"), 0.3),
        reader.number(at.input("Radial Roughness"), 0.3),
        reader.number(at.input("Coat")),
        reader.number(at.input("IOR"), 1.55),
        reader.number(at.input("Offset"), math.radians(2.0)),
        of_hair,
        of_colour,
        of_roughness,
    )
    is_old = bool(bpy.app.version < (4, 0, 0))  # its scales tilt the light's angle, not the viewer's
    return LobeValues(model, (weight, *inputs, _along(program, "01")), preserves_energy=not is_old)


def hair_bsdf(reader: ValueReader, at: Socket, weight: Value) -> LobeValues:
    """One of its two components. On meshes it is along their parameters, or a given tangent, without an offset."""
    program = reader.program
    tangent = at.input("Tangent")
    is_given = tangent is not None and tangent.is_connected()
    offset = reader.number(at.input("Offset"))
    if offset != BLACK and not is_given:
        offset = program.multiply(offset, hair_number(program, "is", 0))
    inputs = (
        reader.colour(at.input("Color"), grey(0.8)),
        program.subtract(BLACK, offset),
        reader.number(at.input("RoughnessU"), 0.1),
        reader.number(at.input("RoughnessV"), 1.0),
    )
    along = reader.colour(tangent) if is_given else _along(program, "02")
    is_reflection = at.node.component.upper() == "REFLECTION"
    model = LobeModel.HAIR_REFLECTION if is_reflection else LobeModel.HAIR_TRANSMISSION
    return LobeValues(model, (weight, *inputs, along))


def hair_number(program: Program, map_name: str, which: int) -> Value:
    """One of the two numbers that strands tell under that name."""
    row = (0, 1, 0) if which else (1, 0, 0)
    return program.operation(Code.UV, uv_map=program.uv_map_index(hair_maps()[map_name]), uv_matrix=row * 3)


def hair_vector(program: Program, xy: str, z: str) -> Value:
    """What strands tell under two names."""
    return program.add(
        coordinates.uv(program, xy),
        program.operation(Code.UV, uv_map=program.uv_map_index(z), uv_matrix=(0, 0, 0, 0, 0, 0, 1, 0, 0)),
    )


def default_tangent(program: Program) -> Value:
    """Cycles' where none is given: of strands along them, elsewhere around the texture space's Z."""
    around = coordinates.radial_tangent(program, "Z")
    along = vector_operation(program, "NORMALIZE", _along(program, ""))
    return program.add(around, program.multiply(hair_number(program, "is", 0), program.subtract(along, around)))


def _along(program: Program, corners: str) -> Value:
    """From a strand's root to its tip; on meshes between these corners of a triangle, as Cycles parametrizes it.

    Without corners 0 there.
    """
    maps = hair_maps()
    return hair_vector(program, maps["axy"] + corners, maps["az"] + corners)
