# SPDX-License-Identifier: GPL-3.0-or-later
"""Luminaires' measured intensities, of IES files, as tables of native/shading/op_photometry.hpp.

Based on: ANSI/IES LM-63-02; blender/cycles v3.4.0, v4.5.0 and v5.0.0, src/util/ies.cpp: which angles a file's have in
Cycles, how halves and quadrants are completed, and what it does with files that keep to no standard. Measured in 3.4.1,
4.5.15 and 5.0.1; tests/blender/test_photometry.py compares values.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import Enum, auto
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]

#: A lamp's in Cycles that sends a candela all around: of light of 177.83 lm/W.
WATTS_PER_CANDELA = 4.0 * math.pi / 177.83
_CLOSE_DEG = 1e-4
_FEWEST = 2  #: Angles that have a place between them.
_QUARTER, _HALF, _ROUND = 90.0, 180.0, 360.0
_MOST_VALUES = 1 << 21
#: Of numbers whose curves are found in single precision.
_LARGEST = 1e30
_A, _B, _C = 3, 2, 1  #: Types of photometry.
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


class DamagedFileError(ValueError):
    """An IES file that cannot be read; the message says why."""


class Ends(Enum):
    """How Cycles goes on beyond the first and the last angle, and what else its versions differ in."""

    BLENDER_3 = (
        auto()
    )  #: Round across; down as at the last angle. Files that leave a part of the circle out are damaged.
    BLENDER_4 = auto()  #: With nothing, but for straight down.
    BLENDER_5 = auto()  #: As at the last angle; past the last across as at the one before.


@dataclass(frozen=True)
class Luminaire:
    """Angles of the columns, in degrees around its axis, and in them, from straight down, as Cycles has them."""

    across_deg: FloatArray
    down_deg: FloatArray
    watts: FloatArray  #: (across, down)

    @property
    def is_dark(self) -> bool:
        """Its angles do not rise: Cycles finds no value between them."""
        return any(
            len(angles) < _FEWEST or not (np.diff(angles) > 0.0).all() for angles in (self.across_deg, self.down_deg)
        )

    def table(self, ends: Ends) -> NDArray[np.float32]:
        """For Code.PHOTOMETRY, (n, 4)."""
        per_degree = np.float32(math.pi) / np.float32(180.0)
        across, down = (angles.astype(np.float32) * per_degree for angles in (self.across_deg, self.down_deg))
        columns = _with_ends_across(_with_ends_down(self.watts, self.down_deg, ends), ends)
        fours = np.stack([columns[:, at : at + len(down) - 1] for at in range(4)], axis=-1).reshape(-1, 4)
        head = np.zeros((1 + len(across) + len(down), 4), np.float32)
        head[0, :2] = len(across), len(down)
        head[1:, 0] = np.concatenate([across, down])
        return np.concatenate([head, fours.astype(np.float32)])


def _with_ends_down(watts: FloatArray, down_deg: FloatArray, ends: Ends) -> FloatArray:
    """One row more at each end."""
    nothing = np.zeros_like(watts[:, :1])
    before = nothing if ends is Ends.BLENDER_4 else watts[:, :1]
    if down_deg[0] < _CLOSE_DEG:
        before = watts[:, 1:2]  # as if it were alike on both sides
    after = nothing if ends is Ends.BLENDER_4 else watts[:, -1:]
    return np.concatenate([before, watts, after], axis=1)


def _with_ends_across(watts: FloatArray, ends: Ends) -> FloatArray:
    """One column more at each end."""
    if ends is Ends.BLENDER_3:
        before, after = watts[-2:-1], watts[1:2]
    elif ends is Ends.BLENDER_4:
        before = after = np.zeros_like(watts[:1])
    else:
        before, after = watts[:1], watts[-2:-1]
    return np.concatenate([before, watts, after])


def read_luminaire(text: str, ends: Ends) -> Luminaire:
    """Of a file's text. Raises DamagedFileError."""
    photometry, down, across, candelas = _parsed(text, ends)
    if photometry == _C:
        across, candelas = _type_c(across, candelas, down, ends)
        if ends is Ends.BLENDER_3 and down[0] == _QUARTER:
            down = _HALF - down  # which Cycles 3.x leaves falling
    elif photometry == _B:
        across, down, candelas = _type_b(across, down, candelas, ends)
    elif ends is Ends.BLENDER_3:
        raise DamagedFileError("photometry of type A, which Cycles 3.x does not know")
    else:
        across, down, candelas = _type_a(across, down, candelas)
    return Luminaire(across, down, candelas * WATTS_PER_CANDELA)


