# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders as homogeneous media, or as media that a volume object's grids modulate, as Cycles reads them.

Where nodes vary a density, an emission's strength or a colour, `field_media.py` says by how much; other varying inputs
are read as 0.5 or mid grey, with a note.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.scene_description import Medium, ScatterLobe

from .blackbody import blackbody
from .shader_limits import followed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .node_graph import Socket
    from .value_nodes import ValueReader

    Rgb64 = NDArray[np.float64]

IGNORES_RAY_VISIBILITY = "ray visibility does not reach its volume, which the camera sees and which dims light"
_LARGEST_ASYMMETRY = 0.999  #: Cycles, too, keeps away from the limit, at which all light goes straight on.


@dataclass(eq=False)
class Coefficients:
    """Sums over the shaders of one volume; each entry (3,), per metre."""

    scatter: list[tuple[Rgb64, float]] = field(default_factory=list)  #: sigma_s and asymmetry.
    absorption: Rgb64 = field(default_factory=lambda: np.zeros(3))
    emission: Rgb64 = field(default_factory=lambda: np.zeros(3))

    def lobes(self) -> dict[float, Rgb64]:
        """By asymmetry: sigma_s, (3,)."""
        lobes: dict[float, Rgb64] = {}
        for sigma_s, asymmetry in self.scatter:
            lobes[asymmetry] = lobes.get(asymmetry, np.zeros(3)) + sigma_s
        return lobes


def read_volume(reader: ValueReader, at: Socket, name: str) -> Medium | None:
    """``at`` is the Volume input of an output node; None for a medium that does nothing."""
    return medium_of(read_coefficients(reader, at), name)


def read_coefficients(reader: ValueReader, at: Socket) -> Coefficients:
    """The same before it is a medium."""
    coefficients = Coefficients()
    _add(reader, at, 1.0, coefficients)
    return coefficients


def medium_of(coefficients: Coefficients, name: str) -> Medium | None:
    """None for a medium that does nothing."""
    lobes = {g: sigma_s for g, sigma_s in coefficients.lobes().items() if sigma_s.any()}
    if not lobes and not (coefficients.absorption.any() or coefficients.emission.any()):
        return None
    return Medium(
        name=name,
        lobes=tuple(ScatterLobe(sigma_s_per_m=_rgb(sigma_s), asymmetry_g=g) for g, sigma_s in lobes.items()),
        sigma_a_per_m=_rgb(coefficients.absorption),
        emission_w_per_m3_sr=_rgb(coefficients.emission),
    )


def _rgb(channels: Rgb64) -> tuple[float, float, float]:
    red, green, blue = (float(channel) for channel in channels)
    return red, green, blue


