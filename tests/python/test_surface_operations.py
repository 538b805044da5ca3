# SPDX-License-Identifier: GPL-3.0-or-later
"""Operations of surface programs by name: both sides count alike, and constants fold to what programs compute."""

from __future__ import annotations

import numpy as np
import pytest

from tyndall import InvalidInput
from tyndall.scene_description import Code, Material, SurfaceOp
from tyndall.surface_operations import (
    BLENDS,
    COLOUR_MODELS,
    MATH_OPERATIONS,
    RANGES,
    VECTOR_OPERATIONS,
    is_known_without_point,
    operand_count,
    run_on_answers,
    value_of,
)


@pytest.mark.parametrize(
    ("code", "names"),
    [
        (Code.MATH, MATH_OPERATIONS),
        (Code.VECTOR_MATH, VECTOR_OPERATIONS),
        (Code.MAP_RANGE, RANGES),
        (Code.BLEND, BLENDS),
        (Code.SEPARATE, COLOUR_MODELS),
    ],
)
def test_both_sides_know_as_many_kinds(code: Code, names: tuple[str, ...]) -> None:
    for option in range(len(names)):
        assert operand_count(SurfaceOp(code=code, out=0, option=option)) > 0
    with pytest.raises(InvalidInput):
        operand_count(SurfaceOp(code=code, out=0, option=len(names)))


def test_names_are_at_their_numbers() -> None:
    def number(name: str, *operands: float) -> float:
        op = SurfaceOp(code=Code.MATH, out=0, option=MATH_OPERATIONS.index(name))
        return value_of(op, [(one, one, one) for one in operands])[0]

    assert number("DIVIDE", 3.0, 4.0) == 0.75
    assert number("COMPARE", 1.0, 1.25, 0.5) == 1.0
    assert number("FLOORED_MODULO", -1.0, 3.0) == 2.0
    assert number("ARCTAN2", 0.0, -1.0) == pytest.approx(np.pi)
    assert number("DEGREES", np.pi) == pytest.approx(180.0)
    assert number("CLAMP_RANGE", 5.0, 3.0, 1.0) == 3.0
    blend = SurfaceOp(code=Code.BLEND, out=0, option=BLENDS.index("LINEAR_LIGHT"))
    assert value_of(blend, [(0.5, 0.5, 0.5), (1.0, 0.5, 0.0), (1.0, 1.0, 1.0)]) == (1.5, 0.5, -0.5)


def test_what_is_not_finite_folds_to_a_number_that_a_program_may_hold() -> None:
    exponent = SurfaceOp(code=Code.MATH, out=0, option=MATH_OPERATIONS.index("EXPONENT"))
    assert 1e38 < value_of(exponent, [(1e4, 1e4, 1e4)])[0] < np.inf


def test_answers_stand_for_images() -> None:
    assert not is_known_without_point(SurfaceOp(code=Code.TEXTURE, out=0))
    program = (
        SurfaceOp(code=Code.TEXTURE, out=0),
        SurfaceOp(code=Code.CONSTANT, out=1, value=(2.0, 3.0, -4.0)),
        SurfaceOp(code=Code.MULTIPLY, out=2, a=0, b=1),
    )
    texels = np.random.default_rng(1).uniform(size=(5000, 3)).astype(np.float32)
    found = run_on_answers(Material(name="painted", program=program), 2, {0: texels}, 5000)
    assert (found == texels * np.array((2.0, 3.0, -4.0), np.float32)).all()
    with pytest.raises(InvalidInput, match="reads texture 0 of 0"):
        run_on_answers(Material(name="painted", program=program), 2, {}, 5000)
