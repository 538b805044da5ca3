# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that give colours, numbers and vectors, as values of a surface program.

What a node cannot be here takes a stated fallback and one note under its culprit; nothing fails.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum, auto
from typing import TYPE_CHECKING

from .blackbody import blackbody
from .program import BLACK, WHITE, Program, Term, Value, grey
from .texture_nodes import environment_value, image_value

if TYPE_CHECKING:
    import bpy
    import numpy as np
    from numpy.typing import NDArray

    from tyndall.scene_description import Image

    from .images import ImageReader
    from .node_graph import Socket
    from .reports import Reports

MID_GREY: Value = grey(0.5)  #: Stands for patterns and attributes that cannot be evaluated yet.
_PATTERNS = {
    "TEX_NOISE", "TEX_VORONOI", "TEX_WAVE", "TEX_MAGIC", "TEX_GRADIENT", "TEX_MUSGRAVE", "TEX_WHITE_NOISE", "TEX_GABOR"
}  # fmt: skip


class Domain(Enum):
    """What values may vary over."""

    SURFACE = auto()
    WORLD = auto()  #: Directions, and only through an environment texture.
    LIGHT = auto()  #: Directions, through images.
    CONSTANT = auto()  #: Media.


class ValueReader:
    """Evaluates sockets for one culprit, into one program."""

    def __init__(self, culprit: str, reports: Reports, images: ImageReader, domain: Domain) -> None:
        self.culprit = culprit
        self.program = Program()
        self.images = images
        self.reports = reports
        self.domain = domain
        self.environment: tuple[Image, NDArray[np.float64]] | None = None  #: Of a world: image and its rotation.

    def grid_value(self, _name: str) -> float | None:
        """Of a volume object's grid, at the place for which the reader answers; None: it has no such grid."""
        return None

    def image(self, at: Socket) -> Value:
        """The value of an image node, in a domain that has them all alike."""
        self.unsupported(at, "is read as mid grey: textures do not reach here")
        return MID_GREY

    def note(self, text: str) -> None:
        self.reports.add(self.culprit, text)

    def unsupported(self, at: Socket, fallback: str) -> None:
        self.note(f"{at.node.bl_label} {fallback}")

    def colour(self, at: Socket | None, default: Value = BLACK) -> Value:
        """The value of an input as a colour or vector; ``default`` in a version without this input."""
        if at is None:
            return default
        source = at.source()
        if source.socket.is_output:
            return self._output(source)
        return _default(source)

    def number(self, at: Socket | None, default: float = 0.0) -> Value:
        """The value of an input as a number."""
        if at is None:
            return grey(default)
        source = at.source()
        value = self.colour(at)
        if source.socket.type == "RGBA":
            return self.program.luminance(value)
        return self.program.average(value) if source.socket.type == "VECTOR" else value

    def constant(self, at: Socket | None, default: float = 0.0) -> float:
        """A number that is known now; where it varies, half, with a note."""
        value = self.number(at, default)
        if isinstance(value, Term):
            self.note(f"a varying {at.socket.name} is read as 0.5")
            return 0.5
        return value[0]

    def constant_colour(self, at: Socket | None, default: Value = BLACK) -> tuple[float, float, float]:
        value = self.colour(at, default)
        if isinstance(value, Term):
            self.note(f"a varying {at.socket.name} is read as mid grey")
            return 0.5, 0.5, 0.5
        return value

    def _output(self, at: Socket) -> Value:
        evaluate = _NODES.get(at.node.type)
        if evaluate is not None:
            return evaluate(self, at)
        if at.node.type in _PATTERNS:
            self.unsupported(at, "is drawn as mid grey")
        else:
            self.unsupported(at, "is not supported: read as mid grey")
        return MID_GREY


def _default(at: Socket) -> Value:
    value = getattr(at.socket, "default_value", 0.0)
    if isinstance(value, (int, float)):
        return grey(float(value))
    if isinstance(value, str):
        return BLACK
    return float(value[0]), float(value[1]), float(value[2])


