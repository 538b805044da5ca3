# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders as homogeneous media, or as media that a volume object's grids modulate, as Cycles reads them.

Where nodes vary a density, strength, colour, temperature or the factor of a mix, `field_media.py` says by how much; all
other varying inputs are read as 0.5 or mid grey, with a note.
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
from .colour_tables import colour_at, of_blackbody
from .math_nodes import math_operation
from .phase_functions import RAYLEIGH, draine, fournier_forand, mie
from .program import BLACK, WHITE, Term, grey
from .shader_limits import followed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .instances import Placement
    from .materials import MaterialReader
    from .node_graph import Socket
    from .phase_functions import Phase, Shares
    from .program import Value
    from .reports import Reports
    from .value_nodes import ValueReader

    Rgb64 = NDArray[np.float64]

IGNORES_RAY_VISIBILITY = "ray visibility does not reach its volume, which the camera sees and which dims light"


def note_hidden_medium(placement: Placement, materials: MaterialReader, reports: Reports) -> None:
    """Of a mesh that holds one."""
    is_hidden = not (placement.is_camera_visible and placement.casts_shadow)
    if is_hidden and any(materials.has_medium(index) for index in materials.indices(placement)):
        reports.add(f'Object "{placement.object_name}"', IGNORES_RAY_VISIBILITY)


@dataclass(eq=False)
class Coefficients:
    """Sums over the shaders of one volume; each entry (3,), per metre."""

    scatter: list[tuple[Rgb64, Phase]] = field(default_factory=list)  #: sigma_s and how it is spread.
    absorption: Rgb64 = field(default_factory=lambda: np.zeros(3))
    emission: Rgb64 = field(default_factory=lambda: np.zeros(3))

    def lobes(self) -> dict[Phase, Rgb64]:
        """By phase function: sigma_s, (3,)."""
        lobes: dict[Phase, Rgb64] = {}
        for sigma_s, phase in self.scatter:
            lobes[phase] = lobes.get(phase, np.zeros(3)) + sigma_s
        return lobes

    def add_scatter(self, sigma_s: Rgb64, shares: Shares) -> None:
        """What the shares lack of 1 is dimmed, and not seen again."""
        self.scatter += [(share * sigma_s, phase) for share, phase in shares]
        self.absorption = self.absorption + max(1.0 - sum(share for share, _ in shares), 0.0) * sigma_s


def read_coefficients(reader: ValueReader, at: Socket) -> Coefficients:
    """``at`` is the Volume input of an output node."""
    coefficients = Coefficients()
    _add(reader, at, WHITE, coefficients)
    return coefficients


def medium_of(coefficients: Coefficients, name: str) -> Medium | None:
    """None for a medium that does nothing."""
    lobes = {phase: sigma_s for phase, sigma_s in coefficients.lobes().items() if sigma_s.any()}
    if not lobes and not (coefficients.absorption.any() or coefficients.emission.any()):
        return None
    return Medium(
        name=name,
        lobes=tuple(
            ScatterLobe(sigma_s_per_m=_rgb(sigma_s), asymmetry_g=phase.asymmetry_g, draine_alpha=phase.draine_alpha)
            for phase, sigma_s in lobes.items()
        ),
        sigma_a_per_m=_rgb(coefficients.absorption),
        emission_w_per_m3_sr=_rgb(coefficients.emission),
    )


def _rgb(channels: Rgb64) -> tuple[float, float, float]:
    red, green, blue = (float(channel) for channel in channels)
    return red, green, blue


@followed(otherwise=None)
def _add(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    source = at.source()
    if source.is_bare_shader() or weight == BLACK:
        reader.note_left_out(at)
        return
    if source.socket.type != "SHADER":  # a colour in place of a shader glows
        coefficients.emission += _product(reader, _glow_weight(reader, weight), reader.linear_colour(at))
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
        scatter=[
            (np.maximum(sigma_s - before.get(phase, np.zeros(3)), 0.0), phase)
            for phase, sigma_s in here.lobes().items()
        ],
        absorption=np.maximum(here.absorption - nothing.absorption, 0.0),
        emission=np.maximum(here.emission - nothing.emission, 0.0),
    )


def _product(reader: ValueReader, amount: Value, tint: Value) -> Rgb64:
    """A number times a colour, where the reader answers; nothing of either below 0."""
    if not isinstance(tint, Term):
        return max(reader.at_place(amount), 0.0) * np.maximum(tint, 0.0)
    product = reader.varying.multiply(amount, tint)
    return np.maximum([reader.at_place(product, channel) for channel in range(3)], 0.0)


def _glow_weight(reader: ValueReader, weight: Value) -> Value:
    """In 3.x the factor of a Mix Shader gives each of two all of its emission, unless it gives nothing."""
    if bpy.app.version >= (4, 0, 0):
        return weight
    return math_operation(reader.varying, "GREATER_THAN", weight, BLACK)


def _of_grid(reader: ValueReader, at: Socket, attribute: str, value: Value) -> Value:
    """Times the grid that a Principled Volume names; the value alone, where there is none."""
    name = at.input(attribute)
    grid = reader.grid(name.socket.default_value) if name is not None else None
    return value if grid is None else reader.varying.multiply(value, grid)