def _parsed(text: str, ends: Ends) -> tuple[int, FloatArray, FloatArray, FloatArray]:
    """Type, angles down and across, and candelas, (across, down)."""
    head, found, rest = text.replace("\r\n", "\n").replace(",", " ").partition("\nTILT=")
    if not found:
        raise DamagedFileError("it has no line TILT=" if head.strip() else "it is empty")
    has_tilt = rest.startswith("INCLUDE")
    body = rest.removeprefix("INCLUDE") if has_tilt else rest.partition("\n")[2]
    numbers = _numbers(body, must_go_on=ends is Ends.BLENDER_3)
    if has_tilt:  # which Cycles does not follow
        _take(numbers, 1)
        _take(numbers, 2 * _count(_take(numbers, 1)[0]))
    _, _, factor, down_count, across_count, photometry, *_ = _take(numbers, 10)
    by_ballast, by_lamp, _ = _take(numbers, 3)
    if photometry not in {_A, _B, _C}:
        raise DamagedFileError(f"photometry of an unknown type ({photometry:g})")
    counts = _count(across_count), _count(down_count)
    if 0 in counts or counts[0] * counts[1] > _MOST_VALUES:
        raise DamagedFileError(f"{counts[0]} x {counts[1]} angles")
    down, across = _take(numbers, counts[1]), _take(numbers, counts[0])
    candelas = _take(numbers, counts[0] * counts[1]).reshape(counts) * (factor * by_ballast * by_lamp)
    if not all((np.abs(values) <= _LARGEST).all() for values in (down, across, candelas)):
        raise DamagedFileError("it has a number beyond all measure")
    return int(photometry), down, across, candelas


def _numbers(text: str, *, must_go_on: bool) -> Iterator[float]:
    """``must_go_on``: the last one is none where the text ends with it."""
    at = 0
    while True:
        while at < len(text) and text[at].isspace():
            at += 1
        found = _NUMBER.match(text, at)
        if found is None or (must_go_on and found.end() == len(text)):
            return
        at = found.end()
        yield float(found.group())


def _take(numbers: Iterator[float], count: int) -> FloatArray:
    taken = np.array(list(islice(numbers, count)), np.float64)
    if len(taken) < count:
        raise DamagedFileError("it ends too early, or has something in it that is no number")
    if not np.isfinite(taken).all():
        raise DamagedFileError("it has a number that is not finite")
    return taken


def _count(number: float) -> int:
    if not (0 <= number <= _MOST_VALUES and number == int(number)):
        raise DamagedFileError(f"{number:g} is not a number of angles")
    return int(number)


def _is_close(a: float, b: float) -> bool:
    return abs(a - b) < _CLOSE_DEG


def _type_c(across: FloatArray, candelas: FloatArray, down: FloatArray, ends: Ends) -> tuple[FloatArray, FloatArray]:
    """A polar axis upright: parts of the circle are completed by their mirror images."""
    if _is_close(across[0], _QUARTER):
        across = across - _QUARTER
    if len(across) == 1:
        across, candelas = np.array([0.0, _ROUND]), np.repeat(candelas, 2, axis=0)
    for end in (_QUARTER, _HALF):
        if _is_close(across[-1], end):
            across = np.concatenate([across, 2.0 * end - across[-2::-1]])
            candelas = np.concatenate([candelas, candelas[-2::-1]])
    if _is_close(across[0], 0.0) and not _is_close(across[-1], _ROUND):
        gap = _ROUND - across[-1]
        if _is_close(gap, across[-1] - across[-2]) or _is_close(gap, across[1] - across[0]):
            across, candelas = np.append(across, _ROUND), np.concatenate([candelas, candelas[:1]])
    if ends is Ends.BLENDER_3:
        if across[0] != 0.0 or across[-1] != _ROUND:
            raise DamagedFileError("a part of the circle is left out")
        if down[0] != 0.0 and not (down[0] == _QUARTER and down[-1] == _HALF):
            raise DamagedFileError("it starts neither straight down nor at the horizon")
    return across, candelas


def _type_b(
    across: FloatArray, down: FloatArray, candelas: FloatArray, ends: Ends
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A polar axis that lies: Cycles takes angles across for those down, and the other way round."""
    across, down, candelas = down, across, candelas.T
    is_old = ends is Ends.BLENDER_3
    if is_old and not (across[-1] == down[-1] == _QUARTER):
        raise DamagedFileError("its angles do not end at 90 degrees")
    if _is_close(across[0], 0.0):
        across, candelas = np.concatenate([-across[:0:-1], across]), np.concatenate([candelas[:0:-1], candelas])
    across = across + _QUARTER
    if is_old:
        across, candelas = np.append(across, _ROUND), np.concatenate([candelas, candelas[:1]])
    if _is_close(down[0], 0.0):
        # Cycles 3.x mirrors the values one angle beside the angles.
        mirrored = candelas[:, -2::-1] if is_old else candelas[:, :0:-1]
        down, candelas = np.concatenate([-down[:0:-1], down]), np.concatenate([mirrored, candelas], axis=1)
    return across, down + _QUARTER, candelas


def _type_a(across: FloatArray, down: FloatArray, candelas: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A polar axis upright, angles from the horizon, and across from before it to both sides."""
    turned, values = _HALF - across[::-1], candelas[::-1]
    if _is_close(across[0], 0.0):
        turned, values = np.concatenate([turned, _HALF + across[1:]]), np.concatenate([values, candelas[1:]])
    return turned, down + _QUARTER, values
