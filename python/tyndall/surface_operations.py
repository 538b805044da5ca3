# SPDX-License-Identifier: GPL-3.0-or-later
"""What is true of operations of surface programs, and their values where no point is needed: asked of the native side.

The names are Blender's, at the place of the number that the native side knows the operation by (shading/op_math.hpp).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, SupportsIndex, SupportsInt

from . import _native
from .scene_description import Code, Rgb, SurfaceOp

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from .scene_description import Material

OPERANDS = "abcdef"  #: Fields of SurfaceOp.
#: SurfaceOp.option of Code.MATH.
MATH_OPERATIONS = (
    "DIVIDE", "POWER", "LOGARITHM", "SQRT", "INVERSE_SQRT", "ABSOLUTE", "EXPONENT", "MINIMUM", "MAXIMUM", "LESS_THAN",
    "GREATER_THAN", "SIGN", "COMPARE", "SMOOTH_MIN", "SMOOTH_MAX", "ROUND", "FLOOR", "CEIL", "TRUNC", "FRACT",
    "MODULO", "FLOORED_MODULO", "WRAP", "SNAP", "PINGPONG", "SINE", "COSINE", "TANGENT", "ARCSINE", "ARCCOSINE",
    "ARCTANGENT", "ARCTAN2", "SINH", "COSH", "TANH", "RADIANS", "DEGREES", "CLAMP_MINMAX", "CLAMP_RANGE",
)  # fmt: skip
#: SurfaceOp.option of Code.VECTOR_MATH.
VECTOR_OPERATIONS = (
    "CROSS_PRODUCT", "PROJECT", "REFLECT", "REFRACT", "FACEFORWARD", "DOT_PRODUCT", "DISTANCE", "LENGTH", "NORMALIZE",
    "DIVIDE", "SNAP", "FLOOR", "CEIL", "MODULO", "FRACTION", "ABSOLUTE", "POWER", "SIGN", "MINIMUM", "MAXIMUM", "WRAP",
    "SINE", "COSINE", "TANGENT",
)  # fmt: skip
#: SurfaceOp.option of Code.MAP_RANGE; its selector: numbers, vectors, clamped vectors.
RANGES = ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")
#: SurfaceOp.option of Code.BLEND.
BLENDS = (
    "SCREEN", "OVERLAY", "DIVIDE", "DIFFERENCE", "EXCLUSION", "DARKEN", "LIGHTEN", "DODGE", "BURN", "HUE", "SATURATION",
    "VALUE", "COLOR", "SOFT_LIGHT", "LINEAR_LIGHT",
)  # fmt: skip
#: SurfaceOp.option of Code.COMBINE and Code.SEPARATE.
COLOUR_MODELS = ("HSV", "HSL")

_LARGEST = 3e38


def build_op(op: SurfaceOp) -> _native.SurfaceOp:
    """The same operation in native memory."""
    """The same operation in native memory."""
    return _native.SurfaceOp(
        code=int(op.code),
        out=op.out,
        a=op.a,
        b=op.b,
        c=op.c,
        d=op.d,
        e=op.e,
        f=op.f,
        option=op.option,
        selector=op.selector,
        texture=op.texture,
        uv_map=op.uv_map,
        table=op.table,
        shift=op.shift,
        value=op.value,
        uv_matrix=op.uv_matrix,
    )


def operand_count(op: SurfaceOp) -> int:
    """The first so many of its operands are read."""
    return _facts(op.code, op.option, op.selector)[0]


def is_known_without_point(op: SurfaceOp) -> bool:
    """Whether operands and a table are all that it reads."""
    return _facts(op.code, op.option, op.selector)[1]


@cache
def _facts(code: Code, option: int, selector: int) -> tuple[int, bool]:
    facts: tuple[int, bool] = _native.operation_facts(
        build_op(SurfaceOp(code=code, out=0, option=option, selector=selector))
    )
    return facts


def value_of(op: SurfaceOp, operands: Sequence[Rgb], tables: Sequence[NDArray[np.float32]] = ()) -> Rgb:
    """The value of an operation that is known without a point; what is not finite becomes the nearest that is."""
    on_first = replace(op, value=nearest_finite(op.value), out=len(operands), a=0, b=1, c=2, d=3, e=4, f=5)
    constants = [
        SurfaceOp(code=Code.CONSTANT, out=place, value=nearest_finite(value)) for place, value in enumerate(operands)
    ]
    native = _build_program([*constants, on_first], tables)
    return nearest_finite(_native.run_on_answers(native, len(operands), {}, 1)[0].tolist())


def nearest_finite(value: Sequence[float]) -> Rgb:
    """The nearest colour that single precision has; 0 for what is no number."""
    red, green, blue = value
    return _finite(red), _finite(green), _finite(blue)


def run_on_answers(
    material: Material, result: int, answers: dict[SupportsInt | SupportsIndex, NDArray[Any]], count: int
) -> NDArray[np.float32]:
    """What a register of its program holds at each of ``count`` points, (count, 3).

    ``answers`` are what operations read of images, UV maps and points, each (count, 3), by place in the program.
    Raises InvalidInput where one is missing.
    """
    ops = [
        SurfaceOp(code=Code.CONSTANT, out=op.out) if place in answers else op
        for place, op in enumerate(material.program)
    ]
    native = _build_program(ops, material.tables)
    values: NDArray[np.float32] = _native.run_on_answers(native, result, answers, count)
    return values


def _build_program(ops: Sequence[SurfaceOp], tables: Sequence[NDArray[np.float32]]) -> _native.Material:
    return _native.Material(
        name="program",
        has_surface=True,
        diffuse=(0.0, 0.0, 0.0),
        transparent=(0.0, 0.0, 0.0),
        emission=(0.0, 0.0, 0.0),
        program=[build_op(op) for op in ops],
        diffuse_register=0,
        transparent_register=0,
        emission_register=0,
        held_out=0.0,
        held_out_register=None,
        textures=[],
        uv_maps=(),
        tables=list(tables),
        gloss=None,
        lobes=[],
        medium=-1,
    )


def _finite(number: float) -> float:
    return 0.0 if math.isnan(number) else min(max(number, -_LARGEST), _LARGEST)
