# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds surface programs: constants fold, equal operations merge, registers are reused once they are read.

A value is a colour that is known now, an ``Rgb`` tuple, or a ``Term`` that is known at each point. Numbers are colours
with three equal channels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from tyndall.scene_description import Code, Gloss, Material, Rgb, SurfaceOp, TextureUse, attribute_maps

BLACK: Rgb = (0.0, 0.0, 0.0)
WHITE: Rgb = (1.0, 1.0, 1.0)
_LUMINANCE: Rgb = (0.2126729, 0.7151522, 0.0721750)  #: Of Rec. 709, as Cycles turns a colour into a number.
_READS = {
    Code.CONSTANT: "",
    Code.TEXTURE: "",
    Code.TEXTURE_ALPHA: "",
    Code.BACKFACING: "",
    Code.UV: "",
    Code.CLAMP: "a",
    Code.AVERAGE: "a",
    Code.MULTIPLY: "ab",
    Code.ADD: "ab",
    Code.SUBTRACT: "ab",
    Code.MIX: "abc",
}


@dataclass(frozen=True)
class Term:
    """The result of an operation, by its place in the program."""

    place: int


Value = Rgb | Term


@dataclass
class GlossValues:
    """What mirrors of a surface, see tyndall.scene_description.Gloss."""

    facing: Value = BLACK
    edge: Value = BLACK
    coat: Value = BLACK
    coated: Value = BLACK
    indices: dict[str, float] = field(default_factory=dict)  #: mirror_ior and coat_ior, where they are known.


def grey(number: float) -> Rgb:
    return (number, number, number)


