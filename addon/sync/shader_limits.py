# SPDX-License-Identifier: GPL-3.0-or-later
"""How far mixed and added shaders are followed: files may mix them in a circle, or in more ways than can be counted.

A shader that feeds both inputs of the next is read once for each way to it, 2^40 times in a row of forty.
"""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

    from .value_nodes import ValueReader

Result = TypeVar("Result")
_MOST_DEEP = 100  #: Shaders mixed into each other: Python's stack has room for a few hundred.
_MOST_SHADERS = 2000  #: Of one tree, each counted once for each way to it.


class ShaderCount:
    """What one reader has followed."""

    def __init__(self) -> None:
        self.depth = self.count = 0


def followed(otherwise: Result) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """What reads a shader and those that feed it: beyond the limits ``otherwise`` comes in its place, with a note."""

    def decorate(read: Callable[..., Result]) -> Callable[..., Result]:
        @wraps(read)
        def guarded(reader: ValueReader, *arguments: object) -> Result:
            shaders = reader.shaders
            if shaders.depth >= _MOST_DEEP or shaders.count >= _MOST_SHADERS:
                reader.note("its shaders are mixed in a circle, too deeply, or in too many ways: the rest is left out")
                return otherwise
            shaders.depth, shaders.count = shaders.depth + 1, shaders.count + 1
            try:
                return read(reader, *arguments)
            finally:
                shaders.depth -= 1

        return guarded

    return decorate
