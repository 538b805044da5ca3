# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute with colours, as Cycles computes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.scene_description import Code
from tyndall.surface_operations import BLENDS, COLOUR_MODELS

from .blackbody import blackbody
from .cie_1931 import FIRST_NM, LAST_NM, STEP_NM
from .colour_tables import colour_at, curved, of_blackbody, of_curves, of_ramp, of_wavelengths
from .domains import MID_GREY, Domain
from .math_nodes import math_operation, vector_operation
from .program import BLACK, WHITE, Program, Term, Value, grey

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .value_nodes import ValueReader


def _mix_colour(reader: ValueReader, at: Socket) -> Value:
    """Mix (colour) up to 3.3, which later files still hold."""
    node, program = at.node, reader.program
    share, a, b = (at.input(name) for name in ("Fac", "Color1", "Color2"))
    result = blended(program, node.blend_type, reader.colour(a), reader.colour(b), program.clamp(reader.number(share)))
    return program.clamp(result) if node.use_clamp else result


def _mix(reader: ValueReader, at: Socket) -> Value:
    node, program = at.node, reader.program
    suffix = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(node.data_type)
    if suffix is None:
        reader.unsupported(at, "of rotations is read as mid grey")
        return MID_GREY
    if node.data_type == "VECTOR" and node.factor_mode == "NON_UNIFORM":
        share = reader.vector(at.input("Factor_Vector"))
    else:
        share = reader.number(at.input("Factor_Float"))
    if node.clamp_factor:
        share = program.clamp(share)
    both = at.input(f"A_{suffix}"), at.input(f"B_{suffix}")
    a, b = (reader.number(one) if suffix == "Float" else reader.colour(one) for one in both)
    if node.data_type != "RGBA":
        return _between(program, a, b, share)
    result = blended(program, node.blend_type, a, b, share)
    return program.clamp(result) if node.clamp_result else result


def _between(program: Program, a: Value, b: Value, share: Value) -> Value:
    """From ``a`` to ``b``, and beyond where the share is not in [0, 1]."""
    if not isinstance(share, Term):
        return program.add(program.multiply(a, program.complement(share)), program.multiply(b, share))
    return program.add(a, program.multiply(program.subtract(b, a), share))


def blended(program: Program, blend: str, a: Value, b: Value, share: Value) -> Value:
    """Blender's blend modes; sums and products are the program's own, which tell linear ones from others."""
    if blend == "MIX":
        return _between(program, a, b, share)
    if blend == "ADD":
        return program.add(a, program.multiply(b, share))
    if blend == "SUBTRACT":
        return program.subtract(a, program.multiply(b, share))
    if blend == "MULTIPLY":
        return _between(program, a, program.multiply(a, b), share)
    return program.operation(Code.BLEND, a, b, share, option=BLENDS.index(blend))


def _invert(reader: ValueReader, at: Socket) -> Value:
    colour = reader.colour(at.input("Color"))
    share = reader.number(at.input("Fac") or at.input("Factor"))
    return _between(reader.program, colour, reader.program.complement(colour), share)


def _colour_ramp(reader: ValueReader, at: Socket) -> Value:
    place = reader.number(at.input("Fac") or at.input("Factor"))
    return colour_at(reader.program, of_ramp(at.node.color_ramp), place, alpha=at.socket.identifier == "Alpha")


def _curves(reader: ValueReader, at: Socket) -> Value:
    """Of colours, vectors and numbers."""
    share = reader.number(at.input("Fac") or at.input("Factor"))
    value = at.input("Color") or at.input("Vector")
    read = reader.number(at.input("Value")) if value is None else reader.colour(value)
    result = curved(reader.program, of_curves(at.node.mapping), read, share)
    return reader.program.channel(result, 0) if value is None else result


def _separate(reader: ValueReader, at: Socket) -> Value:
    model = {"SEPRGB": "RGB", "SEPHSV": "HSV"}.get(at.node.type) or at.node.mode
    colour = reader.colour(at.inputs()[0])
    index = [socket.identifier for socket in at.node.outputs].index(at.socket.identifier)
    if model == "RGB":
        return reader.program.channel(colour, index)
    return reader.program.operation(Code.SEPARATE, colour, option=COLOUR_MODELS.index(model), selector=index)


def _combine(reader: ValueReader, at: Socket) -> Value:
    model = {"COMBRGB": "RGB", "COMBHSV": "HSV"}.get(at.node.type) or at.node.mode
    channels = [reader.number(socket) for socket in at.inputs()]
    if model == "RGB":
        return reader.program.combine(channels)
    return reader.program.operation(Code.COMBINE, *channels, option=COLOUR_MODELS.index(model))


def _to_grey(reader: ValueReader, at: Socket) -> Value:
    return reader.program.luminance(reader.colour(at.input("Color")))


def _hue_saturation(reader: ValueReader, at: Socket) -> Value:
    numbers = [reader.number(at.input(name)) for name in ("Hue", "Saturation", "Value", "Fac")]
    return reader.program.operation(Code.HUE_SATURATION, reader.colour(at.input("Color")), *numbers)


def _gamma(reader: ValueReader, at: Socket) -> Value:
    return reader.program.operation(Code.GAMMA, reader.colour(at.input("Color")), reader.number(at.input("Gamma")))


def _bright_contrast(reader: ValueReader, at: Socket) -> Value:
    program = reader.program
    contrast = reader.number(at.input("Contrast"))
    brightness = program.subtract(reader.number(at.input("Bright")), program.multiply(contrast, grey(0.5)))
    scaled = program.multiply(reader.colour(at.input("Color")), program.add(WHITE, contrast))
    result = program.add(scaled, brightness)
    return _not_negative(program, result) if reader.domain is not Domain.LIGHT else result


def _not_negative(program: Program, colour: Value) -> Value:
    return vector_operation(program, "MAXIMUM", colour, BLACK)


def _blackbody(reader: ValueReader, at: Socket) -> Value:
    kelvin = reader.number(at.input("Temperature"))
    if isinstance(kelvin, Term):
        return _not_negative(reader.program, colour_at(reader.program, of_blackbody(), kelvin))
    return _not_negative(reader.program, blackbody(kelvin[0]))


def _wavelength(reader: ValueReader, at: Socket) -> Value:
    """Black beyond what is seen, where Cycles' table goes on for one step at its start."""
    program, nanometres = reader.program, reader.number(at.input("Wavelength"))
    colour = _not_negative(program, colour_at(program, of_wavelengths(), nanometres))
    is_seen = program.multiply(
        math_operation(program, "GREATER_THAN", nanometres, grey(FIRST_NM - STEP_NM)),
        math_operation(program, "LESS_THAN", nanometres, grey(LAST_NM)),
    )
    return program.multiply(colour, is_seen)


NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "MIX_RGB": _mix_colour,
    "MIX": _mix,
    "INVERT": _invert,
    "VALTORGB": _colour_ramp,
    "CURVE_RGB": _curves,
    "CURVE_VEC": _curves,
    "CURVE_FLOAT": _curves,
    "SEPRGB": _separate,
    "SEPHSV": _separate,
    "SEPARATE_COLOR": _separate,
    "COMBRGB": _combine,
    "COMBHSV": _combine,
    "COMBINE_COLOR": _combine,
    "RGBTOBW": _to_grey,
    "HUE_SAT": _hue_saturation,
    "BRIGHTCONTRAST": _bright_contrast,
    "GAMMA": _gamma,
    "BLACKBODY": _blackbody,
    "WAVELENGTH": _wavelength,
}
