# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders of volume objects as media that grids modulate.

One that is linear in each grid, and multiplies none with another, makes one medium of each grid, which its densities
multiply. Of all others, a program says for each voxel what the grids, and where the voxel lies, make of a coefficient.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tyndall.scene_description import Medium, ScatterLobe

from ..shader_nodes import shader_tree
from .field_media import DensityField, read_fields
from .node_graph import output_input
from .program import BLACK, WHITE, Value, grey
from .reports import Reports
from .value_nodes import Domain, ValueReader
from .volume_nodes import Coefficients, difference, medium_of, read_coefficients

if TYPE_CHECKING:
    from bpy.types import Material

    from .images import ImageReader
    from .node_graph import Socket

#: Of the Volume Info node, by output.
_VOLUME_INFO = {"Density": "density", "Color": "color", "Flame": "flame", "Temperature": "temperature"}
#: Of a volume without a material, in Cycles.
_DEFAULT_MEDIUM = Medium(
    name="(no material)", lobes=(ScatterLobe(sigma_s_per_m=(0.5, 0.5, 0.5)),), sigma_a_per_m=(0.5, 0.5, 0.5)
)
_BEND = 1e-6  #: Relative: what a shader may be off a straight line to be taken for one.


@dataclass(frozen=True, eq=False)
class GridMedia:
    """What a shader makes of a volume's grids."""

    of_grids: dict[str, Medium]  #: Which each multiplies as it is.
    fields: tuple[DensityField, ...] = ()  #: Which programs multiply.


class _AtGrids(ValueReader):
    """A shader's values where a volume's grids are known by name."""

    def __init__(
        self, material: Material, reports: Reports, images: ImageReader, domain: Domain, names: tuple[str, ...]
    ) -> None:
        super().__init__(f'Material "{material.name}"', reports, images, domain)
        self.material_index = material.pass_index
        self._names = names

    def _evaluated(self, at: Socket) -> Value:
        if at.node.type == "ATTRIBUTE":
            return self._attribute(at.node.attribute_name, at.socket.identifier)
        if at.node.type == "VOLUME_INFO" and at.socket.identifier in _VOLUME_INFO:
            return self._attribute(_VOLUME_INFO[at.socket.identifier], at.socket.identifier)
        return super()._evaluated(at)

    def _attribute(self, name: str, output: str) -> Value:
        value = self.grid(name)
        if value is None:
            self.note(f'the volume has no grid "{name}": read as 0')
            return BLACK
        if output == "Alpha":
            return WHITE
        return self.program.average(value) if output == "Fac" else value


class _NumberReader(_AtGrids):
    """Where the grids of numbers have given values."""

    def __init__(self, material: Material, reports: Reports, images: ImageReader, names: tuple[str, ...]) -> None:
        super().__init__(material, reports, images, Domain.CONSTANT, names)
        self.values: dict[str, float] = {}  #: Of the grids that are not 0.
        self.asked: dict[str, None] = {}  #: Names of grids that the shader reads, in their order.

    def grid(self, name: str) -> Value | None:
        if name not in self._names:
            return None
        self.asked[name] = None
        return grey(self.values.get(name, 0.0))

    def _output(self, at: Socket) -> Value:
        return self._evaluated(at)  # anew: the grids' values change


class _PlaceReader(_AtGrids):
    """Where grids vary from voxel to voxel, and with them the place."""

    def __init__(self, material: Material, reports: Reports, images: ImageReader, names: tuple[str, ...]) -> None:
        super().__init__(material, reports, images, Domain.SURFACE, names)

    def grid(self, name: str) -> Value | None:
        return self.program.attribute(name) if name in self._names else None


def read_grid_media(
    material: Material | None,
    numbers: tuple[str, ...],
    vectors: tuple[str, ...],
    images: ImageReader,
    reports: Reports,
) -> GridMedia:
    """Of a volume with grids of these names."""
    if material is None:
        return GridMedia({"density": _DEFAULT_MEDIUM} if "density" in numbers else {})
    tree = shader_tree(material)
    shader = output_input(tree, "Volume") if tree is not None else None
    if shader is None or not shader.is_connected():
        return GridMedia({})
    places = _PlaceReader(material, reports, images, (*numbers, *vectors))
    unread = Reports()  # read once more for places, where there is anything to say
    reader = _NumberReader(material, unread, images, numbers)
    coefficients = read_coefficients(reader, shader)
    linear = _linear_media(reader, shader, coefficients, material.name)
    if linear is not None and not unread.lines():
        nothing, found = medium_of(coefficients, material.name), GridMedia(linear)
    else:
        nothing, fields = read_fields(places, shader, material.name)
        found = GridMedia({}, fields)
    if nothing is not None:
        places.note("what does not depend on a grid has no bounds in a volume object: left out")
    return found


def _linear_media(reader: _NumberReader, shader: Socket, nothing: Coefficients, name: str) -> dict[str, Medium] | None:
    """Per grid that the shader reads: its medium where the grid is 1 and the others are 0; None: it bends.

    ``nothing``: where all of them are 0.
    """

    def beyond(values: dict[str, float]) -> Coefficients:
        reader.values = values
        return difference(read_coefficients(reader, shader), nothing)

    found, alone = {}, Coefficients()
    for grid in tuple(reader.asked):
        once = beyond({grid: 1.0})
        _add(alone, once)
        if any(_distance(beyond({grid: value}), once, value) > _BEND for value in (0.25, 2.0)):
            return None
        medium = medium_of(once, f"{name}, {grid}")
        if medium is not None:
            found[grid] = medium
    together = beyond(dict.fromkeys(reader.asked, 1.0))
    return None if _distance(together, alone, 1.0) > _BEND else found


def _add(total: Coefficients, part: Coefficients) -> None:
    total.scatter += part.scatter
    total.absorption = total.absorption + part.absorption
    total.emission = total.emission + part.emission


def _distance(a: Coefficients, b: Coefficients, times: float) -> float:
    """Relative, of ``a`` from ``times`` of ``b``."""

    def numbers(of: Coefficients) -> np.ndarray:
        return np.concatenate([sum((s for s, _ in of.scatter), np.zeros(3)), of.absorption, of.emission])

    first, second = numbers(a), times * numbers(b)
    return float(np.abs(first - second).max() / max(np.abs(first).max(), np.abs(second).max(), 1e-30))
