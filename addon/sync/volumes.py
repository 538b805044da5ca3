# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of grids: volume objects and smoke, one description per object, grid and instance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tyndall import InvalidInput, IoError
from tyndall.grid_programs import combined, combined_key
from tyndall.program_points import asks_of_instances
from tyndall.scene_description import DensityGrid, Volume, attribute_maps

from .grid_media import read_grid_media
from .point_places import places_of
from .volume_nodes import IGNORES_RAY_VISIBILITY
from .volume_sources import NoVolumeError, source_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from tyndall.program_points import PointPlace
    from tyndall.scene_description import Material, Medium

    from .field_media import DensityField
    from .images import ImageReader
    from .instances import Placement
    from .materials import MaterialReader
    from .reports import Reports
    from .volume_sources import VolumeSource


@dataclass(frozen=True, eq=False)
class _DrawnMedium:
    """Of the scene as soon as something has it: light is prepared for all media that there are."""

    medium: Medium
    materials: MaterialReader

    @cached_property
    def index(self) -> int:
        return self.materials.add_medium(self.medium)


@dataclass(frozen=True, eq=False)
class _ShaderMedia:
    """What a shader makes of a volume's grids."""

    of_grids: dict[str, _DrawnMedium]
    fields: dict[int, list[tuple[DensityField, _DrawnMedium]]]  #: Of one program each, by its identity.


class VolumeReader:
    """Reads the volumes of frames one after another; keeps the grids that the next frame may share."""

    def __init__(self) -> None:
        self._grids: dict[str, DensityGrid] = {}  # by key
        self._made: dict[int, tuple[VolumeSource, set[int]]] = {}  # by address of evaluated data, while that lives

    def forget_stale(self, stale: set[int] | None) -> None:
        """What depends on these datablocks may be others now; None: all evaluated data may be."""
        self._made = {
            address: (source, depends_on)
            for address, (source, depends_on) in self._made.items()
            if stale is not None and not depends_on & stale
        }

    def read(
        self,
        placements: list[Placement],
        materials: MaterialReader,
        images: ImageReader,
        reports: Reports,
        poll: Callable[[], None],
    ) -> tuple[Volume, ...]:
        """One per object, grid that its shader reads, and instance; their media go into ``materials``."""
        kept: dict[str, DensityGrid] = {}
        made: dict[int, tuple[VolumeSource, set[int]]] = {}
        media: dict[tuple[tuple[str, ...], tuple[str, ...], int], _ShaderMedia] = {}
        volumes = []
        for placement in placements:
            poll()
            culprit = f'Object "{placement.object_name}"'
            address = placement.data.as_pointer()
            try:
                source = (made.get(address) or self._made.get(address) or (source_of(placement),))[0]
            except NoVolumeError as error:
                reports.add(culprit, f"not drawn: {error}")
                continue
            if source.outlives_read:
                made[address] = source, placement.depends_on
            material = materials.shader_of(placement.materials[0])
            key = source.grid_names, source.vector_names, material.as_pointer() if material else 0
            if key not in media:
                of_shader = read_grid_media(material, source.grid_names, source.vector_names, images, reports)
                media[key] = _ShaderMedia(
                    {name: _DrawnMedium(medium, materials) for name, medium in of_shader.of_grids.items()}, {}
                )
                for field in of_shader.fields:
                    of_program = media[key].fields.setdefault(id(field.program), [])
                    of_program.append((field, _DrawnMedium(field.medium, materials)))
            if not (media[key].of_grids or media[key].fields):
                reports.add(culprit, "its volume's shader reads none of its grids: not drawn")
            if not (placement.is_camera_visible and placement.casts_shadow):
                reports.add(culprit, IGNORES_RAY_VISIBILITY)
            frame = _Frame(placement, source, culprit, reports, self._grids, kept)
            for name, medium in media[key].of_grids.items():
                volumes += frame.of_grid(name, medium)
            for fields in media[key].fields.values():
                volumes += frame.of_fields(fields, poll)
        self._grids, self._made = kept, made
        return tuple(volumes)