def _own_value(_reader: ValueReader, at: Socket) -> Value:
    """RGB and Value nodes keep theirs in their output."""
    return _default(at)


def _image(reader: ValueReader, at: Socket) -> Value:
    return image_value(reader, at) if reader.domain is Domain.SURFACE else reader.image(at)


def _attribute(reader: ValueReader, at: Socket) -> Value:
    """Of meshes their colours, of voxels all that they carry."""
    node = at.node
    is_colour_node = node.type == "VERTEX_COLOR"
    if reader.domain is not Domain.SURFACE or not (is_colour_node or node.attribute_type == "GEOMETRY"):
        reader.unsupported(at, "is not supported here: read as mid grey")
        return MID_GREY
    name = node.layer_name if is_colour_node else node.attribute_name
    value = reader.program.attribute(name, alpha=at.socket.identifier == "Alpha")
    return reader.program.average(value) if at.socket.identifier == "Fac" else value


def _environment(reader: ValueReader, at: Socket) -> Value:
    if reader.domain is Domain.LIGHT:
        return reader.image(at)
    if reader.domain is not Domain.WORLD:
        reader.unsupported(at, "is read as mid grey: it works in worlds only")
        return MID_GREY
    return environment_value(reader, at)


def _mix_colour(reader: ValueReader, at: Socket) -> Value:
    """Mix (colour) up to 3.3, which later files still hold."""
    node = at.node
    share, a, b = (at.input(name) for name in ("Fac", "Color1", "Color2"))
    result = _blended(reader, node.blend_type, reader.colour(a), reader.colour(b), reader.number(share), node)
    return reader.program.clamp(result) if node.use_clamp else result


def _mix(reader: ValueReader, at: Socket) -> Value:
    node = at.node
    suffix = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(node.data_type)
    if suffix is None:
        reader.unsupported(at, "of rotations is read as mid grey")
        return MID_GREY
    if node.data_type == "VECTOR" and node.factor_mode == "NON_UNIFORM":
        share = reader.colour(at.input("Factor_Vector"))
    else:
        share = reader.number(at.input("Factor_Float"))
    if node.clamp_factor:
        share = reader.program.clamp(share)
    read = reader.number if node.data_type == "FLOAT" else reader.colour
    a, b = read(at.input(f"A_{suffix}")), read(at.input(f"B_{suffix}"))
    if node.data_type != "RGBA":
        program = reader.program  # not Program.mix: the share may be left unclamped
        return program.add(a, program.multiply(program.subtract(b, a), share))
    result = _blended(reader, node.blend_type, a, b, share, node)
    return reader.program.clamp(result) if node.clamp_result else result


def _blended(reader: ValueReader, blend: str, a: Value, b: Value, share: Value, node: bpy.types.Node) -> Value:
    program = reader.program
    if blend == "ADD":
        return program.add(a, program.multiply(b, program.clamp(share)))
    if blend == "SUBTRACT":
        return program.subtract(a, program.multiply(b, program.clamp(share)))
    if blend == "MULTIPLY":
        return program.mix(a, program.multiply(a, b), share)
    if blend == "SCREEN":
        both = program.multiply(program.complement(a), program.complement(b))
        return program.mix(a, program.complement(both), share)
    if blend != "MIX":
        reader.note(f"{node.bl_label} blends {blend.replace('_', ' ').lower()}: read as mix")
    return program.mix(a, b, share)


