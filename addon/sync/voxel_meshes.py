# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes voxels: the evaluated meshes of objects, and of all that these instance, as one list of triangles.

As in a render, an item of the depsgraph counts where its data is a Mesh (see instances.py). What shows in no render, or
hides in the viewport, was chosen by name here and is taken if the depsgraph has it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall import InvalidInput
from tyndall.program_points import PointPlace, asks_of_instances
from tyndall.scene_description import ATTRIBUTE_MARK

from .images import ImageReader
from .instances import materials_of
from .materials import COLOUR, MaterialReader, note_missing_attributes
from .mesh_attributes import GENERATED, asked_of_meshes, made_maps
from .meshes import read_mesh
from .random_numbers import as_unit_floats, random_number_of
from .reports import Reports
from .unit_vectors import unit_vectors
from .varying_voxels import Varying
from .voxel_colours import METALLIC, Colouring, colouring_of, may_be_above_zero, plain_colouring

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator

    from bpy.types import Depsgraph, DepsgraphObjectInstance, Object
    from numpy.typing import NDArray

    from tyndall.scene_description import Mesh


@dataclass(frozen=True, kw_only=True, eq=False)
class VoxelMesh:
    """In the world, in metres. Seen from outside, corners go round against the clock."""

    positions_m: NDArray[np.float64]  #: (n, 3)
    triangles: NDArray[np.uint32]  #: (m, 3)
    colourings: list[Colouring]
    colouring_of_triangle: NDArray[np.uint32]  #: (m,), into colourings.
    corner_uvs: NDArray[np.float32]  #: (m, 3, 2), where pictures are read; 0 where there is none.
    corner_normals: NDArray[np.float32]  #: (m, 3, 3), unit; 0: flat.
    #: What colours (COLOUR) and channels of the colourings are multiplied by, of those that attributes of the mesh are
    #: read for, (m, 3, 3) or (m, 3, 1), linear.
    corner_factors: dict[str, NDArray[np.float32]]
    varying: list[Varying]  #: Of colourings that ask where they are.
    sources: list[str]  #: Names of the chosen objects that have faces here.
    reports: Reports  #: What was left out or replaced.


@dataclass(frozen=True, kw_only=True, eq=False)
class _Placed:
    """A mesh with its materials, and where it stands."""

    name: str  #: Of the object that has it.
    mesh: Mesh
    colouring_of_triangle: NDArray[np.uint32]
    corner_uvs: NDArray[np.float32]
    corner_factors: dict[str, NDArray[np.float32]]
    places: list[PointPlace] = field(default_factory=list)


def gather(
    depsgraph: Depsgraph,
    objects: Iterable[Object],
    poll: Callable[[], None] = lambda: None,
    *,
    channels: Collection[str] = (),
) -> VoxelMesh:
    """Modifiers and instances applied; ``objects`` are original ones; ``channels``: what of materials to read.

    ``poll`` may raise to stop between two meshes. Raises InvalidInput, which names an object: one with a vertex that is
    not finite, or those of which none has a face.
    """
    chosen = {thing.original for thing in objects}
    reader = _Reader(depsgraph, chosen, poll, channels)
    placed = reader.placed_meshes()
    if not placed:
        names = ", ".join(f'"{name}"' for name in sorted(thing.name for thing in chosen)[:3])
        raise InvalidInput(f"there is nothing to voxelize: {names or 'no object'} has no face that is shown")
    parts = [part for thing in placed for part in _parts(thing)]
    factors = sorted({name for part in parts for name in part.corner_factors})
    firsts = np.cumsum([0, *(len(part.positions_m) for part in parts[:-1])]).astype(np.uint32)
    first_triangles = iter(np.cumsum([0, *(len(part.triangles) for part in parts[:-1])]).tolist())
    varying = [
        one
        for thing in placed
        for one in _varying(thing, reader.colourings, [next(first_triangles) for _ in thing.places])
    ]
    return VoxelMesh(
        positions_m=np.concatenate([part.positions_m for part in parts]),
        triangles=np.concatenate([part.triangles + first for part, first in zip(parts, firsts, strict=True)]),
        colourings=reader.colourings,
        colouring_of_triangle=np.concatenate([part.colouring_of_triangle for part in parts]),
        corner_uvs=np.concatenate([part.corner_uvs for part in parts]),
        corner_normals=np.concatenate([part.corner_normals for part in parts]),
        corner_factors={name: np.concatenate([part.factors(name) for part in parts]) for name in factors},
        varying=varying,
        sources=sorted(reader.sources),
        reports=reader.reports,
    )


