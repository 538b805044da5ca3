# SPDX-License-Identifier: GPL-3.0-or-later
"""The node tree of a light: what multiplies its strength."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .images import ImageReader
from .node_graph import Socket, output_input
from .value_nodes import Domain, ValueReader

if TYPE_CHECKING:
    import bpy
    from numpy.typing import NDArray

    from .reports import Reports


def emission_of_light(light: bpy.types.Light, reports: Reports, culprit: str) -> NDArray[np.float64]:
    """(3,), the colour times strength of constant Emission nodes; 1 for a light without nodes."""
    surface = output_input(light.node_tree if light.use_nodes else None, "Surface")
    if surface is None:
        return np.ones(3)
    return _emission(ValueReader(culprit, reports, ImageReader(), Domain.CONSTANT), surface)


def _emission(reader: ValueReader, at: Socket) -> NDArray[np.float64]:
    source = at.source()
    if not source.socket.is_output:
        return np.zeros(3)
    node_type = source.node.type
    if node_type == "EMISSION":
        colour = np.array(reader.constant_colour(source.input("Color")), np.float64)
        return np.multiply(colour, _strength(reader, source.input("Strength")))
    if node_type == "ADD_SHADER":
        return sum((_emission(reader, shader) for shader in source.inputs()[:2]), np.zeros(3))
    if node_type == "MIX_SHADER":
        share, first, second = source.inputs()[:3]
        share_of_second = min(max(reader.constant(share), 0.0), 1.0)
        return _emission(reader, first) * (1.0 - share_of_second) + _emission(reader, second) * share_of_second
    if source.socket.type != "SHADER":
        return np.array(reader.constant_colour(at))
    reader.unsupported(source, "does not light: read as white")
    return np.ones(3)


def _strength(reader: ValueReader, at: Socket) -> float:
    """A Light Falloff node's quadratic output is its strength; its others cannot be told from it here."""
    source = at.source()
    if source.socket.is_output and source.node.type == "LIGHT_FALLOFF":
        if source.socket.identifier != "Quadratic":
            reader.note(f"{source.socket.name} falloff is drawn as quadratic")
        return reader.constant(source.input("Strength"), 1.0)
    return reader.constant(at)