_MATH: dict[str, Callable[[float, float, float], float]] = {
    "DIVIDE": lambda a, b, _: a / b if b else 0.0,
    "POWER": lambda a, b, _: math.pow(a, b) if a > 0.0 or (b.is_integer() and a) else float(b == 0.0),
    "LOGARITHM": lambda a, b, _: math.log(a) / math.log(b) if a > 0.0 and b > 0.0 and b != 1.0 else 0.0,
    "SQRT": lambda a, *_: math.sqrt(max(a, 0.0)),
    "INVERSE_SQRT": lambda a, *_: 1.0 / math.sqrt(a) if a > 0.0 else 0.0,
    "ABSOLUTE": lambda a, *_: abs(a),
    "EXPONENT": lambda a, *_: math.exp(min(a, 80.0)),
    "MINIMUM": lambda a, b, _: min(a, b),
    "MAXIMUM": lambda a, b, _: max(a, b),
    "LESS_THAN": lambda a, b, _: float(a < b),
    "GREATER_THAN": lambda a, b, _: float(a > b),
    "SIGN": lambda a, *_: float((a > 0.0) - (a < 0.0)),
    "COMPARE": lambda a, b, c: float(abs(a - b) <= max(c, 1e-5)),
    "ROUND": lambda a, *_: math.floor(a + 0.5),
    "FLOOR": lambda a, *_: math.floor(a),
    "CEIL": lambda a, *_: math.ceil(a),
    "TRUNC": lambda a, *_: math.trunc(a),
    "FRACT": lambda a, *_: a - math.floor(a),
    "MODULO": lambda a, b, _: math.fmod(a, b) if b else 0.0,
    "SINE": lambda a, *_: math.sin(a),
    "COSINE": lambda a, *_: math.cos(a),
    "TANGENT": lambda a, *_: math.tan(a),
    "ARCTANGENT": lambda a, *_: math.atan(a),
    "ARCTAN2": lambda a, b, _: math.atan2(a, b),
    "RADIANS": lambda a, *_: math.radians(a),
    "DEGREES": lambda a, *_: math.degrees(a),
}


def _math(reader: ValueReader, at: Socket) -> Value:
    program, operation = reader.program, at.node.operation
    values = [reader.number(socket) for socket in at.inputs()] + [BLACK, BLACK]
    a, b, c = values[:3]
    if operation == "ADD":
        result = program.add(a, b)
    elif operation == "SUBTRACT":
        result = program.subtract(a, b)
    elif operation == "MULTIPLY":
        result = program.multiply(a, b)
    elif operation == "MULTIPLY_ADD":
        result = program.add(program.multiply(a, b), c)
    elif operation == "DIVIDE" and not isinstance(b, Term):
        result = program.multiply(a, grey(1.0 / b[0] if b[0] else 0.0))
    elif operation in _MATH and not any(isinstance(value, Term) for value in (a, b, c)):
        result = grey(_MATH[operation](a[0], b[0], c[0]))
    else:
        reader.note(f"{at.node.bl_label} {operation.replace('_', ' ').lower()} passes its first input on")
        result = a
    return program.clamp(result) if at.node.use_clamp else result


def _invert(reader: ValueReader, at: Socket) -> Value:
    colour = reader.colour(at.input("Color"))
    return reader.program.mix(colour, reader.program.complement(colour), reader.number(at.input("Fac")))


def _colour_ramp(reader: ValueReader, at: Socket) -> Value:
    """Exact for constants and for two linear stops; a straight line between first and last stop otherwise."""
    ramp, share = at.node.color_ramp, reader.number(at.input("Fac"))
    is_alpha = at.socket.identifier == "Alpha"
    if not isinstance(share, Term):
        colour = tuple(ramp.evaluate(share[0]))
        return grey(colour[3]) if is_alpha else colour[:3]
    if len(ramp.elements[1:-1]) or ramp.interpolation != "LINEAR":
        reader.unsupported(at, "is drawn as a straight line between its ends")
    first, last = ramp.elements[0], ramp.elements[-1]
    program = reader.program
    width = max(last.position - first.position, 1e-6)
    share = program.multiply(program.subtract(share, grey(first.position)), grey(1.0 / width))
    if is_alpha:
        return program.mix(grey(first.color[3]), grey(last.color[3]), share)
    return program.mix(tuple(first.color)[:3], tuple(last.color)[:3], share)


def _separate(reader: ValueReader, at: Socket) -> Value:
    if getattr(at.node, "mode", "RGB") != "RGB":
        reader.unsupported(at, f"in {at.node.mode} is read as mid grey")
        return MID_GREY
    outputs = [socket.identifier for socket in at.node.outputs]
    return reader.program.channel(reader.colour(at.inputs()[0]), outputs.index(at.socket.identifier))


