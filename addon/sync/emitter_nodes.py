# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes in the tree of a light, whose shader Cycles asks at points that no mesh has and from no camera.

What its shader knows there was measured in 3.4.1, 4.5.15 and 5.0.1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.surface_inputs import PointInput

from .coordinates import point_input
from .domains import Domain
from .light_nodes import strength_of_falloff
from .program import BLACK, Value, grey
from .value_nodes import ValueReader, is_place

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from .images import ImageReader
    from .node_graph import Socket
    from .reports import Reports

    Read = Callable[["EmitterReader", Socket], Value | None]


IS_OBJECT = bpy.app.version >= (4, 0, 0)  #: Lights are objects to their shaders.


class EmitterReader(ValueReader):
    """Evaluates a light's nodes as a surface's; notes what changes with more than its picture has."""

    def __init__(
        self, culprit: str, kind: str, nodes: Mapping[str, Read], reports: Reports, images: ImageReader
    ) -> None:
        super().__init__(culprit, reports, images, Domain.SURFACE)
        self.kind = kind  #: "an area light", or what else it is.
        self._nodes = nodes  #: Each gives what its node is on the light; None: the same as on surfaces.

    def place(self) -> Value:
        """What textures are read at that have no vector."""
        return point_input(self.program, PointInput.OBJECT_POSITION)

    def vector(self, at: Socket | None, default: Value = BLACK) -> Value:
        if is_place(at):
            return self.place()
        return self.colour(at, default)

    def _evaluated(self, at: Socket) -> Value:
        read = self._nodes.get(at.node.type)
        value = None if read is None else read(self, at)
        return super()._evaluated(at) if value is None else value


def _of_meshes(reader: EmitterReader, at: Socket) -> Value:
    """Lights have no attributes."""
    reader.unsupported(at, f"{at.socket.name} is read as 0 in {reader.kind}")
    return BLACK


def _object_info(_: EmitterReader, at: Socket) -> Value | None:
    """Up to 3.x lights are no objects, but have their random number."""
    output = at.socket.identifier
    return BLACK if output == "Material Index" or not (IS_OBJECT or output == "Random") else None


def _bent_normal(reader: EmitterReader, at: Socket) -> Value:
    reader.unsupported(at, "is read as the light's normal")
    return point_input(reader.program, PointInput.NORMAL)


def _light_path(reader: EmitterReader, at: Socket) -> Value:
    """Of light that is looked for, Cycles answers no to all questions; one bounce lies behind it."""
    output = at.socket.identifier
    if output == "Ray Depth":
        return grey(1.0)
    if output != "Is Camera Ray":
        reader.unsupported(at, f"{at.socket.name} is read as 0: all rays see {reader.kind} alike")
    return BLACK


def _uv_map(_: EmitterReader, at: Socket) -> Value | None:
    return BLACK if at.node.uv_map else None  # as in Cycles: it has no map of a name


NODES: dict[str, Read] = {
    **dict.fromkeys(("ATTRIBUTE", "VERTEX_COLOR", "TANGENT", "HAIR_INFO", "WIREFRAME", "PARTICLE_INFO"), _of_meshes),
    **dict.fromkeys(("BUMP", "NORMAL_MAP"), _bent_normal),
    "OBJECT_INFO": _object_info,
    "LIGHT_PATH": _light_path,
    "LIGHT_FALLOFF": strength_of_falloff,
    "UVMAP": _uv_map,
}
