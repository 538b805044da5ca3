# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's properties hold that is no number."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

_BLENDER_INFINITY = 3.402823e38  #: What its properties make of infinity is a little more.


def are_finite(values: Iterable[float]) -> bool:
    return all(abs(number) < _BLENDER_INFINITY for number in values)
