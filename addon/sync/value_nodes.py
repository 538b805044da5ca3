# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that give colours, numbers and vectors, as values of a surface program.

What a node cannot be here takes a stated fallback and one note under its culprit; nothing fails.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.surface_operations import nearest_finite

from . import (
    colour_nodes,
    coordinates,
    displacement_nodes,
    input_nodes,
    math_nodes,
    normal_nodes,
    pattern_nodes,
    photometry_nodes,
    surroundings_nodes,
    texture_nodes,
)
from .domains import MID_GREY, Domain
from .finite_numbers import are_finite
from .program import BLACK, Program, Rgb, Term, Value, grey
from .shader_limits import ShaderCount

if TYPE_CHECKING:
    from collections.abc import Callable

    from .asked_properties import Rgba
    from .images import ImageReader
    from .node_graph import Socket
    from .reports import Reports
    from .seen_camera import SeenCamera

__all__ = ["MID_GREY", "Domain", "ValueReader"]


_CONVERTS_ON_THE_WAY = bpy.app.version < (5, 0, 0)  #: From then on Blender hands Cycles trees without groups.
#: Values read for each other, one in the other, before those below are read in their order instead: Python's stack
#: has room for some two hundred.
_MOST_NESTED = 40
_NUMBERS = {"VALUE", "INT", "BOOLEAN"}  #: Types of sockets.


#: Their hidden vectors are 0 where nothing is linked; textures' are places.
_WITHOUT_PLACE = frozenset({"MAP_RANGE", "VECTOR_ROTATE", "TEX_WHITE_NOISE"})


def is_place(at: Socket | None) -> bool:
    """Nothing is linked to an input of a texture, which then is read where the surface lies."""
    if at is None or not at.socket.hide_value or at.node.type in _WITHOUT_PLACE:
        return False
    return bool(at.source().socket == at.socket)


