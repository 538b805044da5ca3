# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that trace rays from the point: Ambient Occlusion and Bevel. Without rays all is open, and nothing round."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tyndall.scene_description import Code
from tyndall.surface_inputs import OCCLUSION_IS_INSIDE, OCCLUSION_IS_ONLY_LOCAL, PointInput

from . import coordinates
from .domains import on_surfaces
from .normal_nodes import own_or_linked
from .program import BLACK, WHITE, Term, Value, grey

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .value_nodes import ValueReader


def _normal_input(reader: ValueReader, at: Socket) -> Value:
    """The surface's own is the same beside the point: heights of bumps that ask for it ask once."""
    linked = own_or_linked(reader, at.input("Normal"))
    if linked is not None:
        return linked
    outer, reader.program.beside = reader.program.beside, None
    own = coordinates.point_input(reader.program, PointInput.NORMAL)
    reader.program.beside = outer
    return own


def _ambient_occlusion(reader: ValueReader, at: Socket) -> Value:
    share = _open_share(reader, at)
    if at.socket.identifier == "Color":
        return reader.program.multiply(reader.colour(at.input("Color")), share)
    return share


def _open_share(reader: ValueReader, at: Socket) -> Value:
    if reader.occlusion_reach_m is None:
        if reader.misses_surroundings:
            reader.unsupported(at, "is read as fully open")
        return WHITE
    reach = reader.number(at.input("Distance"), 1.0)
    if reach == BLACK:  # only where it is known now: what varies may become 0, and nothing is near enough
        reach = grey(reader.occlusion_reach_m)
    if not isinstance(reach, Term) and reach[0] <= 0.0:
        return WHITE
    node = at.node
    option = (OCCLUSION_IS_INSIDE if node.inside else 0) | (OCCLUSION_IS_ONLY_LOCAL if node.only_local else 0)
    normal = _normal_input(reader, at)
    return reader.program.operation(Code.AMBIENT_OCCLUSION, reach, normal, option=option, selector=node.samples)


def _bevel(reader: ValueReader, at: Socket) -> Value:
    normal = _normal_input(reader, at)
    if reader.occlusion_reach_m is None:
        if reader.misses_surroundings:
            reader.unsupported(at, "passes its normal on")
        return normal
    radius = reader.number(at.input("Radius"), 0.05)
    if not isinstance(radius, Term) and radius[0] <= 0.0:
        return normal
    return reader.program.operation(Code.BEVEL, radius, normal, selector=at.node.samples)


NODES: dict[str, Callable[[ValueReader, Socket], Value]] = {
    "AMBIENT_OCCLUSION": on_surfaces(_ambient_occlusion),
    "BEVEL": on_surfaces(_bevel),
}
