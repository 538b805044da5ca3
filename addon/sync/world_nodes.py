# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of worlds: their points are directions, one metre from the origin, and face it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.surface_inputs import PointInput

from .coordinates import point_input
from .domains import Domain
from .program import BLACK, Value
from .sky_nodes import SunDisc, sky_value
from .value_nodes import ValueReader, is_place

if TYPE_CHECKING:
    from .images import ImageReader
    from .node_graph import Socket
    from .reports import Reports


class WorldReader(ValueReader):
    """Notes the discs of suns that it comes by, and draws them into the sky or not."""

    def __init__(self, culprit: str, reports: Reports, images: ImageReader, *, draws_discs: bool) -> None:
        super().__init__(culprit, reports, images, Domain.SURFACE)
        self.draws_discs = draws_discs
        self.discs: list[SunDisc] = []

    def vector(self, at: Socket | None, default: Value = BLACK) -> Value:
        if is_place(at):
            return point_input(self.program, PointInput.POSITION)
        return self.colour(at, default)

    def _evaluated(self, at: Socket) -> Value:
        kind, output = at.node.type, at.socket.identifier
        if kind == "TEX_SKY":
            return sky_value(self, at)
        if kind == "TEX_COORD" and output == "Generated":
            return point_input(self.program, PointInput.POSITION)
        if (kind == "TEX_COORD" and output in {"Camera", "Window"}) or kind == "CAMERA":
            self.unsupported(at, "has no camera in a world: read as 0")
            return BLACK
        if kind in {"ATTRIBUTE", "VERTEX_COLOR"}:
            self.unsupported(at, "is read as 0 in a world")
            return BLACK
        return super()._evaluated(at)
