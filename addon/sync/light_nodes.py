# SPDX-License-Identifier: GPL-3.0-or-later
"""The node tree of a light: what multiplies its strength."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tyndall.scene_description import Extension, Image, LightTexture, TextureUse

from .node_graph import Socket
from .program import BLACK, WHITE, Value
from .shader_limits import followed

if TYPE_CHECKING:
    from tyndall.scene_description import LightProjection

    from .value_nodes import ValueReader


@followed(otherwise=BLACK)
def emission_value(reader: ValueReader, at: Socket) -> Value:
    """Of a surface input: the colour times strength of its Emission nodes."""
    source = at.source()
    if source.is_bare_shader():
        reader.note_left_out(at)
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
    source = at.source()
    if source.socket.is_output and source.node.type == "LIGHT_FALLOFF":
        return strength_of_falloff(reader, source)
    return reader.number(at)


def strength_of_falloff(reader: ValueReader, at: Socket) -> Value:
    """A Light Falloff node's quadratic output is its strength; what it makes of the distance is not told here."""
    if at.socket.identifier != "Quadratic":
        reader.note(f"{at.socket.name} falloff is drawn as quadratic")
    if reader.number(at.input("Smooth")) != BLACK:
        reader.note(f"{at.node.bl_label} is drawn without its Smooth")
    return reader.number(at.input("Strength"), 1.0)


#: Beyond it, and at it, nothing is left of the light at any distance that a scene has.
_LARGEST_SMOOTH_M2 = 1e12


@dataclass(frozen=True)
class Distance:
    """What a light is multiplied by at a distance d: d to this power, and d^2 / (d^2 + smooth_m2)."""

    power: int = 0
    smooth_m2: float = 0.0


NO_DISTANCE = Distance()
_WHITE = Image(key="white", name="white", pixels=np.ones((1, 1, 4), np.float32), is_srgb=False)


def at_distances(texture: LightTexture | None, distance: Distance, projection: LightProjection) -> LightTexture | None:
    """The same picture, or a white one of this projection, where the light falls off as its nodes say."""
    if distance == NO_DISTANCE:
        return texture
    if texture is None:
        texture = LightTexture(use=TextureUse(image=_WHITE, extension=Extension.EXTEND), projection=projection)
    return replace(texture, distance_power=distance.power, smooth_m2=distance.smooth_m2)


def emission_and_distance(reader: ValueReader, at: Socket) -> tuple[Value, Distance]:
    """As emission_value; a Light Falloff node that is the strength of the only Emission node is told apart from it."""
    emission = at.source()
    if emission.node.type == "EMISSION" and not emission.is_bare_shader():
        falloff = emission.input("Strength").source()
        if falloff.socket.is_output and falloff.node.type == "LIGHT_FALLOFF":
            distance = Distance(
                power=("Quadratic", "Linear", "Constant").index(falloff.socket.identifier),
                smooth_m2=min(max(reader.constant(falloff.input("Smooth")), 0.0), _LARGEST_SMOOTH_M2),
            )
            strength = reader.number(falloff.input("Strength"), 1.0)
            return reader.program.multiply(reader.colour(emission.input("Color")), strength), distance
    return emission_value(reader, at), Distance()
