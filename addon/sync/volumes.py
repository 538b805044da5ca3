# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes, whose grids modulate the media of a volume shader.

A shader is asked for its coefficients where all grids are 0, and where one of them is 1. Cycles' shaders mostly are
linear in each grid, so that each makes one medium, which its densities multiply. What bends, or depends on two at once,
is noted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall import InvalidInput, IoError
from tyndall.scene_description import DensityGrid, Medium, ScatterLobe, Volume

from ..shader_nodes import shader_tree
from .node_graph import output_input
from .program import BLACK, Value, grey
from .value_nodes import Domain, ValueReader
from .volume_nodes import IGNORES_RAY_VISIBILITY, Coefficients, difference, medium_of, read_coefficients
from .volume_sources import NoVolumeError, source_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Material

    from .images import ImageReader
    from .instances import Placement
    from .materials import MaterialReader
    from .node_graph import Socket
    from .reports import Reports
    from .volume_sources import VolumeSource

#: Of the Volume Info node, by output.
_VOLUME_INFO = {"Density": "density", "Color": "color", "Flame": "flame", "Temperature": "temperature"}
#: Of a volume without a material, in Cycles.
_DEFAULT_MEDIUM = Medium(
    name="(no material)", lobes=(ScatterLobe(sigma_s_per_m=(0.5, 0.5, 0.5)),), sigma_a_per_m=(0.5, 0.5, 0.5)
)
_BEND = 1e-3  #: Relative: what a shader may be off a straight line before it is noted.


class _GridValueReader(ValueReader):
    """A shader's values where the grids of a volume have given values."""

    def __init__(self, culprit: str, reports: Reports, images: ImageReader, names: tuple[str, ...]) -> None:
        super().__init__(culprit, reports, images, Domain.CONSTANT)
        self._names = names
        self.values: dict[str, float] = {}  #: Of the grids that are not 0.
        self.asked: dict[str, None] = {}  #: Names of grids that the shader reads, in their order.

    def grid_value(self, name: str) -> float | None:
        if name not in self._names:
            return None
        self.asked[name] = None
        return self.values.get(name, 0.0)

    def _output(self, at: Socket) -> Value:
        if at.node.type == "ATTRIBUTE":
            return self._attribute(at.node.attribute_name)
        if at.node.type == "VOLUME_INFO" and at.socket.identifier in _VOLUME_INFO:
            return self._attribute(_VOLUME_INFO[at.socket.identifier])
        return self._evaluated(at)  # anew: the grids' values change

    def _attribute(self, name: str) -> Value:
        value = self.grid_value(name)
        if value is None:
            self.note(f'the volume has no grid "{name}": read as 0')
            return BLACK
        return grey(value)


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
        media: dict[tuple[tuple[str, ...], int], dict[str, int]] = {}  # per grid: into materials.media
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
            key = source.grid_names, material.as_pointer() if material else 0
            if key not in media:
                media[key] = {
                    name: materials.add_medium(medium)
                    for name, medium in _media_of(material, source.grid_names, images, reports).items()
                }
            if not media[key]:
                reports.add(culprit, "its volume's shader reads none of its grids: not drawn")
            if not (placement.is_camera_visible and placement.casts_shadow):
                reports.add(culprit, IGNORES_RAY_VISIBILITY)
            for name, medium in media[key].items():
                try:
                    grid = source.read(name, self._grids | kept)
                except (IoError, InvalidInput) as error:
                    reports.add(culprit, f"not drawn: {error}")
                    continue
                kept[grid.key] = grid
                if len(grid.grid.leaf_origins):
                    volumes += _instances(placement, source, grid, medium)
                else:
                    advice = f": {source.advice_if_empty}" if source.advice_if_empty else ""
                    reports.add(culprit, f'its grid "{name}" is empty{advice}')
        self._grids, self._made = kept, made
        return tuple(volumes)


def _media_of(
    material: Material | None, grid_names: tuple[str, ...], images: ImageReader, reports: Reports
) -> dict[str, Medium]:
    """Per grid that the shader reads: its medium where the grid is 1 and the others are 0."""
    if material is None:
        return {"density": _DEFAULT_MEDIUM} if "density" in grid_names else {}
    tree = shader_tree(material)
    shader = output_input(tree, "Volume") if tree is not None else None
    if shader is None or not shader.is_connected():
        return {}
    reader = _GridValueReader(f'Material "{material.name}"', reports, images, grid_names)
    nothing = read_coefficients(reader, shader)
    if medium_of(nothing, "") is not None:
        reader.note("what does not depend on a grid has no bounds in a volume object: left out")
    found = {}
    for name in tuple(reader.asked):
        reader.values = {name: 1.0}
        once = difference(read_coefficients(reader, shader), nothing)
        reader.values = {name: 2.0}
        twice = difference(read_coefficients(reader, shader), nothing)
        if _distance(twice, once, 2.0) > _BEND:
            reader.note(f'is not linear in its grid "{name}": drawn as a straight line from 0 to 1')
        medium = medium_of(once, f"{material.name}, {name}")
        if medium is not None:
            found[name] = medium
    if len(found) > 1:
        reader.values = dict.fromkeys(found, 1.0)
        together = difference(read_coefficients(reader, shader), nothing)
        alone = Coefficients()
        for name in found:
            reader.values = {name: 1.0}
            _add(alone, difference(read_coefficients(reader, shader), nothing))
        if _distance(together, alone, 1.0) > _BEND:
            reader.note("multiplies grids: drawn as the sum of what each makes alone")
    return found


def _add(total: Coefficients, part: Coefficients) -> None:
    total.scatter += part.scatter
    total.absorption = total.absorption + part.absorption
    total.emission = total.emission + part.emission


def _distance(a: Coefficients, b: Coefficients, times: float) -> float:
    """Relative, of ``a`` from ``times`` of ``b``."""

    def numbers(of: Coefficients) -> np.ndarray:
        return np.concatenate([sum((s for s, _ in of.scatter), np.zeros(3)), of.absorption, of.emission])

    first, second = numbers(a), times * numbers(b)
    return float(np.abs(first - second).max() / max(np.abs(second).max(), 1e-30))


def _instances(placement: Placement, source: VolumeSource, grid: DensityGrid, medium: int) -> list[Volume]:
    shift = np.eye(4)
    shift[:3, 3] = grid.grid.local_from_index[:3, :3] @ np.full(3, source.voxel_shift)
    volumes = []
    for matrix in placement.world_from_object():
        # As Cycles: what a vector of equal parts becomes is the object's scale.
        scale = float(np.linalg.norm(matrix[:3, :3] @ np.full(3, 3.0**-0.5)))
        volumes.append(
            Volume(
                name=placement.object_name,
                grid=grid,
                world_from_object=matrix @ shift,
                medium=medium,
                density_scale=1.0 / scale if source.keeps_opacity and scale > 0.0 else 1.0,
            )
        )
    return volumes
