# SPDX-License-Identifier: GPL-3.0-or-later
"""What a world's program is: one turned image times a colour, or what only a run for each direction tells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tyndall.direction_programs import radiance_towards
from tyndall.scene_description import Code, Image, Interpolation
from tyndall.surface_inputs import EnvironmentProjection
from tyndall.surface_operations import OPERANDS, is_known_without_point, operand_count, run_on_answers

from .program import BLACK, Program, Term, Value

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tyndall.scene_description import Material, SurfaceOp

_SMALLEST = 1e-6
#: Vectors this far from 0 along each axis are colours that nothing clamps.
_OFFSET = 16.0
_LEAST_WIDTH, _LARGEST_WIDTH = 1024, 8192  #: 0.35 degrees a texel; 1 GiB
#: Images that are encoded are interpolated before they are decoded. Those that are wider change little between texels;
#: others are drawn so many times as wide, up to what takes half a second.
_MOST_ENCODED_WIDTH, _TIMES_ENCODED, _DECODED_WIDTH = 1024, 4, 2048


@dataclass(frozen=True)
class TurnedImage:
    """Radiance is the factor times the image."""

    image: Image
    image_from_world: NDArray[np.float64]
    factor: tuple[float, float, float]


def as_turned_image(program: Program, background: Value) -> TurnedImage | None:
    """None where it is anything else."""
    if not isinstance(background, Term):
        return None
    ops = program.ops
    places = _read_by(ops, background.place)
    lookups = [place for place in places if ops[place].code is Code.ENVIRONMENT_AT]
    of_vectors = set[int]().union(*(_read_by(ops, ops[place].a) for place in lookups))
    if len(lookups) != 1 or any(
        place not in of_vectors and place not in lookups and not is_known_without_point(ops[place]) for place in places
    ):
        return None
    material = program.material("", (BLACK, BLACK, background))
    lookup, use = ops[lookups[0]], material.textures[ops[lookups[0]].texture]
    if lookup.option != EnvironmentProjection.EQUIRECTANGULAR or use.interpolation is not Interpolation.LINEAR:
        return None
    if _bends_between_texels(use.image):
        return None
    turn = linear_map(program, Term(lookup.a))
    if turn is None or not np.allclose(turn @ turn.T, np.eye(3), atol=1e-5):
        return None
    factor = _factor(material)
    return None if factor is None else TurnedImage(use.image, turn, factor)


def _bends_between_texels(image: Image) -> bool:
    return image.is_srgb and image.shape[1] <= _MOST_ENCODED_WIDTH


def _factor(material: Material) -> tuple[float, float, float] | None:
    """By which the program multiplies what its image shows; None where it does anything else with it."""
    dark, grey, light, bright = (_with_texel(material, texel) for texel in (0.0, 0.5, 1.0, 3.0))
    each = [_with_texel(material, np.eye(3)[channel]) for channel in range(3)]
    if dark.any() or not np.allclose(grey, light / 2) or not np.allclose(bright, 3.0 * light):
        return None
    return (float(light[0]), float(light[1]), float(light[2])) if np.allclose(each, np.diag(light)) else None


def _with_texel(material: Material, texel: object) -> NDArray[np.float64]:
    """What comes out where the image shows this."""
    answers = {
        place: np.broadcast_to(np.asarray(texel, np.float32), (1, 3)).copy()
        for place, op in enumerate(material.program)
        if not is_known_without_point(op)
    }
    shown: NDArray[np.float64] = run_on_answers(material, material.emission_register, answers, 1)[0].astype(np.float64)
    return shown


def linear_map(program: Program, vector: Value) -> NDArray[np.float64] | None:
    """The 3x3 matrix by which a vector comes from a direction; None where there is no such matrix."""
    if not isinstance(vector, Term):
        return None
    shifted = program.material("", (BLACK, BLACK, program.add(vector, (_OFFSET,) * 3)))
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    others = np.random.default_rng(1).normal(size=(16, 3))
    others /= np.linalg.norm(others, axis=1, keepdims=True)
    found = radiance_towards(shifted, np.concatenate([axes, others])) - _OFFSET
    matrix = found[:3].T
    is_linear = np.allclose(found[3:6], -found[:3], atol=1e-4) and np.allclose(found[6:], others @ matrix.T, atol=1e-4)
    return matrix if is_linear and abs(np.linalg.det(matrix)) > _SMALLEST else None


def image_width(program: Program, background: Value, *, has_sharp_disc: bool) -> int:
    """Of an equirectangular image, twice as wide as high, that holds what the program shows."""
    if not isinstance(background, Term):
        return 1
    if has_sharp_disc:
        return 4096
    width = _LEAST_WIDTH
    textures = program.material("", (BLACK, BLACK, background)).textures
    for place in _read_by(program.ops, background.place):
        op = program.ops[place]
        if op.code is Code.ENVIRONMENT_AT:
            image = textures[op.texture].image
            own = image.shape[1]
            width = max(width, min(_TIMES_ENCODED * own, _DECODED_WIDTH) if _bends_between_texels(image) else own)
    return min(width, _LARGEST_WIDTH)


def _read_by(ops: Sequence[SurfaceOp], place: int) -> set[int]:
    """The places of all operations that one depends on, itself included."""
    found, waiting = set[int](), [place]
    while waiting:
        here = waiting.pop()
        if here not in found:
            found.add(here)
            waiting += [getattr(ops[here], operand) for operand in OPERANDS[: operand_count(ops[here])]]
    return found