class Program:
    def __init__(self) -> None:
        self._ops: list[SurfaceOp] = []  # `out` is the place: registers come last
        self._places: dict[tuple[object, ...], Term] = {}
        self._textures: list[TextureUse] = []
        self._uv_maps: list[str] = []

    @property
    def ops(self) -> list[SurfaceOp]:
        """A term's operation is at its place."""
        return self._ops

    def uv_map(self, op: SurfaceOp) -> str:
        """What texture() was asked to read its image at."""
        return self._uv_maps[op.uv_map]

    def texture(self, use: TextureUse, uv_map: str, uv_matrix: tuple[float, ...], *, alpha: bool = False) -> Value:
        """The colour, or the alpha, of an image at the 3x3 ``uv_matrix`` times (u, v, 1)."""
        index = next((i for i, known in enumerate(self._textures) if _same_use(known, use)), len(self._textures))
        if index == len(self._textures):
            self._textures.append(use)
        code = Code.TEXTURE_ALPHA if alpha else Code.TEXTURE
        return self._op(code, texture=index, uv_map=self._uv_map(uv_map), uv_matrix=uv_matrix)

    def attribute(self, name: str, *, alpha: bool = False) -> Value:
        """The colour, or the alpha, of an attribute of the surface."""
        red_green, blue_alpha = (self._uv_map(uv_map) for uv_map in attribute_maps(name))
        if alpha:
            return self._op(Code.UV, uv_map=blue_alpha, uv_matrix=(0, 1, 0, 0, 1, 0, 0, 1, 0))
        return self.add(
            self._op(Code.UV, uv_map=red_green, uv_matrix=(1, 0, 0, 0, 1, 0, 0, 0, 0)),
            self._op(Code.UV, uv_map=blue_alpha, uv_matrix=(0, 0, 0, 0, 0, 0, 1, 0, 0)),
        )

    def _uv_map(self, name: str) -> int:
        if name not in self._uv_maps:
            self._uv_maps.append(name)
        return self._uv_maps.index(name)

    def backfacing(self) -> Value:
        return self._op(Code.BACKFACING)

    def multiply(self, a: Value, b: Value) -> Value:
        if isinstance(a, Term) and not isinstance(b, Term):
            a, b = b, a
        if not isinstance(a, Term):
            if not isinstance(b, Term):
                return _each(lambda x, y: x * y, a, b)
            if a == BLACK:
                return BLACK
            if a == WHITE:
                return b
        return self._op(Code.MULTIPLY, a, b)

    def add(self, a: Value, b: Value) -> Value:
        if a == BLACK:
            return b
        if b == BLACK:
            return a
        if not isinstance(a, Term) and not isinstance(b, Term):
            return _each(lambda x, y: x + y, a, b)
        return self._op(Code.ADD, a, b)

    def subtract(self, a: Value, b: Value) -> Value:
        if b == BLACK:
            return a
        if not isinstance(a, Term) and not isinstance(b, Term):
            return _each(lambda x, y: x - y, a, b)
        return self._op(Code.SUBTRACT, a, b)

    def complement(self, a: Value) -> Value:
        return self.subtract(WHITE, a)

    def mix(self, a: Value, b: Value, share_of_b: Value) -> Value:
        """``a + (b - a) * share_of_b``, with the share clamped to [0, 1]."""
        if not isinstance(share_of_b, Term):
            share = self.clamp(share_of_b)
            return self.add(self.multiply(a, self.complement(share)), self.multiply(b, share))
        return a if a == b else self._op(Code.MIX, a, b, share_of_b)

    def clamp(self, a: Value) -> Value:
        if not isinstance(a, Term):
            return min(max(a[0], 0.0), 1.0), min(max(a[1], 0.0), 1.0), min(max(a[2], 0.0), 1.0)
        return self._op(Code.CLAMP, a)

    def average(self, a: Value) -> Value:
        """A vector as a number."""
        return self._op(Code.AVERAGE, a) if isinstance(a, Term) else grey(sum(a) / 3.0)

    def luminance(self, a: Value) -> Value:
        """A colour as a number."""
        return self.average(self.multiply(a, tuple(3.0 * share for share in _LUMINANCE)))

    def channel(self, a: Value, index: int) -> Value:
        mask = [0.0, 0.0, 0.0]
        mask[index] = 3.0
        return self.average(self.multiply(a, tuple(mask))) if isinstance(a, Term) else grey(a[index])

    def combine(self, channels: list[Value]) -> Value:
        masks = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        result: Value = BLACK
        for channel, mask in zip(channels, masks, strict=True):
            result = self.add(result, self.multiply(channel, mask))
        return result

    def material(
        self, name: str, results: tuple[Value, Value, Value], gloss: GlossValues | None = None, **fields: object
    ) -> Material:
        """``results`` are diffuse, transparent and emission; constants if all of them and of gloss are known now."""
        diffuse, transparent, emission = results
        layers = () if gloss is None else (gloss.facing, gloss.edge, gloss.coat, gloss.coated)
        if not any(isinstance(result, Term) for result in (*results, *layers)):
            constant = gloss and Gloss(
                **dict(zip(("facing", "edge", "coat", "coated"), layers, strict=True)), **gloss.indices
            )
            return Material(
                name=name, diffuse=diffuse, transparent=transparent, emission=emission, gloss=constant, **fields
            )
        terms = [result if isinstance(result, Term) else self._constant(result) for result in (*results, *layers)]
        ops, registers = _allocate_registers(self._ops, [term.place for term in terms])
        return Material(
            name=name,
            program=ops,
            diffuse_register=registers[0],
            transparent_register=registers[1],
            emission_register=registers[2],
            textures=tuple(self._textures),
            uv_maps=tuple(self._uv_maps),
            gloss=gloss and Gloss(registers=tuple(registers[3:]), **gloss.indices),
            **fields,
        )

    def _constant(self, value: Rgb) -> Term:
        return self._op(Code.CONSTANT, value=value)

    def _op(self, code: Code, *operands: Value, **fields: object) -> Term:
        terms = [operand if isinstance(operand, Term) else self._constant(operand) for operand in operands]
        key = (code, *terms, *sorted(fields.items()))
        if key not in self._places:
            places = dict(zip("abc", (term.place for term in terms), strict=False))
            self._places[key] = Term(len(self._ops))
            self._ops.append(SurfaceOp(code=code, out=len(self._ops), **places, **fields))
        return self._places[key]


def _each(combine: Callable[[float, float], float], a: Rgb, b: Rgb) -> Rgb:
    return combine(a[0], b[0]), combine(a[1], b[1]), combine(a[2], b[2])


def _same_use(a: TextureUse, b: TextureUse) -> bool:
    return (a.image.key, a.extension, a.interpolation) == (b.image.key, b.extension, b.interpolation)


def _allocate_registers(ops: list[SurfaceOp], results: list[int]) -> tuple[tuple[SurfaceOp, ...], list[int]]:
    """Drops operations that no result reads, and gives a register away after its last reader."""
    needed = set(results)
    last_reader: dict[int, int] = {}
    for place in reversed(range(len(ops))):
        if place in needed:
            for operand in _READS[ops[place].code]:
                read = getattr(ops[place], operand)
                needed.add(read)
                last_reader.setdefault(read, place)
    free: list[int] = []
    register_of: dict[int, int] = {}
    register_count = 0
    kept = []
    for place, op in enumerate(ops):
        if place not in needed:
            continue
        operands = {operand: register_of[getattr(op, operand)] for operand in _READS[op.code]}
        read_here = {getattr(op, operand) for operand in _READS[op.code]}
        free += [register_of[read] for read in read_here if last_reader[read] == place and read not in results]
        if free:
            register_of[place] = free.pop()
        else:
            register_of[place] = register_count
            register_count += 1
        kept.append(replace(op, out=register_of[place], **operands))
    return tuple(kept), [register_of[place] for place in results]