@dataclass(frozen=True, eq=False)
class _Frame:
    """Where one volume is drawn, and what is known of its grids."""

    placement: Placement
    source: VolumeSource
    culprit: str
    reports: Reports
    before: dict[str, DensityGrid]  #: Of the last frame, by key.
    kept: dict[str, DensityGrid]  #: Of this one.

    def of_grid(self, name: str, medium: _DrawnMedium) -> list[Volume]:
        (grid,) = self._read(name) or (None,)
        if grid is None:
            return []
        if self._are_empty({name: (grid,)}):
            return []
        return [self._volume(grid, matrix, medium.index) for matrix in self.placement.world_from_object()]

    def of_fields(self, fields: list[tuple[DensityField, _DrawnMedium]], poll: Callable[[], None]) -> list[Volume]:
        """Of one program. Each instance has grids of its own only where the program asks what these are."""
        program = fields[0][0].program
        asked = set(program.uv_maps)
        every = [*self.source.grid_names, *self.source.vector_names]
        names = [name for name in every if not asked.isdisjoint(attribute_maps(name))]
        names = names or every[:1]  # what asks for none fills where there is one
        if not names:
            self.reports.add(self.culprit, "not drawn: it has no grid that can be read")
            return []
        grids = {name: found for name in names if (found := self._read(name))}
        if len(grids) < len(names) or self._are_empty(grids):
            return []
        volumes: list[Volume] = []
        made: list[DensityGrid] = []
        for place in places_of(self.placement, self.source.texture_space):
            try:
                if not made or asks_of_instances(program):
                    made = self._made(program, place, grids, [field.channel for field, _ in fields], poll)
            except (IoError, InvalidInput) as error:
                self.reports.add(self.culprit, f"not drawn: {error}")
                return []
            volumes += [
                self._volume(grid, place.world_from_object, medium.index)
                for grid, (_, medium) in zip(made, fields, strict=True)
                if len(grid.grid.leaf_origins)
            ]
        return volumes

    def _are_empty(self, grids: dict[str, tuple[DensityGrid, ...]]) -> bool:
        """Whether none of them has a leaf, which is reported."""
        if any(len(grid.grid.leaf_origins) for of_name in grids.values() for grid in of_name):
            return False
        advice = f": {self.source.advice_if_empty}" if self.source.advice_if_empty else ""
        for name in grids:
            self.reports.add(self.culprit, f'its grid "{name}" is empty{advice}')
        return True

    def _made(
        self,
        program: Material,
        place: PointPlace,
        grids: dict[str, tuple[DensityGrid, ...]],
        channels: list[int],
        poll: Callable[[], None],
    ) -> list[DensityGrid]:
        key = combined_key(program, place, grids)
        keys = [f"{key} {channel}" for channel in channels]
        known = [self.kept.get(key) or self.before.get(key) for key in keys]
        made = [grid for grid in known if grid is not None]
        if len(made) < len(keys):
            notes: list[str] = []
            found = combined(program, place, grids, channels, self.source.voxel_shift, notes, poll)
            made = [DensityGrid(key=key, grid=grid) for key, grid in zip(keys, found, strict=True)]
            for note in notes:
                self.reports.add(self.culprit, note)
        self.kept.update(zip(keys, made, strict=True))
        return made

    def _read(self, name: str) -> tuple[DensityGrid, ...]:
        """One, or those of a vector; none, with a report, where they cannot be read."""
        known = self.before | self.kept
        try:
            is_vector = name in self.source.vector_names
            grids = self.source.read_vector(name, known) if is_vector else (self.source.read(name, known),)
        except (IoError, InvalidInput) as error:
            self.reports.add(self.culprit, f"not drawn: {error}")
            return ()
        self.kept.update((grid.key, grid) for grid in grids)
        return grids

    def _volume(self, grid: DensityGrid, world_from_object: NDArray[np.float64], medium: int) -> Volume:
        shift = np.eye(4)
        shift[:3, 3] = grid.grid.local_from_index[:3, :3] @ np.full(3, self.source.voxel_shift)
        # As Cycles: what a vector of equal parts becomes is the object's scale.
        scale = float(np.linalg.norm(world_from_object[:3, :3] @ np.full(3, 3.0**-0.5)))
        return Volume(
            name=self.placement.object_name,
            grid=grid,
            world_from_object=world_from_object @ shift,
            medium=medium,
            density_scale=1.0 / scale if self.source.keeps_opacity and scale > 0.0 else 1.0,
        )
