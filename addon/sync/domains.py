# SPDX-License-Identifier: GPL-3.0-or-later
"""What values may vary over, and what stands for one that cannot be had."""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

from .program import Value, grey

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .value_nodes import ValueReader

    Evaluate = Callable[[ValueReader, Socket], Value]

MID_GREY: Value = grey(0.5)  #: Stands for what cannot be evaluated.


class Domain(Enum):
    """What values may vary over."""

    SURFACE = auto()  #: And directions, of worlds.
    LIGHT = auto()  #: Directions, through images.
    CONSTANT = auto()  #: Media.


def on_surfaces(evaluate: Evaluate) -> Evaluate:
    """Elsewhere the node is mid grey, with a note."""

    def guarded(reader: ValueReader, at: Socket) -> Value:
        if reader.domain is Domain.SURFACE:
            return evaluate(reader, at)
        reader.unsupported(at, "is not supported: read as mid grey")
        return MID_GREY

    return guarded
