# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a frame that are rendered elsewhere: view layers and tiles leave here as films, and come back as one frame.

While a part is taken, a final render hands its planes out and Blender's picture stays black. While parts are given, it
shows them instead of rendering: compositor, view transform and file are Blender's, as for any other frame.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .settings import FrameWindow

    Planes = dict[str, NDArray[np.float32]]


@dataclass(frozen=True)
class Tile:
    """One of ``columns`` times ``rows`` equal parts of what a frame renders; 0, 0 is at the left and bottom."""

    column: int
    row: int
    columns: int
    rows: int

    def region_px(self, window: FrameWindow) -> tuple[int, int, int, int]:
        """Raises ValueError where there are more tiles than pixels."""
        x0, y0, x1, y1 = window.region_px
        edges_x = [x0 + (x1 - x0) * i // self.columns for i in (self.column, self.column + 1)]
        edges_y = [y0 + (y1 - y0) * i // self.rows for i in (self.row, self.row + 1)]
        if edges_x[0] == edges_x[1] or edges_y[0] == edges_y[1]:
            raise ValueError(
                f"{self.columns}x{self.rows} tiles are more than the frame of {x1 - x0} x {y1 - y0} pixels has"
            )
        return edges_x[0], edges_y[0], edges_x[1], edges_y[1]

    @property
    def is_all(self) -> bool:
        return self.columns == self.rows == 1


@dataclass
class Taking:
    """What a part is to be of, and its films by view (stereo has several)."""

    scene_name: str
    layer_name: str
    tile: Tile
    films: dict[str, Planes] = field(default_factory=dict)
    stamps: dict[str, str] = field(default_factory=dict)  #: What files say about the picture.


@dataclass
class Giving:
    """Films of all that a scene renders, by layer and view."""

    scene_name: str
    films: dict[tuple[str, str], Planes]
    statistics: dict[str, Any] = field(default_factory=dict)
    stamps: dict[str, dict[str, str]] = field(default_factory=dict)  #: By layer.

    def planes(self, layer_name: str, view_name: str) -> Planes:
        """Raises ValueError for one that is missing: no black layer in its place."""
        if (layer_name, view_name) not in self.films:
            raise ValueError(f'the parts of view layer "{layer_name}" are missing')
        return self.films[layer_name, view_name]


_taking: Taking | None = None
_giving: Giving | None = None


def taken_of(scene_name: str) -> Taking | None:
    """What is asked for of this scene; None: it renders as ever."""
    return _taking if _taking is not None and _taking.scene_name == scene_name else None


def given_for(scene_name: str) -> Giving | None:
    """What this scene shows; None: it renders as ever."""
    return _giving if _giving is not None and _giving.scene_name == scene_name else None


@contextmanager
def taking(part: Taking) -> Iterator[Taking]:
    """While the block runs, renders of the scene fill the part's films."""
    global _taking  # noqa: PLW0603  one process renders one frame at a time
    _taking = part
    try:
        yield part
    finally:
        _taking = None


@contextmanager
def giving(parts: Giving) -> Iterator[None]:
    """While the block runs, renders of the scene show these films."""
    global _giving  # noqa: PLW0603
    _giving = parts
    try:
        yield
    finally:
        _giving = None
