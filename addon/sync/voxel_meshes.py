# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes voxels: the evaluated meshes of objects, and of all that these instance, as one list of triangles.

As in a render, an item of the depsgraph counts where its data is a Mesh (see instances.py). What shows in no render, or
hides in the viewport, was chosen by name here and is taken if the depsgraph has it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall import InvalidInput

from .meshes import read_mesh
from .reports import Reports

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from bpy.types import Depsgraph, Object
    from numpy.typing import NDArray

    from tyndall.scene_description import Mesh


@dataclass(frozen=True, kw_only=True, eq=False)
class VoxelMesh:
    """In the world, in metres."""

    positions_m: NDArray[np.float64]  #: (n, 3)
    triangles: NDArray[np.uint32]  #: (m, 3)
    reports: Reports  #: What was left out.


@dataclass(kw_only=True, eq=False)
class _Placed:
    """A mesh, and where it stands."""

    name: str  #: Of the object that has it.
    mesh: Mesh
    matrices: list[NDArray[np.float64]] = field(default_factory=list)


def gather(depsgraph: Depsgraph, objects: Iterable[Object], poll: Callable[[], None] = lambda: None) -> VoxelMesh:
    """Modifiers and instances applied; ``objects`` are original ones.

    ``poll`` may raise to stop between two meshes. Raises InvalidInput, which names an object: one with a vertex that is
    not finite, or those of which none has a face.
    """
    chosen = {thing.original for thing in objects}
    reports = Reports()
    placed = _placed_meshes(depsgraph, chosen, reports, poll)
    if not placed:
        names = ", ".join(f'"{name}"' for name in sorted(thing.name for thing in chosen)[:3])
        raise InvalidInput(f"there is nothing to voxelize: {names or 'no object'} has no face that is shown")
    positions_m = [positions for thing in placed for positions in _positions_m(thing)]
    counts = [len(positions) for positions in positions_m]
    firsts = iter(np.cumsum([0, *counts[:-1]]).tolist())
    triangles = [thing.mesh.triangles + np.uint32(next(firsts)) for thing in placed for _ in thing.matrices]
    return VoxelMesh(positions_m=np.concatenate(positions_m), triangles=np.concatenate(triangles), reports=reports)


def _placed_meshes(
    depsgraph: Depsgraph, chosen: set[Object | None], reports: Reports, poll: Callable[[], None]
) -> list[_Placed]:
    """By mesh: one that is instanced is read once."""
    by_address: dict[int, _Placed | None] = {}
    kept: dict[str, Mesh] = {}
    for instance in depsgraph.object_instances:
        shown_by = (instance.parent if instance.is_instance else instance.object).original
        if not instance.show_self or shown_by not in chosen:
            continue
        data = instance.object.data
        if not isinstance(data, bpy.types.Mesh):
            continue
        address = data.as_pointer()
        if address not in by_address:
            mesh = read_mesh(data, reports, kept, poll)
            by_address[address] = None if mesh is None else _Placed(name=instance.object.name, mesh=mesh)
        if (thing := by_address[address]) is not None:
            thing.matrices.append(np.array(instance.matrix_world, np.float64))
    return [thing for thing in by_address.values() if thing is not None]


def _positions_m(thing: _Placed) -> Iterator[NDArray[np.float64]]:
    """Of each of its instances."""
    local = thing.mesh.positions.astype(np.float64)
    for matrix in thing.matrices:
        positions_m = local @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(positions_m).all():
            vertex = int(np.argmin(np.isfinite(positions_m).all(axis=1)))
            raise InvalidInput(f'object "{thing.name}": vertex {vertex} is at {positions_m[vertex].tolist()}')
        yield positions_m