@followed(otherwise=None)
def _add(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    source = at.source()
    if source.is_bare_shader() or weight == 0.0:
        reader.note_left_out(at)
        return
    if source.socket.type != "SHADER":  # a colour in place of a shader glows
        coefficients.emission += weight * np.array(reader.constant_colour(at))
        return
    add = _SHADERS.get(source.node.type)
    if add is None:
        reader.unsupported(source, "is not a volume shader: left out")
        return
    add(reader, source, weight, coefficients)


def difference(here: Coefficients, nothing: Coefficients) -> Coefficients:
    """What there is more of; not below 0."""
    before = nothing.lobes()
    return Coefficients(
        scatter=[(np.maximum(sigma_s - before.get(g, np.zeros(3)), 0.0), g) for g, sigma_s in here.lobes().items()],
        absorption=np.maximum(here.absorption - nothing.absorption, 0.0),
        emission=np.maximum(here.emission - nothing.emission, 0.0),
    )


def _factor(reader: ValueReader, at: Socket | None) -> float:
    """Of an input in which the shader is linear."""
    field = reader.field_value(at)
    return reader.constant(at) if field is None else field


def _colour(reader: ValueReader, at: Socket, name: str = "Color") -> Rgb64:
    return np.array(reader.constant_colour(at.input(name)))


def _tinted(
    reader: ValueReader, at: Socket, number: str, colour: str = "Color", *, is_complement: bool = False
) -> Rgb64:
    """A number times a colour, or times what the colour lacks; nothing of either below 0."""
    varying = reader.field_colour(at.input(number), at.input(colour), is_complement=is_complement)
    if varying is not None:
        return np.maximum(varying, 0.0)
    tint = _colour(reader, at, colour)
    return max(_factor(reader, at.input(number)), 0.0) * np.maximum(1.0 - tint if is_complement else tint, 0.0)


def _asymmetry(reader: ValueReader, at: Socket) -> float:
    phase = getattr(at.node, "phase", "HENYEY_GREENSTEIN")
    if phase != "HENYEY_GREENSTEIN":  # 4.3 added others
        reader.note(f"phase function {phase.replace('_', ' ').lower()} is read as Henyey-Greenstein")
        if phase == "RAYLEIGH":
            return 0.0
    asymmetry = reader.constant(at.input("Anisotropy"))
    return min(max(asymmetry, -_LARGEST_ASYMMETRY), _LARGEST_ASYMMETRY)


def _scatter(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    coefficients.scatter.append((weight * _tinted(reader, at, "Density"), _asymmetry(reader, at)))


def _absorption(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    coefficients.absorption += weight * _tinted(reader, at, "Density", is_complement=True)


def _principled(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    density = weight * _grid_density(reader, at)
    coefficients.scatter.append((density * _tinted(reader, at, "Density"), _asymmetry(reader, at)))
    # The square root makes the absorption colour act evenly over its range.
    kept = np.sqrt(np.maximum(_colour(reader, at, "Absorption Color"), 0.0))
    lacks = _tinted(reader, at, "Density", is_complement=True)
    coefficients.absorption += density * lacks * np.maximum(1.0 - kept, 0.0)
    # Emission does not depend on density; nor, in 3.x, on the factor of a Mix Shader.
    emission_weight = weight if bpy.app.version >= (4, 0, 0) else 1.0
    coefficients.emission += emission_weight * _tinted(reader, at, "Emission Strength", "Emission Color")
    coefficients.emission += emission_weight * _flame(reader, at)


def _grid_density(reader: ValueReader, at: Socket) -> float:
    """1 for a volume without the grid that the node names."""
    name = at.input("Density Attribute")
    density = reader.grid_value(name.socket.default_value) if name is not None else None
    return 1.0 if density is None else max(density, 0.0)


def _flame(reader: ValueReader, at: Socket) -> Rgb64:
    """Stefan-Boltzmann, in Cycles' units of a millionth, between colour only and the full fourth power."""
    share = reader.constant(at.input("Blackbody Intensity"))
    if share <= 0.0:
        return np.zeros(3)
    temperature_k = max(reader.constant(at.input("Temperature")), 0.0)
    radiance = 5.670373e-8 * 1e-6 / math.pi * ((1.0 - share) + share * temperature_k**4)
    colour: Rgb64 = _colour(reader, at, "Blackbody Tint") * np.array(blackbody(temperature_k))
    return radiance * colour


def _volume_coefficients(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    sigma_s = weight * np.maximum(_colour(reader, at, "Scatter Coefficients"), 0.0)
    coefficients.scatter.append((sigma_s, _asymmetry(reader, at)))
    coefficients.absorption += weight * np.maximum(_colour(reader, at, "Absorption Coefficients"), 0.0)
    coefficients.emission += weight * _colour(reader, at, "Emission Coefficients")


def _emission(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    coefficients.emission += weight * _tinted(reader, at, "Strength")


def _mix_shader(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    share, first, second = at.inputs()[:3]
    share_of_second = min(max(reader.constant(share), 0.0), 1.0)
    _add(reader, first, weight * (1.0 - share_of_second), coefficients)
    _add(reader, second, weight * share_of_second, coefficients)


def _add_shader(reader: ValueReader, at: Socket, weight: float, coefficients: Coefficients) -> None:
    for shader in at.inputs()[:2]:
        _add(reader, shader, weight, coefficients)


_SHADERS: dict[str, Callable[[ValueReader, Socket, float, Coefficients], None]] = {
    "VOLUME_SCATTER": _scatter,
    "VOLUME_ABSORPTION": _absorption,
    "PRINCIPLED_VOLUME": _principled,
    "VOLUME_COEFFICIENTS": _volume_coefficients,
    "EMISSION": _emission,
    "MIX_SHADER": _mix_shader,
    "ADD_SHADER": _add_shader,
}
