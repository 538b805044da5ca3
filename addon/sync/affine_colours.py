# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours that depend on one image as an offset and a matrix: what a light's texture can be, whatever nodes made it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from tyndall.scene_description import Code, SurfaceOp

from .program import Program, Term, Value

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class AffineColour:
    """``offset + gain @ texture``; no texture: the offset alone."""

    offset: NDArray[np.float64]  #: (3,)
    gain: NDArray[np.float64] = field(default_factory=lambda: np.zeros((3, 3)))
    texture: SurfaceOp | None = None

    def times(self, weight: NDArray[np.float64]) -> AffineColour:
        """Per channel; ``weight`` has the shape (3,)."""
        return AffineColour(self.offset * weight, self.gain * weight[:, None], self.texture)


class _Bends(Exception):  # noqa: N818  ends the walk through a program
    pass


def affine_colour(program: Program, value: Value) -> AffineColour | None:
    """None for a value of more than one texture, or one that bends what it reads."""
    try:
        return _of_value(program, value)
    except _Bends:
        return None


def _of_value(program: Program, value: Value) -> AffineColour:
    if not isinstance(value, Term):
        return AffineColour(np.array(value, np.float64))
    op = program.ops[value.place]
    if op.code is Code.CONSTANT:
        return AffineColour(np.array(op.value, np.float64))
    if op.code is Code.TEXTURE:
        return AffineColour(np.zeros(3), np.eye(3), op)
    if op.code not in _COMBINED:
        raise _Bends
    count, combine = _COMBINED[op.code]
    return combine(*(_of_value(program, Term(place)) for place in (op.a, op.b, op.c)[:count]))


def _sum(a: AffineColour, b: AffineColour) -> AffineColour:
    if a.texture is not None and b.texture is not None and a.texture != b.texture:
        raise _Bends
    return AffineColour(a.offset + b.offset, a.gain + b.gain, a.texture or b.texture)


def _difference(a: AffineColour, b: AffineColour) -> AffineColour:
    return _sum(a, b.times(-np.ones(3)))


def _product(a: AffineColour, b: AffineColour) -> AffineColour:
    if b.texture is None:
        return a.times(b.offset)
    if a.texture is None:
        return b.times(a.offset)
    raise _Bends


def _clamp(a: AffineColour) -> AffineColour:
    """Of an image in [0, 1]: it must leave the colour as it is."""
    low = a.offset + np.minimum(a.gain, 0.0).sum(axis=1)
    high = a.offset + np.maximum(a.gain, 0.0).sum(axis=1)
    slack = 1e-4  # weights of luminance are as many digits from 1
    if (low < -slack).any() or (high > 1.0 + slack).any():
        raise _Bends
    return a


def _average(a: AffineColour) -> AffineColour:
    return AffineColour(np.full(3, a.offset.mean()), np.tile(a.gain.mean(axis=0), (3, 1)), a.texture)


def _mix(a: AffineColour, b: AffineColour, share_of_b: AffineColour) -> AffineColour:
    return _sum(a, _product(_difference(b, a), _clamp(share_of_b)))


_COMBINED: dict[Code, tuple[int, Callable[..., AffineColour]]] = {
    Code.AVERAGE: (1, _average),
    Code.CLAMP: (1, _clamp),
    Code.ADD: (2, _sum),
    Code.SUBTRACT: (2, _difference),
    Code.MULTIPLY: (2, _product),
    Code.MIX: (3, _mix),
}