#: In place of a material's index: an empty slot, and one of a mesh with colours.
_NO_MATERIAL, _PLAIN = -1, -2


class _Reader:
    def __init__(
        self, depsgraph: Depsgraph, chosen: set[Object | None], poll: Callable[[], None], channels: Collection[str]
    ) -> None:
        self.reports = Reports()
        self.sources: set[str] = set()
        self.colourings: list[Colouring] = []
        self._depsgraph = depsgraph
        self._chosen = chosen
        self._poll = poll
        self._channels = channels
        self._kept: dict[str, Mesh] = {}
        self._materials = MaterialReader(self.reports, ImageReader(), is_voxels=True)
        self._colouring_of_material: dict[int, int] = {}

    def placed_meshes(self) -> list[_Placed]:
        """By mesh and materials: what is instanced is read once."""
        found: dict[tuple[object, ...], _Placed | None] = {}
        for instance in self._depsgraph.object_instances:
            shown_by = (instance.parent if instance.is_instance else instance.object).original
            if not instance.show_self or shown_by not in self._chosen:
                continue
            data = instance.object.data
            if not isinstance(data, bpy.types.Mesh):
                continue
            slots = materials_of(instance.object)
            indices = tuple(_NO_MATERIAL if slot is None else self._materials.index(slot) for slot in slots)
            key = (data.as_pointer(), indices)
            if key not in found:
                found[key] = self._read(instance.object.name, data, indices)
            if (thing := found[key]) is not None:
                self.sources.add(shown_by.name)
                thing.places.append(_place_of(instance))
        return [thing for thing in found.values() if thing is not None]

    def _read(self, name: str, data: bpy.types.Mesh, materials: tuple[int, ...]) -> _Placed | None:
        asked = asked_of_meshes(self._materials.materials[index] for index in materials if index != _NO_MATERIAL)
        mesh = read_mesh(data, self.reports, self._kept, self._poll, asked)
        if mesh is None:
            return None
        has_colours = any(map_name.startswith(ATTRIBUTE_MARK) for map_name, _ in mesh.uv_maps)
        materials = tuple(
            (_PLAIN if has_colours else self._materials.index(None)) if index == _NO_MATERIAL else index
            for index in materials
        )
        slots = np.zeros(len(mesh.triangles), np.intp) if mesh.material_slots is None else mesh.material_slots
        slots = np.minimum(slots, len(materials) - 1)
        of_triangle = np.array([self._colouring(index) for index in materials], np.uint32)[slots]
        has_surface = np.array(
            [index == _PLAIN or self._materials.materials[index].has_surface for index in materials]
        )[slots]
        if not has_surface.all():
            self.reports.add(f'Object "{name}"', "faces that bound a medium and have no surface are left out")
            if not has_surface.any():
                return None
            mesh, of_triangle = _part_of(mesh, has_surface), of_triangle[has_surface]
        note_missing_attributes(
            name, mesh, [index for index in materials if index != _PLAIN], self._materials, self.reports
        )
        return _Placed(
            name=name,
            mesh=mesh,
            colouring_of_triangle=of_triangle,
            corner_uvs=self._uvs(name, mesh, of_triangle),
            corner_factors=self._factors(mesh, of_triangle),
        )

    def _colouring(self, material: int) -> int:
        """Its index."""
        if material not in self._colouring_of_material:
            self._colouring_of_material[material] = len(self.colourings)
            self.colourings.append(self._new_colouring(material))
        return self._colouring_of_material[material]

    def _new_colouring(self, material: int) -> Colouring:
        if material == _PLAIN:
            return plain_colouring()
        read, of_material = self._materials.materials[material], self._materials.channels[material]
        channels = {name: of_material[name] for name in self._channels if name in of_material}
        if METALLIC in of_material and METALLIC not in self._channels and may_be_above_zero(of_material[METALLIC]):
            self.reports.add(f'Material "{read.name}"', "metal is diffuse, in its colour, unless voxels keep Metallic")
        return colouring_of(of_material.get(COLOUR, read), channels, self.reports)

    def _factors(self, mesh: Mesh, of_triangle: NDArray[np.uint32]) -> dict[str, NDArray[np.float32]]:
        """Of the attributes that colourings read of corners."""
        factors: dict[str, NDArray[np.float32]] = {}
        maps = _maps_by_name(mesh)
        for index in np.unique(of_triangle):
            colouring = self.colourings[index]
            covered = of_triangle == index
            for name, parts in ((COLOUR, colouring.parts), *colouring.channels.items()):
                if parts.at_corners is None or name in colouring.programs:
                    continue
                there = {known: uvs[covered].reshape(-1, 2) for known, uvs in maps.items()}
                found = parts.at_corners(3 * int(covered.sum()), there)
                width = found.shape[-1]
                if name not in factors:
                    factors[name] = np.ones((len(of_triangle), 3, width), np.float32)
                factors[name][covered] = np.clip(found, 0.0, 1.0).reshape(-1, 3, width)
        return factors

    def _uvs(self, name: str, mesh: Mesh, of_triangle: NDArray[np.uint32]) -> NDArray[np.float32]:
        placed = np.zeros((len(mesh.triangles), 3, 2), np.float32)
        maps = {known: uvs for known, uvs in mesh.uv_maps if not known.startswith(ATTRIBUTE_MARK)}
        for index in np.unique(of_triangle):
            colouring = self.colourings[index]
            if not colouring.is_picture:
                continue
            wanted = colouring.uv_map or next(iter(maps), "")
            if wanted not in maps:
                self.reports.add(f'Object "{name}"', f'has no UV map "{wanted}": its picture is read at one point')
                continue
            covered = of_triangle == index
            placed[covered] = colouring.placed(maps[wanted][covered])
        return placed


