# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the grids of volumes come from: OpenVDB files, what modifiers and geometry nodes make, smoke domains.

Blender hands out no voxels of a volume that it made, but writes them: they take the way through a file that lives for
one read. Those of a fluid domain it hands out as they are simulated.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Protocol

import bpy
import numpy as np

from tyndall import InvalidInput, IoError
from tyndall.scene_description import DensityGrid
from tyndall.volumes import GridInfo, SparseGrid, from_dense, grid_infos, read_vdb

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bpy.types import FluidDomainSettings, Mesh, Object, Volume
    from numpy.typing import NDArray

    from .instances import Placement
    from .point_places import TextureSpace

#: Voxels by which Cycles has a file's grid off its place along each axis: measured, to 1e-2.
_VOXEL_SHIFT = 0.0 if bpy.app.version >= (5, 0, 0) else 0.5
#: Of a fluid domain, by the names that shaders know them by; heat is a value of the simulation's coarse grid.
_DOMAIN_GRIDS = {"density": "density_grid", "flame": "flame_grid", "temperature": "temperature_grid"}
_OF_COLOUR = 4  #: Numbers of a voxel's colour there.
#: A texture space in which generated coordinates are places in the object, as Cycles has them of volume objects.
_PLACE_IN_OBJECT = np.full(3, 0.5), np.full(3, 0.5)


class NoVolumeError(Exception):
    """There is nothing to draw; says why."""


class VolumeSource(Protocol):
    """The grids of one volume as it is now."""

    grid_names: tuple[str, ...]  #: Those of numbers that can be read.
    vector_names: tuple[str, ...]  #: Likewise, of vectors and colours.
    texture_space: TextureSpace
    keeps_opacity: bool  #: When it is scaled; else its density.
    voxel_shift: float  #: Voxels by which Cycles draws its grids off their place, along each axis.
    outlives_read: bool  #: It may be asked again while nothing that it depends on is updated.
    advice_if_empty: str  #: What to do about a grid without any density; "" if there is nothing to do.

    def read(self, name: str, kept: Mapping[str, DensityGrid]) -> DensityGrid:
        """One of the grids, that in ``kept`` if it is the same. Raises IoError and InvalidInput."""

    def read_vector(self, name: str, kept: Mapping[str, DensityGrid]) -> tuple[DensityGrid, ...]:
        """The three numbers of one of vectors, likewise."""


def source_of(placement: Placement) -> VolumeSource:
    """What is drawn at a placement. Raises NoVolumeError."""
    domain = _smoke_domain(placement.source)
    if domain is not None:
        return _SmokeDomain.of(domain, placement.data)
    volume = placement.data
    is_made = any(modifier.show_render or modifier.show_viewport for modifier in placement.source.modifiers)
    try:
        return _MadeVolume.of(volume) if is_made or not volume.filepath else _VolumeFile.of(volume)
    except (OSError, IoError, InvalidInput) as error:
        raise NoVolumeError(str(error)) from error


def is_volume(placement: Placement) -> bool:
    """Whether grids are drawn there: also in place of the surface of a mesh that holds simulated gas, as in Cycles."""
    if isinstance(placement.data, bpy.types.Mesh):
        return _smoke_domain(placement.source) is not None
    return isinstance(placement.data, bpy.types.Volume)


def _smoke_domain(thing: Object) -> FluidDomainSettings | None:
    for modifier in thing.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
            return modifier.domain_settings if modifier.domain_settings.domain_type == "GAS" else None
    return None


def _keeps_opacity(volume: Volume) -> bool:
    return bool(volume.render.space == "OBJECT")


def _readable(infos: list[GridInfo], *, are_vectors: bool) -> tuple[str, ...]:
    return tuple(info.name for info in infos if not info.refusal and info.value_type.startswith("vec3") == are_vectors)


def _parts(name: str) -> tuple[str, ...]:
    """As `read_vdb` names the numbers of a vector."""
    return tuple(f"{name}.{axis}" for axis in "xyz")


def _by_content(grid: SparseGrid) -> DensityGrid:
    """Its key changes with the content and with nothing else."""
    digest = blake2b(grid.name.encode(), digest_size=16)
    for array in (grid.leaf_origins, grid.leaf_values, grid.local_from_index, np.float32(grid.background)):
        digest.update(np.ascontiguousarray(array).data)
    return DensityGrid(key=digest.hexdigest(), grid=grid)


@dataclass(frozen=True, kw_only=True)
class _VolumeFile:
    path: Path
    key: str
    grid_names: tuple[str, ...]
    vector_names: tuple[str, ...]
    keeps_opacity: bool
    texture_space: TextureSpace = _PLACE_IN_OBJECT
    voxel_shift: float = _VOXEL_SHIFT
    outlives_read: bool = False  #: Files change without an update.
    advice_if_empty: str = ""

    @classmethod
    def of(cls, volume: Volume) -> _VolumeFile:
        """At this frame of a sequence. Raises OSError and IoError."""
        volume.grids.load()
        path = Path(bpy.path.abspath(volume.grids.frame_filepath or volume.filepath, library=volume.original.library))
        facts, infos = path.stat(), grid_infos(path)
        return cls(
            path=path,
            key=f"{path}:{facts.st_mtime_ns}:{facts.st_size}",
            grid_names=_readable(infos, are_vectors=False),
            vector_names=_readable(infos, are_vectors=True),
            keeps_opacity=_keeps_opacity(volume),
        )

    def read(self, name: str, kept: Mapping[str, DensityGrid]) -> DensityGrid:
        key = f"{self.key}:{name}"
        return kept.get(key) or DensityGrid(key=key, grid=read_vdb(self.path, [name])[name])

    def read_vector(self, name: str, kept: Mapping[str, DensityGrid]) -> tuple[DensityGrid, ...]:
        keys = {part: f"{self.key}:{part}" for part in _parts(name)}
        if all(key in kept for key in keys.values()):
            return tuple(kept[key] for key in keys.values())
        read = read_vdb(self.path, [name])
        return tuple(DensityGrid(key=key, grid=read[part]) for part, key in keys.items())


