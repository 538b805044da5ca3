# SPDX-License-Identifier: GPL-3.0-or-later
"""The node tree of a light: what multiplies its strength."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .node_graph import Socket
from .program import BLACK, WHITE, Value
from .shader_limits import followed

if TYPE_CHECKING:
    from .value_nodes import ValueReader


@followed(otherwise=BLACK)
def emission_value(reader: ValueReader, at: Socket) -> Value:
    """Of a surface input: the colour times strength of its Emission nodes."""
    source = at.source()
    if source.is_bare_shader():
        return BLACK
    node_type, program = source.node.type, reader.program
    if node_type == "EMISSION":
        return program.multiply(reader.colour(source.input("Color")), _strength(reader, source.input("Strength")))
    if node_type == "ADD_SHADER":
        first, second = source.inputs()[:2]
        return program.add(emission_value(reader, first), emission_value(reader, second))
    if node_type == "MIX_SHADER":
        share, first, second = source.inputs()[:3]
        return program.mix(emission_value(reader, first), emission_value(reader, second), reader.number(share))
    if source.socket.type != "SHADER":
        return reader.colour(at)
    reader.unsupported(source, "does not light: read as white")
    return WHITE


def _strength(reader: ValueReader, at: Socket) -> Value:
    """A Light Falloff node's quadratic output is its strength; its others cannot be told from it here."""
    source = at.source()
    if source.socket.is_output and source.node.type == "LIGHT_FALLOFF":
        if source.socket.identifier != "Quadratic":
            reader.note(f"{source.socket.name} falloff is drawn as quadratic")
        return reader.number(source.input("Strength"), 1.0)
    return reader.number(at)
