# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds surface programs: constants fold, equal operations merge, registers are reused once they are read.

A value is a colour that is known now, an ``Rgb`` tuple, or a ``Term`` that is known at each point. Numbers are colours
with three equal channels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from tyndall.scene_description import Code, Gloss, Material, Rgb, SurfaceOp, TextureUse, attribute_maps
from tyndall.surface_operations import OPERANDS, is_known_without_point, nearest_finite, operand_count, value_of

from .working_space import luminance_weights

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .lobe_values import LobeValues

BLACK: Rgb = (0.0, 0.0, 0.0)
WHITE: Rgb = (1.0, 1.0, 1.0)
#: What differs beside the point.
_OF_PLACES = frozenset({Code.TEXTURE, Code.TEXTURE_ALPHA, Code.UV, Code.INPUT})
_REGISTER_COUNT = 64  #: Beyond it, constants are set again for each reader.


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
        #: Within heights of bumps: to which side points are read, 1 or 2, and by how much of a pixel.
        self.beside: tuple[int, float] | None = None
        self.is_undisplaced = False  #: What is read of places is as before a displacement.
        self._ops: list[SurfaceOp] = []  # `out` is the place: registers come last
        self._places: dict[tuple[object, ...], Term] = {}
        self._textures: list[TextureUse] = []
        self._uv_maps: list[str] = []
        self._tables: list[NDArray[np.float32]] = []

    @property
    def ops(self) -> list[SurfaceOp]:
        """A term's operation is at its place."""
        return self._ops

    def uv_map(self, op: SurfaceOp) -> str:
        """What texture() was asked to read its image at."""
        return self._uv_maps[op.uv_map]

    def texture(self, use: TextureUse, uv_map: str, uv_matrix: tuple[float, ...], *, alpha: bool = False) -> Value:
        """The colour, or the alpha, of an image at the 3x3 ``uv_matrix`` times (u, v, 1)."""
        code = Code.TEXTURE_ALPHA if alpha else Code.TEXTURE
        return self._op(code, texture=self.texture_index(use), uv_map=self.uv_map_index(uv_map), uv_matrix=uv_matrix)

    def texture_index(self, use: TextureUse) -> int:
        """A number to give as ``texture``."""
        index = next((i for i, known in enumerate(self._textures) if _same_use(known, use)), len(self._textures))
        if index == len(self._textures):
            self._textures.append(use)
        return index

    def attribute(self, name: str, *, alpha: bool = False) -> Value:
        """The colour, or the alpha, of an attribute of the surface."""
        red_green, blue_alpha = (self.uv_map_index(uv_map) for uv_map in attribute_maps(name))
        if alpha:
            return self._op(Code.UV, uv_map=blue_alpha, uv_matrix=(0, 1, 0, 0, 1, 0, 0, 1, 0))
        return self.add(
            self._op(Code.UV, uv_map=red_green, uv_matrix=(1, 0, 0, 0, 1, 0, 0, 0, 0)),
            self._op(Code.UV, uv_map=blue_alpha, uv_matrix=(0, 0, 0, 0, 0, 0, 1, 0, 0)),
        )

    def is_attribute(self, told: str) -> tuple[Value, Value]:
        """Whether the surface has an attribute, and whether that is a pair of numbers: of a map that tells, 1 or 0."""
        index = self.uv_map_index(told)
        has = self._op(Code.UV, uv_map=index, uv_matrix=(1, 0, 0, 1, 0, 0, 1, 0, 0))
        return has, self._op(Code.UV, uv_map=index, uv_matrix=(0, 1, 0, 0, 1, 0, 0, 1, 0))

    def operation(self, code: Code, *operands: Value, **fields: object) -> Value:
        """One operation; its value, where all operands are known and it reads nothing else but a table.

        Operands that it does not read may be given, and are left out.
        """
        op = SurfaceOp(code=code, out=0, **fields)
        read = operands[: operand_count(op)]
        if len(read) < operand_count(op):
            raise ValueError(f"{code.name} reads {operand_count(op)} operands, not {len(read)}")
        if is_known_without_point(op) and not any(isinstance(operand, Term) for operand in read):
            return value_of(op, read, self._tables)
        return self._op(code, *read, **fields)

    def table(self, values: NDArray[np.float32]) -> int:
        """A number to give as ``table``: of colours with alpha at even steps over [0, 1], (steps, 4)."""
        for index, known in enumerate(self._tables):
            if known.shape == values.shape and (known == values).all():
                return index
        self._tables.append(values)
        return len(self._tables) - 1

    def uv_map_index(self, name: str) -> int:
        """A number to give as ``uv_map``."""
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
        return self.average(self.multiply(a, tuple(3.0 * share for share in luminance_weights())))

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
        self,
        name: str,
        results: tuple[Value, Value, Value],
        gloss: GlossValues | None = None,
        lobes: Sequence[LobeValues] = (),
        held_out: Value = BLACK,
        **fields: object,
    ) -> Material:
        """``results``: diffuse, transparent, emission; constants if all are known now, with ``held_out``, a number."""
        layers = () if gloss is None else (gloss.facing, gloss.edge, gloss.coat, gloss.coated)
        holes = () if held_out == BLACK else (held_out,)
        read = [term for of in lobes for term in of.terms()]
        if not read and not any(isinstance(result, Term) for result in (*results, *layers, *holes)):
            by_name = dict(zip(("facing", "edge", "coat", "coated"), layers, strict=False))
            return Material(
                name=name,
                diffuse=results[0],
                transparent=self.clamp(results[1]),  # as the native side has it of what a program says
                emission=results[2],
                gloss=gloss and Gloss(**by_name, **gloss.indices),
                lobes=tuple(of.constant(lambda _: -1) for of in lobes),
                held_out=self.clamp(held_out)[0],
                **fields,
            )
        terms = [self.term(value) for value in (*results, *layers, *holes)]
        ops, registers = _allocate_registers(self._ops, [term.place for term in (*terms, *read)])
        register_of = dict(zip(read, registers[len(terms) :], strict=True))
        return Material(
            name=name,
            program=ops,
            diffuse_register=registers[0],
            transparent_register=registers[1],
            emission_register=registers[2],
            textures=tuple(self._textures),
            uv_maps=tuple(self._uv_maps),
            tables=tuple(self._tables),
            gloss=gloss and Gloss(registers=tuple(registers[3 : 3 + len(layers)]), **gloss.indices),
            lobes=tuple(of.constant(register_of.__getitem__) for of in lobes),
            held_out_register=registers[len(terms) - 1] if holes else None,
            **fields,
        )

    def _constant(self, value: Rgb) -> Term:
        return self._op(Code.CONSTANT, value=value)

    def term(self, value: Value) -> Term:
        """In a register, whether it is known now or not."""
        return value if isinstance(value, Term) else self._constant(value)

    def _op(self, code: Code, *operands: Value, **fields: object) -> Term:
        terms = [self.term(operand) for operand in operands]
        if self.beside is not None and code in _OF_PLACES:
            fields |= {"shift": self.beside[0], "value": (self.beside[1], 0.0, 0.0)}
        if "value" in fields:  # what overflowed on the way here
            fields["value"] = nearest_finite(fields["value"])
        key = (code, *terms, *sorted(fields.items()))
        if key not in self._places:
            places = dict(zip(OPERANDS, (term.place for term in terms), strict=False))
            self._places[key] = Term(len(self._ops))
            self._ops.append(SurfaceOp(code=code, out=len(self._ops), **places, **fields))
        return self._places[key]


