# SPDX-License-Identifier: GPL-3.0-or-later
"""The number that Object Info calls random: an instance has its own, an object one that its name decides.

Based on: Jenkins, lookup3.c, 2006 (public domain), as blender/cycles v4.5.0, src/util/hash.h hashes two numbers; and on
blender v4.5.0, intern/cycles/blender/object.cpp, for what it hashes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

_BITS = 0xFFFFFFFF
_SEED_OF_ONE = np.uint32((0xDEADBEEF + (1 << 2) + 13) & _BITS)
_SEED_OF_TWO = np.uint32((0xDEADBEEF + (2 << 2) + 13) & _BITS)
#: The last rounds of lookup3: each mixes one of the three by the one before it.
_TURNS = ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24))


def random_number_of(name: str) -> int:
    """32 bits."""
    sum_of_bytes = 0
    for byte in name.encode():
        signed = byte - 256 if byte > 127 else byte  # noqa: PLR2004  as a char
        sum_of_bytes = (sum_of_bytes * 37 + signed) & _BITS
    return _hash_of_two(sum_of_bytes, 0)


def hashes_of_two(count: int) -> NDArray[np.uint32]:
    """Of each number below ``count``, and 0: what Cycles gives hairs by."""
    return _hashes(np.arange(count, dtype=np.uint32), _SEED_OF_TWO)


def hashes_of_one(numbers: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Of each."""
    return _hashes(numbers, _SEED_OF_ONE)


def _hashes(first: NDArray[np.uint32], seed: np.uint32) -> NDArray[np.uint32]:
    """Where all numbers after the first are 0."""
    with np.errstate(over="ignore"):
        rest = np.full(len(first), seed)
        state = [first + seed, rest, rest]
        for target, source, turn in _TURNS:
            turned = (state[source] << np.uint32(turn)) | (state[source] >> np.uint32(32 - turn))
            state[target] = (state[target] ^ state[source]) - turned
    return state[2]


def as_unit_floats(numbers: Sequence[int] | NDArray[np.uint32]) -> NDArray[np.float32]:
    """From 0 to 1, as Cycles rounds them."""
    return np.array(numbers, np.uint32).astype(np.float32) * np.float32(1.0 / _BITS)


def _hash_of_two(first: int, second: int) -> int:
    c = int(_SEED_OF_TWO)
    a, b = (c + first) & _BITS, (c + second) & _BITS
    state = [a, b, c]
    for target, source, turn in _TURNS:
        state[target] = ((state[target] ^ state[source]) - _rotated(state[source], turn)) & _BITS
    return state[2]


def _rotated(number: int, bits: int) -> int:
    return ((number << bits) | (number >> (32 - bits))) & _BITS
