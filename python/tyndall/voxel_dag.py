# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as voxels, and these as a directed acyclic graph: equal subtrees, also turned ones, are stored once."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._native import Progress

_MOST_BYTES = 2**64 - 1
_MOST_INDEX = 2**32 - 1


@dataclass(frozen=True, kw_only=True)
class Config:
    """How a mesh becomes voxels, and how these are stored."""

    resolution: int = 1024  #: Voxels a side, a power of two in [4, 131072].
    #: "thin": 6-separating, no way leads through a closed surface from face to face of voxels; "conservative": every
    #: voxel that the mesh touches.
    rule: Literal["thin", "conservative"] = "thin"
    #: Lower and upper corner of the cube that is voxelized, in metres; None: from the lowest corner of the mesh's box,
    #: as long as its longest side.
    bounds_m: ArrayLike | None = None
    symmetry: Literal["none", "reflections", "cube"] = "cube"  #: What may turn a subtree that is stored once.
    memory_budget_bytes: int | None = None  #: Of the voxels, and of the graph's tables; None: no limit.


class VoxelDag:
    """Voxels of a cube. Immutable; safe from any thread."""

    def __init__(self, native: _native.VoxelDag) -> None:
        self._native = native

    @property
    def resolution(self) -> int:
        """Voxels a side."""
        return self._native.resolution

    @property
    def voxel_count(self) -> int:
        """Those that are set."""
        return self._native.voxel_count

    @property
    def node_count(self) -> int:
        """Distinct nodes, bricks of 4 x 4 x 4 voxels among them."""
        return self._native.node_count

    @property
    def geometry_bytes(self) -> int:
        """Of all nodes, as they lie in memory and in the file."""
        return self._native.geometry_bytes

    @property
    def bounds_m(self) -> NDArray[np.float64]:
        """Lower and upper corner of the cube, (2, 3)."""
        lower_m, side_m = self._native.bounds_m
        return np.array([lower_m, np.add(lower_m, side_m)])

    def contains(self, coordinates: ArrayLike) -> NDArray[np.bool_]:
        """Whether voxels are set, (k,), for whole numbers x, y and z, (k, 3). What lies outside is not.

        Raises InvalidInput.
        """
        return self._native.contains(_indices(coordinates, "coordinates"))

    def coordinates(self) -> Iterator[NDArray[np.uint32]]:
        """All voxels in Morton order (x changes fastest), some at a time: (k, 3)."""
        return iter(self._native.coordinates())

    def trace(
        self, origins_m: ArrayLike, directions: ArrayLike, progress: Progress | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float32]]:
        """The first voxel along each ray: distance in metres, (k,); voxel, (k, 3); normal of its face, (k, 3).

        ``origins_m`` and ``directions``: (k, 3); directions may have any length. A miss has an infinite distance. A ray
        that begins in a voxel hits it at 0, without a normal. Raises InvalidInput and Cancelled.
        """
        origins = np.ascontiguousarray(_points(origins_m, "origins_m"), np.float64)
        ways = np.ascontiguousarray(_points(directions, "directions"), np.float64)
        if origins.shape != ways.shape:
            raise _refuse(f"{len(origins)} origins_m, but {len(ways)} directions")
        return self._native.trace(origins, ways, progress or Progress())

    def save(self, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
        """Write a ``.tdag`` file, whole or not at all. Raises IoError, which names the path, and Cancelled."""
        self._native.save(path, progress or Progress())


def load(path: str | os.PathLike[str], progress: Progress | None = None) -> VoxelDag:
    """Read a ``.tdag`` file. Raises IoError, which names the path and the section that is damaged, and Cancelled."""
    return VoxelDag(_native.load_voxel_dag(path, progress or Progress()))


def voxelize(
    positions_m: ArrayLike, triangles: ArrayLike, config: Config | None = None, progress: Progress | None = None
) -> VoxelDag:
    """The surface of a mesh. The result depends on neither the order of triangles nor the number of threads.

    ``positions_m``: (n, 3), float32 or float64, in metres; ``triangles``: (m, 3), three indices of positions each.
    Raises InvalidInput, which names the vertex, the triangle or the setting, and Cancelled.
    """
    config = config or Config()
    return VoxelDag(
        _native.voxelize(
            positions=_points(positions_m, "positions_m"),
            triangles=_indices(triangles, "triangles"),
            resolution=_whole("resolution", config.resolution, _MOST_INDEX),
            rule=_named(_native.VoxelizeRule, "rule", config.rule),
            bounds=_cube(config.bounds_m),
            symmetry=_named(_native.VoxelSymmetry, "symmetry", config.symmetry),
            memory_budget_bytes=_budget(config),
            progress=progress or Progress(),
        )
    )


def from_coordinates(
    coordinates: ArrayLike, config: Config | None = None, progress: Progress | None = None
) -> VoxelDag:
    """Of voxels x, y and z, (n, 3) whole numbers below ``config.resolution``, in any order; they may repeat.

    Without ``bounds_m`` a voxel is a cube of 1 m, and the first begins at 0. The rule has nothing to say. Raises
    InvalidInput, which names the voxel or the setting, and Cancelled.
    """
    config = config or Config()
    resolution = _whole("resolution", config.resolution, _MOST_INDEX)
    if resolution.bit_count() != 1:
        raise _refuse(f"resolution is {resolution}, no power of two")
    return VoxelDag(
        _native.voxel_dag_of(
            coordinates=_indices(coordinates, "coordinates"),
            level=resolution.bit_length() - 1,
            bounds=_cube(config.bounds_m) or ([0.0, 0.0, 0.0], float(resolution)),
            symmetry=_named(_native.VoxelSymmetry, "symmetry", config.symmetry),
            memory_budget_bytes=_budget(config),
            progress=progress or Progress(),
        )
    )


def _budget(config: Config) -> int:
    if config.memory_budget_bytes is None:
        return _MOST_BYTES
    return _whole("memory_budget_bytes", config.memory_budget_bytes, _MOST_BYTES)


def _refuse(message: str) -> Exception:
    return _native.InvalidInput(f"voxel DAG: {message}")


def _whole(name: str, value: object, most: int) -> int:
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or not 0 <= value <= most:
        raise _refuse(f"{name} is {value!r}, not a whole number in [0, {most}]")
    return int(value)


def _named(kind: Any, name: str, value: str) -> Any:  # noqa: ANN401 - an enumeration of the native module
    members = {key.lower(): member for key, member in kind.__members__.items()}
    if value not in members:
        raise _refuse(f"{name} is {value!r}, not one of {', '.join(members)}")
    return members[value]


def _rows_of_three(values: ArrayLike, name: str) -> NDArray[Any]:
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise _refuse(f"{name}: {error}") from None
    if array.size == 0:
        return np.zeros((0, 3), np.uint32)
    if array.ndim != 2 or array.shape[1] != 3:  # noqa: PLR2004 - x, y and z
        raise _refuse(f"{name} have the shape {array.shape}, not (n, 3)")
    return array


def _points(values: ArrayLike, name: str) -> NDArray[np.float32] | NDArray[np.float64]:
    array = _rows_of_three(values, name)
    if array.dtype.kind not in "fiu":
        raise _refuse(f"{name} are {array.dtype}, not numbers")
    return np.ascontiguousarray(array, array.dtype if array.dtype in (np.float32, np.float64) else np.float64)


def _indices(values: ArrayLike, name: str) -> NDArray[np.uint32]:
    array = _rows_of_three(values, name)
    if array.dtype.kind not in "iu":
        raise _refuse(f"{name} are {array.dtype}, not whole numbers")
    if array.dtype != np.uint32 and array.size and not 0 <= array.min() <= array.max() <= _MOST_INDEX:
        wrong = int(np.argmax(((array < 0) | (array > _MOST_INDEX)).any(axis=1)))
        raise _refuse(f"{name}: row {wrong} is {array[wrong].tolist()}, outside [0, {_MOST_INDEX}]")
    return np.ascontiguousarray(array, np.uint32)


def _cube(bounds_m: ArrayLike | None) -> tuple[list[float], float] | None:
    """Lower corner and side."""
    if bounds_m is None:
        return None
    corners = np.asarray(_rows_of_three(bounds_m, "bounds_m"), np.float64)
    if corners.shape != (2, 3) or not np.isfinite(corners).all():
        raise _refuse(f"bounds_m are {np.asarray(bounds_m).tolist()}, not two corners")
    sides = corners[1] - corners[0]
    if not (sides > 0).all() or not np.allclose(sides, sides[0], rtol=1e-6, atol=0.0):
        raise _refuse(f"bounds_m have the sides {sides.tolist()} m, not those of a cube")
    return corners[0].tolist(), float(sides.max())