def _each(combine: Callable[[float, float], float], a: Rgb, b: Rgb) -> Rgb:
    return nearest_finite((combine(a[0], b[0]), combine(a[1], b[1]), combine(a[2], b[2])))


def _same_use(a: TextureUse, b: TextureUse) -> bool:
    return (a.image.key, a.extension, a.interpolation) == (b.image.key, b.extension, b.interpolation)


def _allocate_registers(ops: list[SurfaceOp], results: list[int]) -> tuple[tuple[SurfaceOp, ...], list[int]]:
    """Drops operations that no result reads, and gives a register away after its last reader."""
    needed = _needed(ops, results)
    kept, registers, count = _with_registers(ops, needed, results)
    if count <= _REGISTER_COUNT:
        return kept, registers
    ops, results = _with_constants_at_readers(*_with_long_ways_first(ops, needed, results))
    kept, registers, _ = _with_registers(ops, _needed(ops, results), results)
    return kept, registers


def _read(op: SurfaceOp) -> list[int]:
    return [getattr(op, operand) for operand in OPERANDS[: operand_count(op)]]


def _needed(ops: list[SurfaceOp], results: list[int]) -> set[int]:
    needed = set(results)
    for place in reversed(range(len(ops))):
        if place in needed:
            needed.update(_read(ops[place]))
    return needed


