# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders of meshes whose density, emission or colours vary by nodes: media that grids of it modulate.

A shader is linear in each of these inputs, as in the grids of volume objects (`volumes.py`): its coefficients where all
of them are 0 are the mesh's own medium; what it adds where one is 1 is a medium that a grid of this one multiplies. A
colour that varies is three inputs, each of which is its channel times the number that goes with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tyndall import InvalidInput, IoError
from tyndall.closed_meshes import open_edge_count
from tyndall.density_fields import Field, SampledFields, fields_key, sampled
from tyndall.scene_description import Medium, Volume

from .point_places import places_of
from .program import BLACK, Term
from .value_nodes import Domain, ValueReader
from .volume_nodes import difference, medium_of, read_coefficients

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from tyndall.program_points import PointPlace
    from tyndall.scene_description import Instances, Material, Mesh

    from .instances import Placement
    from .materials import MaterialReader
    from .node_graph import Socket
    from .program import Program
    from .reports import Reports
    from .value_nodes import Value

#: Voxels along the side of a cube, at most.
_MOST_VOXELS, _MOST_IN_VIEWPORT = 128, 64


@dataclass(frozen=True, eq=False)
class DensityField:
    """What varies: a program of whose emission one channel is the factor of a medium."""

    program: Material  #: One object for all channels.
    channel: int
    medium: Medium


class FieldReader(ValueReader):
    """A shader's values where those inputs that vary, and in which it is linear, have given values."""

    def __init__(self, at_points: ValueReader) -> None:
        """``at_points`` reads the same material where it varies."""
        super().__init__(at_points.culprit, at_points.reports, at_points.images, Domain.CONSTANT)
        self.values: dict[tuple[Term, int], float] = {}  #: Of those that are not 0.
        self.asked: dict[tuple[Term, int], None] = {}  #: What varies, and its channel, in their order.
        self._at_points = at_points
        self.property_of = at_points.property_of

    @property
    def varying(self) -> Program:
        return self._at_points.program

    def linear_number(self, at: Socket | None) -> Value:
        is_set_here = at is None or not at.is_connected()
        return super().linear_number(at) if is_set_here else self._at_points.number(at)

    def linear_colour(self, at: Socket | None) -> Value:
        is_set_here = at is None or not at.is_connected()
        return super().linear_colour(at) if is_set_here else self._at_points.colour(at)

    def grid(self, name: str) -> Value | None:
        return self._at_points.grid(name)

    def at_place(self, value: Value, channel: int = 0) -> float:
        if not isinstance(value, Term):
            return super().at_place(value, channel)
        self.asked[value, channel] = None
        return self.values.get((value, channel), 0.0)


def read_fields(at_points: ValueReader, shader: Socket, name: str) -> tuple[Medium | None, tuple[DensityField, ...]]:
    """``shader`` is the Volume input of an output node; None for a medium that does nothing where nothing varies."""
    reader = FieldReader(at_points)
    nothing = read_coefficients(reader, shader)
    fields: list[DensityField] = []
    programs: dict[Term, Material] = {}
    for value, channel in tuple(reader.asked):
        reader.values = {(value, channel): 1.0}
        medium = medium_of(difference(read_coefficients(reader, shader), nothing), f"{name}, varying")
        if medium is not None:
            if value not in programs:
                programs[value] = at_points.program.material(name, (BLACK, BLACK, value))
            fields.append(DensityField(programs[value], channel, medium))
    return medium_of(nothing, name), tuple(fields)


@dataclass(frozen=True, eq=False)
class Varying:
    """A mesh in which a volume varies."""

    culprit: str
    name: str
    mesh: Mesh
    fields: list[tuple[DensityField, int]]  #: With the media that they multiply.
    places: Callable[[], Iterable[PointPlace]]


def with_fields(found: list[tuple[Placement, Instances]], materials: MaterialReader) -> list[tuple[Placement, Varying]]:
    """Objects in which a volume varies."""
    drawn = []
    for placement, group in found:
        used = dict.fromkeys(placement.materials)
        fields = [field for material in used for field in materials.fields(material, placement)]
        if fields:
            texture_space = np.array(placement.data.texspace_location), np.array(placement.data.texspace_size)
            places = partial(places_of, placement, texture_space)
            name = placement.object_name
            drawn.append((placement, Varying(f'Object "{name}"', name, group.mesh, fields, places)))
    return drawn


class FieldVolumes:
    """The grids of frames one after another; what the next frame has, too, is kept."""

    def __init__(self) -> None:
        self._kept: dict[str, SampledFields] = {}

    def read(
        self,
        drawn: Iterable[Varying],
        reports: Reports,
        poll: Callable[[], None],
        *,
        is_viewport: bool,
    ) -> tuple[Volume, ...]:
        """``poll`` may raise."""
        kept, self._kept = self._kept, {}
        volumes = []
        most_voxels = _MOST_IN_VIEWPORT if is_viewport else _MOST_VOXELS
        for varying in drawn:
            mesh = varying.mesh
            if open_edge_count(mesh):
                reports.add(varying.culprit, "its varying volume is not drawn: its mesh is open, and has no inside")
                continue
            fields = [
                Field(field.program, field.channel, max(field.medium.sigma_t_per_m())) for field, _ in varying.fields
            ]
            for place in varying.places():
                key = fields_key(fields, mesh, place, most_voxels)
                known = self._kept.get(key) or kept.get(key)
                try:
                    found = self._kept[key] = known or sampled(fields, mesh, place, key, most_voxels, poll)
                except (InvalidInput, IoError) as error:
                    reports.add(varying.culprit, f"its varying volume is not drawn: {error}")
                    continue
                for note in found.notes:
                    reports.add(varying.culprit, note)
                for part, (_, medium) in zip(found.grids, varying.fields, strict=True):
                    if part is None:
                        continue
                    grid, channel = part
                    matrix = place.world_from_object
                    volumes.append(
                        Volume(name=varying.name, grid=grid, channel=channel, world_from_object=matrix, medium=medium)
                    )
        return tuple(volumes)