@dataclass(frozen=True, kw_only=True)
class _MadeVolume:
    """By modifiers, geometry nodes or a script."""

    grids: dict[str, DensityGrid]
    grid_names: tuple[str, ...]
    vector_names: tuple[str, ...]
    keeps_opacity: bool
    texture_space: TextureSpace = _PLACE_IN_OBJECT
    voxel_shift: float = _VOXEL_SHIFT
    outlives_read: bool = True
    advice_if_empty: str = ""

    @classmethod
    def of(cls, volume: Volume) -> _MadeVolume:
        """Raises NoVolumeError, OSError, IoError and InvalidInput."""
        if len(volume.grids) == 0:
            raise NoVolumeError("its volume has no file, and nothing makes a grid of it")
        with TemporaryDirectory(prefix="tyndall_") as folder:
            path = Path(folder) / "made.vdb"
            if not volume.grids.save(str(path)):
                raise NoVolumeError(f"Blender could not write its grids to {path}")
            infos = grid_infos(path)
            numbers, vectors = (_readable(infos, are_vectors=are_vectors) for are_vectors in (False, True))
            grids = {name: _by_content(grid) for name, grid in read_vdb(path, (*numbers, *vectors)).items()}
        return cls(grids=grids, grid_names=numbers, vector_names=vectors, keeps_opacity=_keeps_opacity(volume))

    def read(self, name: str, kept: Mapping[str, DensityGrid]) -> DensityGrid:
        return kept.get(self.grids[name].key) or self.grids[name]

    def read_vector(self, name: str, kept: Mapping[str, DensityGrid]) -> tuple[DensityGrid, ...]:
        return tuple(self.read(part, kept) for part in _parts(name))


@dataclass(frozen=True, kw_only=True)
class _SmokeDomain:
    """Valid while the depsgraph is; voxels are read when they are asked for."""

    domain: FluidDomainSettings
    local_from_index: NDArray[np.float64]
    resolution: tuple[int, int, int]
    grid_names: tuple[str, ...]
    texture_space: TextureSpace
    vector_names: tuple[str, ...]
    keeps_opacity: bool = False
    voxel_shift: float = 0.0
    outlives_read: bool = False
    advice_if_empty: str = "bake the simulation, or play it from its first frame"

    @classmethod
    def of(cls, domain: FluidDomainSettings, mesh: Mesh) -> _SmokeDomain:
        """Raises NoVolumeError."""
        finer = domain.noise_scale if domain.use_noise else 1
        nx, ny, nz = (finer * voxels for voxels in domain.domain_resolution)
        names = tuple(name for name, stored in _DOMAIN_GRIDS.items() if len(getattr(domain, stored)) == nx * ny * nz)
        if "density" not in names:
            raise NoVolumeError(f"its fluid domain is not simulated: {cls.advice_if_empty}")
        counts = np.array((nx, ny, nz), np.float64)
        # The grid fills what the mesh's texture space does, as in Cycles.
        centre, half_sides = np.array(mesh.texspace_location), np.array(mesh.texspace_size, np.float64)
        sides = 2.0 * half_sides
        local_from_index = np.diag([*(sides / counts), 1.0])
        local_from_index[:3, 3] = centre - half_sides + 0.5 * sides / counts
        return cls(
            domain=domain,
            local_from_index=local_from_index,
            resolution=(nx, ny, nz),
            grid_names=names,
            texture_space=(centre, half_sides),
            vector_names=("color",) if len(domain.color_grid) == _OF_COLOUR * nx * ny * nz else (),
        )

    def read(self, name: str, kept: Mapping[str, DensityGrid]) -> DensityGrid:
        values = np.empty(np.prod(self.resolution), np.float32)
        getattr(self.domain, _DOMAIN_GRIDS[name]).foreach_get(values)
        dense = values.reshape(self.resolution[::-1]).transpose(2, 1, 0)
        grid = _by_content(from_dense(name, dense, self.local_from_index))
        return kept.get(grid.key) or grid

    def read_vector(self, name: str, kept: Mapping[str, DensityGrid]) -> tuple[DensityGrid, ...]:
        """The colours of smoke; with each its density, which shaders do not read here."""
        values = np.empty(_OF_COLOUR * np.prod(self.resolution), np.float32)
        self.domain.color_grid.foreach_get(values)
        dense = values.reshape(*self.resolution[::-1], _OF_COLOUR).transpose(2, 1, 0, 3)
        grids = [
            _by_content(from_dense(part, dense[..., channel], self.local_from_index))
            for channel, part in enumerate(_parts(name))
        ]
        return tuple(kept.get(grid.key) or grid for grid in grids)