class ValueReader:
    """Evaluates sockets for one culprit, into one program."""

    def __init__(self, culprit: str, reports: Reports, images: ImageReader, domain: Domain) -> None:
        self.culprit = culprit
        self.program: Program = Program()
        self.images = images
        self.reports = reports
        self.domain = domain
        self._known: dict[tuple[object, ...], Value] = {}  #: Of outputs.
        self._nested = 0
        self.shaders = ShaderCount()
        self.camera: Callable[[], SeenCamera | None] = lambda: None  #: What surfaces may ask for.
        self.material_index = 0  #: Its pass index.
        self.displaced_normal: Value | None = None  #: In place of the point's own; None: that.
        self.corrects_bumps = True  #: Cycles' setting of the material, from 4.0 on.
        #: Of Ambient Occlusion without a distance of its own; None: nodes trace no rays, as those of worlds and lights.
        self.occlusion_reach_m: float | None = None
        self.misses_surroundings = False  #: A render would trace them.
        self.tells_particles = False  #: What is read knows which particle its instance is.
        #: See PropertyReader.read.
        self.property_of: Callable[[str, str], Rgba | int | None] = lambda _kind, _name: None

    @property
    def varying(self) -> Program:
        """The program of what linear_number, linear_colour and grid give."""
        return self.program

    def linear_number(self, at: Socket | None) -> Value:
        """Of an input in which a volume shader is linear: it may vary where the reader answers for places."""
        return grey(self.constant(at))

    def linear_colour(self, at: Socket | None) -> Value:
        return self.constant_colour(at)

    def grid(self, _name: str) -> Value | None:
        """A grid of a volume object; None: it has none of this name."""
        return None

    def at_place(self, value: Value, channel: int = 0) -> float:
        """A number, or a colour's channel, at the place for which the reader answers."""
        if isinstance(value, Term):
            raise TypeError("this reader answers for no place")
        return value[channel]

    def image(self, at: Socket) -> Value:
        """The value of an image node, in a domain that has them all alike."""
        self.unsupported(at, "is read as mid grey: textures do not reach here")
        return MID_GREY

    def note(self, text: str) -> None:
        self.reports.add(self.culprit, text)

    def unsupported(self, at: Socket, fallback: str) -> None:
        self.note(f"{at.node.bl_label} {fallback}")

    def note_left_out(self, at: Socket) -> None:
        """Of an input for a shader that no shader feeds."""
        if (node := at.traced()[1]) is not None:
            self._note_left_out(node)

    def _note_left_out(self, node: bpy.types.Node) -> None:
        self.note(f"{node.bl_label} is left out, as in Cycles: what it feeds keeps its own value")

    def colour(self, at: Socket | None, default: Value = BLACK) -> Value:
        """The value of an input as a colour or vector; ``default`` in a version without this input."""
        if at is None:
            return default
        return self._arriving(at)[0]

    def vector(self, at: Socket | None, default: Value = BLACK) -> Value:
        """The value of an input as a vector. Of textures, what is not linked is where the surface lies in its mesh."""
        if is_place(at) and self.domain is Domain.SURFACE:
            return coordinates.generated(self.program)
        return self.colour(at, default)

    def normal(self, at: Socket | None, *, is_specular: bool = False) -> Value | None:
        """What a closure gets for its normal; None where that is the point's own, see normal_nodes.py."""
        return normal_nodes.closure_normal(self, at, is_specular=is_specular)

    def number(self, at: Socket | None, default: float = 0.0) -> Value:
        """The value of an input as a number."""
        if at is None:
            return grey(default)
        value, kind = self._arriving(at)
        return self._converted(value, kind, "VALUE")

    def _arriving(self, at: Socket) -> tuple[Value, str]:
        """What reaches an input, and its type: up to 4.x each socket on the way turns it into its own."""
        (*way, source), left_out = at.traced()
        if left_out is not None:
            self._note_left_out(left_out)
        value = self._output(source) if source.socket.is_output else self.own_value(source)
        kind = source.socket.type
        for socket in reversed(way[1:] if _CONVERTS_ON_THE_WAY else []):
            value = self._converted(value, kind, socket.socket.type)
            kind = socket.socket.type
        return value, kind

    def _converted(self, value: Value, kind: str, wanted: str) -> Value:
        """As Cycles converts between types of sockets."""
        if kind == wanted or wanted not in _NUMBERS:
            return value
        if kind == "RGBA":
            return self.program.luminance(value)
        return self.program.average(value) if kind == "VECTOR" else value

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
        """Each is evaluated once, however many inputs it feeds."""
        key = self._key(at)
        if key not in self._known:
            if self._nested >= _MOST_NESTED:
                self._read_below(at)
            self._known[key] = MID_GREY  # of a loop, which is no tree
            self._nested += 1
            try:
                self._known[key] = self._evaluated(at)
            finally:
                self._nested -= 1
        return self._known[key]

    def _key(self, at: Socket) -> tuple[object, ...]:
        return (at.socket.as_pointer(), tuple(group.as_pointer() for group in at.groups), self.program.beside)

    def _read_below(self, top: Socket) -> None:
        """Read what feeds an output, the farthest first, so that none has to wait for a long row of others."""
        met: set[tuple[object, ...]] = {self._key(top)}
        waiting = [(top, False)]
        while waiting:
            at, is_fed = waiting.pop()
            if is_fed:
                if at is not top:
                    self._output(at)
                continue
            waiting.append((at, True))
            for source in (given.source() for given in at.inputs()):
                key = self._key(source)
                if not source.socket.is_output or source.socket.type == "SHADER" or key in met or key in self._known:
                    continue
                met.add(key)
                waiting.append((source, False))

    def own_value(self, at: Socket) -> Value:
        return self.finite(at.node, _default(at))

    def finite(self, node: bpy.types.Node, value: Rgb) -> Rgb:
        """What a node is set to, or, with a note, the nearest that is finite."""
        if are_finite(value):
            return value
        self.note(f"{node.bl_label} has a value that is not finite: read as the nearest that is, or 0")
        return nearest_finite(value)

    def _evaluated(self, at: Socket) -> Value:
        evaluate = _NODES.get(at.node.type)
        if evaluate is not None:
            return evaluate(self, at)
        self.unsupported(at, "is not supported: read as mid grey")
        return MID_GREY


def _default(at: Socket) -> Rgb:
    value = getattr(at.socket, "default_value", 0.0)
    if isinstance(value, (int, float)):
        return grey(float(value))
    if isinstance(value, str):
        return BLACK
    return float(value[0]), float(value[1]), float(value[2])


def _own_value(reader: ValueReader, at: Socket) -> Value:
    """RGB and Value nodes keep theirs in their output."""
    return reader.own_value(at)


_NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "RGB": _own_value,
    "VALUE": _own_value,
    **math_nodes.NODES,
    **colour_nodes.NODES,
    **displacement_nodes.NODES,
    **input_nodes.NODES,
    **normal_nodes.NODES,
    **pattern_nodes.NODES,
    **photometry_nodes.NODES,
    **surroundings_nodes.NODES,
    **texture_nodes.NODES,
}