def _maps_by_name(mesh: Mesh) -> dict[str, NDArray[np.float32]]:
    """With the active UV map as "", and the active colours without a name of theirs."""
    maps = dict(mesh.uv_maps)
    if (first := next((uvs for known, uvs in mesh.uv_maps if not known.startswith(ATTRIBUTE_MARK)), None)) is not None:
        maps[""] = first
    for name in (ATTRIBUTE_MARK + kind for kind in ("rg ", "ba ")):
        if (first := next((uvs for known, uvs in mesh.uv_maps if known.startswith(name)), None)) is not None:
            maps[name] = first
    return maps


def _place_of(instance: DepsgraphObjectInstance) -> PointPlace:
    thing = instance.object
    random = instance.random_id & 0xFFFFFFFF if instance.is_instance else random_number_of(thing.name)
    return PointPlace(
        world_from_object=np.array(instance.matrix_world, np.float64),
        generated=(np.array(thing.data.texspace_location), np.array(thing.data.texspace_size)),
        generated_maps=made_maps(GENERATED),
        color=tuple(thing.color),
        pass_index=float(thing.pass_index),
        random=float(as_unit_floats([random])[0]),
    )


def _part_of(mesh: Mesh, is_kept: NDArray[np.bool_]) -> Mesh:
    """The triangles that are kept; their slots have been read."""
    return replace(
        mesh,
        triangles=mesh.triangles[is_kept],
        material_slots=None,
        corner_normals=None if mesh.corner_normals is None else mesh.corner_normals[is_kept],
        uv_maps=tuple((name, uvs[is_kept]) for name, uvs in mesh.uv_maps),
    )


