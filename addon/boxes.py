# SPDX-License-Identifier: GPL-3.0-or-later
"""An axis-aligned box as a mesh."""

from itertools import product
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

#: Into the corners below; outward.
BOX_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def box_corners(lowest: "Iterable[float]", highest: "Iterable[float]") -> list[tuple[float, ...]]:
    """Eight of them, z fastest and x slowest."""
    return list(product(*zip(lowest, highest, strict=True)))