def _with_registers(
    ops: list[SurfaceOp], needed: set[int], results: list[int]
) -> tuple[tuple[SurfaceOp, ...], list[int], int]:
    """And how many there are."""
    last_reader: dict[int, int] = {}
    for place in sorted(needed):
        last_reader.update(dict.fromkeys(_read(ops[place]), place))
    free: list[int] = []
    register_of: dict[int, int] = {}
    register_count = 0
    kept = []
    for place in sorted(needed):
        op = ops[place]
        operands = {name: register_of[read] for name, read in zip(OPERANDS, _read(op), strict=False)}
        free += [register_of[read] for read in set(_read(op)) if last_reader[read] == place and read not in results]
        if free:
            register_of[place] = free.pop()
        else:
            register_of[place] = register_count
            register_count += 1
        kept.append(replace(op, out=register_of[place], **operands))
    return tuple(kept), [register_of[place] for place in results], register_count


def _with_long_ways_first(
    ops: list[SurfaceOp], needed: set[int], results: list[int]
) -> tuple[list[SurfaceOp], list[int]]:
    """The needed ones in another order: of several operands, the one that takes most registers is computed first.

    Based on Sethi and Ullman, The Generation of Optimal Code for Arithmetic Expressions, JACM 17(4), 1970, as if no
    operation had two readers.
    """
    takes: dict[int, int] = {}
    for place in sorted(needed):
        each = sorted((takes[read] for read in set(_read(ops[place]))), reverse=True)
        takes[place] = max([1, *(count + index for index, count in enumerate(each))])
    place_of: dict[int, int] = {}
    ordered: list[SurfaceOp] = []
    waiting = sorted(set(results), key=lambda place: takes[place])
    while waiting:
        place = waiting[-1]
        missing = [read for read in set(_read(ops[place])) if read not in place_of]
        if missing:
            waiting += sorted(missing, key=lambda read: (takes[read], read))
            continue
        waiting.pop()
        if place not in place_of:
            place_of[place] = len(ordered)
            operands = {name: place_of[read] for name, read in zip(OPERANDS, _read(ops[place]), strict=False)}
            ordered.append(replace(ops[place], out=len(ordered), **operands))
    return ordered, [place_of[result] for result in results]


def _with_constants_at_readers(ops: list[SurfaceOp], results: list[int]) -> tuple[list[SurfaceOp], list[int]]:
    """The same operations, with each constant set anew before each of its readers."""
    moved: list[SurfaceOp] = []
    place_of: dict[int, int] = {}

    def placed(place: int) -> int:
        if ops[place].code is not Code.CONSTANT:
            return place_of[place]
        moved.append(replace(ops[place], out=len(moved)))
        return len(moved) - 1

    for place, op in enumerate(ops):
        if op.code is Code.CONSTANT:
            continue
        operands = {name: placed(read) for name, read in zip(OPERANDS, _read(op), strict=False)}
        place_of[place] = len(moved)
        moved.append(replace(op, out=len(moved), **operands))
    return moved, [placed(result) for result in results]