def _corner_normals(mesh: Mesh) -> NDArray[np.float32]:
    """0: flat."""
    return np.zeros((len(mesh.triangles), 3, 3), np.float32) if mesh.corner_normals is None else mesh.corner_normals


def _is_mirrored(world_from_object: NDArray[np.float64]) -> bool:
    return bool(np.linalg.det(world_from_object[:3, :3]) < 0.0)


def _varying(thing: _Placed, colourings: list[Colouring], firsts: list[int]) -> Iterator[Varying]:
    """``firsts``: of the triangles of its instances, among all. What is drawn for one does for others of its size."""
    mesh, maps = thing.mesh, _maps_by_name(thing.mesh)
    for index in np.unique(thing.colouring_of_triangle):
        programs = colourings[index].programs
        if not programs:
            continue
        covered = np.flatnonzero(thing.colouring_of_triangle == index)
        asked = {name for program in programs.values() for name in program.uv_maps}
        is_alike = not any(asks_of_instances(program) for program in programs.values())
        drawn: dict[object, Varying] = {}
        for number, (place, first) in enumerate(zip(thing.places, firsts, strict=True)):
            key = _size_of(place.world_from_object) if is_alike else number
            if key not in drawn:
                drawn[key] = Varying(
                    colouring=int(index),
                    programs=programs,
                    place=place,
                    corners=mesh.positions[mesh.triangles[covered]].astype(np.float64),
                    normals=_corner_normals(mesh)[covered],
                    uv_maps={name: uvs[covered] for name, uvs in maps.items() if name in asked},
                )
            drawn[key].triangles.append(first + covered)
            drawn[key].is_mirrored.append(_is_mirrored(place.world_from_object))
        yield from drawn.values()


def _size_of(world_from_object: NDArray[np.float64]) -> tuple[float, ...]:
    """The same for matrices that turn and mirror after they have scaled alike."""
    scales = world_from_object[:3, :3].T @ world_from_object[:3, :3]
    whole = float(np.trace(scales)) or 1.0
    return (float(f"{whole:.4g}"), *np.round(scales / whole, 4).ravel().tolist())


def _parts(thing: _Placed) -> Iterator[_Part]:
    """Of each of its instances."""
    mesh = thing.mesh
    local, normals = mesh.positions.astype(np.float64), _corner_normals(mesh)
    for matrix in (place.world_from_object for place in thing.places):
        positions_m = local @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(positions_m).all():
            vertex = int(np.argmin(np.isfinite(positions_m).all(axis=1)))
            raise InvalidInput(f'object "{thing.name}": vertex {vertex} is at {positions_m[vertex].tolist()}')
        order = slice(None, None, -1) if _is_mirrored(matrix) else slice(None)
        yield _Part(
            positions_m=positions_m,
            triangles=mesh.triangles[:, order],
            colouring_of_triangle=thing.colouring_of_triangle,
            corner_uvs=thing.corner_uvs[:, order],
            corner_normals=_turned(normals, matrix)[:, order],
            corner_factors={name: factor[:, order] for name, factor in thing.corner_factors.items()},
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Part:
    """An instance, in the world."""

    positions_m: NDArray[np.float64]
    triangles: NDArray[np.uint32]
    colouring_of_triangle: NDArray[np.uint32]
    corner_uvs: NDArray[np.float32]
    corner_normals: NDArray[np.float32]
    corner_factors: dict[str, NDArray[np.float32]]

    def factors(self, name: str) -> NDArray[np.float32]:
        """1, where no attribute is read."""
        width = 3 if name == COLOUR else 1
        return self.corner_factors.get(name, np.ones((len(self.triangles), 3, width), np.float32))


def _turned(normals: NDArray[np.float32], world_from_object: NDArray[np.float64]) -> NDArray[np.float32]:
    """By the cofactors, which a flat object has, too; 0 stays 0."""
    x, y, z = world_from_object[:3, :3].T
    cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=1)
    turned = normals.astype(np.float64) @ cofactors.T
    if _is_mirrored(world_from_object):
        turned = -turned
    return unit_vectors(turned).astype(np.float32)