def _combine(reader: ValueReader, at: Socket) -> Value:
    if getattr(at.node, "mode", "RGB") != "RGB":
        reader.unsupported(at, f"in {at.node.mode} is read as mid grey")
        return MID_GREY
    return reader.program.combine([reader.number(socket) for socket in at.inputs()])


def _to_grey(reader: ValueReader, at: Socket) -> Value:
    return reader.program.luminance(reader.colour(at.input("Color")))


def _clamp(reader: ValueReader, at: Socket) -> Value:
    value = reader.number(at.input("Value"))
    low, high = reader.constant(at.input("Min")), reader.constant(at.input("Max"), 1.0)
    if not isinstance(value, Term):
        return grey(min(max(value[0], low), high))
    if (low, high) != (0.0, 1.0):
        reader.unsupported(at, "clamps to 0 and 1")
    return reader.program.clamp(value)


def _first_colour(reader: ValueReader, at: Socket) -> Value:
    """Adjustments that cannot be evaluated yet pass their colour on; those of constants are close to it."""
    reader.unsupported(at, "passes its colour on unchanged")
    return reader.colour(at.input("Color"))


def _checker(reader: ValueReader, at: Socket) -> Value:
    reader.unsupported(at, "is drawn as the mean of its two colours")
    return reader.program.mix(reader.colour(at.input("Color1")), reader.colour(at.input("Color2")), grey(0.5))


def _geometry(reader: ValueReader, at: Socket) -> Value:
    if at.socket.identifier == "Backfacing" and reader.domain is Domain.SURFACE:
        return reader.program.backfacing()
    reader.unsupported(at, f"{at.socket.name} is read as 0")
    return BLACK


def _light_path(reader: ValueReader, at: Socket) -> Value:
    """What the camera sees counts: its rays answer 1, all other questions 0."""
    reader.unsupported(at, "answers for camera rays only")
    return WHITE if at.socket.identifier == "Is Camera Ray" else BLACK


def _blackbody(reader: ValueReader, at: Socket) -> Value:
    return blackbody(reader.constant(at.input("Temperature"), 1500.0))


def _gamma(reader: ValueReader, at: Socket) -> Value:
    colour, exponent = reader.colour(at.input("Color")), reader.number(at.input("Gamma"))
    if isinstance(colour, Term) or isinstance(exponent, Term):
        return _first_colour(reader, at)
    return tuple(channel ** exponent[0] if channel > 0.0 else channel for channel in colour)


def _bright_contrast(reader: ValueReader, at: Socket) -> Value:
    program = reader.program
    contrast = reader.number(at.input("Contrast"))
    brightness = program.subtract(reader.number(at.input("Bright")), program.multiply(contrast, grey(0.5)))
    scaled = program.multiply(reader.colour(at.input("Color")), program.add(WHITE, contrast))
    return program.add(scaled, brightness)  # Cycles then cuts negative light off; so does the shader


_NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "RGB": _own_value,
    "VALUE": _own_value,
    "TEX_IMAGE": _image,
    "VERTEX_COLOR": _attribute,
    "ATTRIBUTE": _attribute,
    "TEX_ENVIRONMENT": _environment,
    "MIX_RGB": _mix_colour,
    "MIX": _mix,
    "MATH": _math,
    "INVERT": _invert,
    "VALTORGB": _colour_ramp,
    "SEPRGB": _separate,
    "SEPXYZ": _separate,
    "SEPARATE_COLOR": _separate,
    "COMBRGB": _combine,
    "COMBXYZ": _combine,
    "COMBINE_COLOR": _combine,
    "RGBTOBW": _to_grey,
    "CLAMP": _clamp,
    "HUE_SAT": _first_colour,
    "CURVE_RGB": _first_colour,
    "BRIGHTCONTRAST": _bright_contrast,
    "GAMMA": _gamma,
    "TEX_CHECKER": _checker,
    "NEW_GEOMETRY": _geometry,
    "LIGHT_PATH": _light_path,
    "BLACKBODY": _blackbody,
}