def _phase(reader: ValueReader, at: Socket) -> Shares:
    phase = getattr(at.node, "phase", "HENYEY_GREENSTEIN")  # 4.3 added others
    if phase == "RAYLEIGH":
        return RAYLEIGH
    if phase == "MIE":
        return mie(reader.constant(at.input("Diameter")))
    if phase == "FOURNIER_FORAND":
        return fournier_forand(reader.constant(at.input("Backscatter")), reader.constant(at.input("IOR")))
    asymmetry = reader.constant(at.input("Anisotropy"))
    if phase == "DRAINE":
        return draine(asymmetry, reader.constant(at.input("Alpha")))
    if phase != "HENYEY_GREENSTEIN":
        reader.note(f"phase function {phase.replace('_', ' ').lower()} is read as Henyey-Greenstein")
    return draine(asymmetry)


def _scatter(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    density = reader.varying.multiply(weight, reader.linear_number(at.input("Density")))
    tint = reader.linear_colour(at.input("Color"))
    coefficients.add_scatter(_product(reader, density, tint), _phase(reader, at))


def _absorption(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    density = reader.varying.multiply(weight, reader.linear_number(at.input("Density")))
    tint = reader.linear_colour(at.input("Color"))
    coefficients.absorption += _product(reader, density, reader.varying.complement(tint))


def _principled(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    program = reader.varying
    density = _of_grid(reader, at, "Density Attribute", reader.linear_number(at.input("Density")))
    density = program.multiply(weight, density)
    tint = _of_grid(reader, at, "Color Attribute", reader.linear_colour(at.input("Color")))
    coefficients.add_scatter(_product(reader, density, tint), _phase(reader, at))
    coefficients.absorption += _absorbed(reader, density, tint, reader.linear_colour(at.input("Absorption Color")))
    glow_weight = _glow_weight(reader, weight)  # whatever the density
    strength = program.multiply(glow_weight, reader.linear_number(at.input("Emission Strength")))
    coefficients.emission += _product(reader, strength, reader.linear_colour(at.input("Emission Color")))
    coefficients.emission += _flame(reader, at, glow_weight)


def _absorbed(reader: ValueReader, density: Value, tint: Value, absorption: Value) -> Rgb64:
    """What the colours lack. The square root makes the absorption colour act evenly over its range."""
    program = reader.varying
    lacks = program.complement(tint)
    if not isinstance(absorption, Term):
        kept = np.sqrt(np.maximum(absorption, 0.0))
        return _product(reader, density, lacks) * np.maximum(1.0 - kept, 0.0)
    channels = (program.channel(absorption, channel) for channel in range(3))
    roots = program.combine([math_operation(program, "SQRT", channel) for channel in channels])
    return _product(reader, density, program.multiply(lacks, program.complement(roots)))


def _flame(reader: ValueReader, at: Socket, weight: Value) -> Rgb64:
    """Stefan-Boltzmann, in Cycles' units of a millionth, between colour only and the full fourth power."""
    share = reader.constant(at.input("Blackbody Intensity"))
    if share <= 0.0:
        return np.zeros(3)
    program = reader.varying
    temperature = _of_grid(reader, at, "Temperature Attribute", reader.linear_number(at.input("Temperature")))
    temperature_k = math_operation(program, "MAXIMUM", temperature, BLACK)
    colour = (
        colour_at(program, of_blackbody(), temperature_k)
        if isinstance(temperature_k, Term)
        else blackbody(temperature_k[0])
    )
    square = program.multiply(temperature_k, temperature_k)
    power = program.add(grey(1.0 - share), program.multiply(grey(share), program.multiply(square, square)))
    radiance = program.multiply(grey(5.670373e-8 * 1e-6 / math.pi), power)
    tint = program.multiply(colour, reader.linear_colour(at.input("Blackbody Tint")))
    return _product(reader, program.multiply(weight, radiance), tint)


def _volume_coefficients(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    def read(name: str) -> Rgb64:
        return _product(reader, weight, reader.linear_colour(at.input(name)))

    coefficients.add_scatter(read("Scatter Coefficients"), _phase(reader, at))
    coefficients.absorption += read("Absorption Coefficients")
    coefficients.emission += read("Emission Coefficients")


def _emission(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    strength = reader.varying.multiply(_glow_weight(reader, weight), reader.linear_number(at.input("Strength")))
    coefficients.emission += _product(reader, strength, reader.linear_colour(at.input("Color")))


def _mix_shader(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    share, first, second = at.inputs()[:3]
    program = reader.varying
    share_of_second = program.clamp(reader.linear_number(share))
    _add(reader, first, program.multiply(weight, program.complement(share_of_second)), coefficients)
    _add(reader, second, program.multiply(weight, share_of_second), coefficients)


def _add_shader(reader: ValueReader, at: Socket, weight: Value, coefficients: Coefficients) -> None:
    for shader in at.inputs()[:2]:
        _add(reader, shader, weight, coefficients)


_SHADERS: dict[str, Callable[[ValueReader, Socket, Value, Coefficients], None]] = {
    "VOLUME_SCATTER": _scatter,
    "VOLUME_ABSORPTION": _absorption,
    "PRINCIPLED_VOLUME": _principled,
    "VOLUME_COEFFICIENTS": _volume_coefficients,
    "EMISSION": _emission,
    "MIX_SHADER": _mix_shader,
    "ADD_SHADER": _add_shader,
}
