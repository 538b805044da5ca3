# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated Blender meshes to plain triangle arrays, by bulk reads only.

``foreach_get`` is 20 to 60 times faster where the array's type is the one that Blender stores: hence uint32 for
indices, and attributes by name where a version has them (measured: 0.16 s against 0.003 s for a million triangles).
"""

from __future__ import annotations

import hashlib
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from tyndall._native import shared_array
from tyndall.scene_description import Mesh, attribute_maps

from .mesh_attributes import VERTEX_NORMALS, read_asked, vertex_normals

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from bpy.types import Object
    from numpy.typing import NDArray

    from .reports import Reports


@dataclass(frozen=True, kw_only=True, eq=False)
class _StoredMesh:
    """A mesh as Blender stores it: triangles are expanded only after the key has said that the content is new."""

    name: str
    positions: NDArray[np.float32]  #: (vertices, 3)
    vertex_of_corner: NDArray[np.uint32]  #: (corners,)
    corners: NDArray[np.uint32]  #: (triangles, 3), into vertex_of_corner.
    slots: NDArray[np.uint16] | None  #: (triangles,); None: all 0.
    vertex_normals: NDArray[np.float32] | None = None  #: (vertices, 3)
    corner_normals: NDArray[np.float32] | None = None  #: (corners, 3); neither: flat.
    asked_normals: NDArray[np.float32] | None = None  #: (vertices, 3), whatever the mesh is smoothed by.
    is_flat: NDArray[np.bool_] | None = None  #: (triangles,): those that use no normals; None: no triangle is.
    uv_maps: tuple[tuple[str, NDArray[np.float32]], ...] = ()  #: Names and (corners, 2), as Mesh orders them.

    def key(self, poll: Callable[[], None]) -> str:
        """Changes with the content and with nothing else, so it outlives a depsgraph that is built anew every frame."""
        arrays: list[NDArray[Any] | None] = [self.positions, self.vertex_of_corner, self.corners, self.slots]
        arrays += [self.vertex_normals, self.corner_normals, self.asked_normals, self.is_flat]
        arrays += [uvs for _, uvs in self.uv_maps]
        shape = [(None if array is None else array.shape) for array in arrays], [name for name, _ in self.uv_maps]
        digest = hashlib.sha256(repr(shape).encode())
        for array in arrays:
            poll()
            if array is not None and array.size:
                digest.update(memoryview(np.ascontiguousarray(array)).cast("B"))
        return digest.hexdigest()

    def expand(self, key: str, poll: Callable[[], None]) -> Mesh:
        corners = self.corners.astype(np.intp)  # what numpy.take wants: half the time of indexing with uint32
        vertices = _taken(self.vertex_of_corner, corners)
        poll()
        return Mesh(
            key=key,
            name=self.name,
            positions=self.positions,
            triangles=vertices,
            material_slots=self.slots,
            corner_normals=self._expanded_normals(corners, vertices),
            uv_maps=tuple((name, _taken(uvs, corners)) for name, uvs in self.uv_maps),
            vertex_normals=self.asked_normals,
        )

    def _expanded_normals(self, corners: NDArray[np.intp], vertices: NDArray[np.uint32]) -> NDArray[np.float32] | None:
        if self.corner_normals is not None:
            normals = _taken(self.corner_normals, corners)
        elif self.vertex_normals is not None:
            normals = _taken(self.vertex_normals, vertices.astype(np.intp))
        else:
            return None
        if self.is_flat is not None:
            normals[self.is_flat] = 0.0  # a zero vector says: flat at this corner
        return normals


def _taken(values: NDArray[Any], indices: NDArray[np.intp]) -> NDArray[Any]:
    """Rows of values, shared with native code. Indices are in range."""
    taken: NDArray[Any] = shared_array((*indices.shape, *values.shape[1:]), values.dtype)
    return values.take(indices, axis=0, out=taken, mode="clip")  # which needs no copy of the result


@contextmanager
def passing_mesh(source: Object, mesh: bpy.types.Mesh, *, is_complete: bool = True) -> Iterator[bpy.types.Mesh]:
    """To read what an evaluated object is drawn as by: a copy, gone afterwards, where Blender copies what is read.

    From 4.1 on meshes share their arrays with those they come from, and one whose arrays Python asks for gets its own,
    which an evaluated one would keep (measured: 16 bytes per triangle). Copies share what Blender finds for them, too:
    triangles and normals. ``source`` is what the depsgraph evaluated, not what its list of instances shows for a while:
    copies of those crash Blender. ``is_complete``: no, ``mesh`` lacks something that a copy has.
    """
    shares_arrays = bpy.app.version >= (4, 1, 0) and source.type == "MESH" and source.data == mesh
    if is_complete and not shares_arrays:
        yield mesh
        return
    try:
        yield source.to_mesh()
    finally:
        source.to_mesh_clear()


def read_mesh(
    mesh: bpy.types.Mesh,
    reports: Reports,
    kept: dict[str, Mesh],
    poll: Callable[[], None],
    asked: frozenset[str] = frozenset(),
) -> Mesh | None:
    """Triangles of an evaluated mesh; the one in ``kept`` if its content is the same; None without a triangle.

    ``poll`` may raise to stop between two arrays. ``asked`` is what its materials read beside UV maps and colours.

    Non-finite values are passed on: the native side drops those triangles and counts them. Indices out of range, which
    a damaged file may hold and which crash other engines, take the whole mesh out, with a report.
    """
    stored = _read_stored(mesh, reports, poll, asked)
    if stored is None:
        return None
    key = stored.key(poll)
    if key not in kept:
        kept[key] = stored.expand(key, poll)
    return kept[key]


def _read_stored(
    mesh: bpy.types.Mesh, reports: Reports, poll: Callable[[], None], asked: frozenset[str]
) -> _StoredMesh | None:
    vertex_count, corner_count = len(mesh.vertices), len(mesh.loops)
    if len(mesh.polygons) == 0 or vertex_count == 0:
        return None
    vertex_of_corner = _corner_vertices(mesh)
    if vertex_of_corner.max(initial=0) >= vertex_count:  # before Blender's own triangulation follows the index
        reports.add(f'Mesh "{mesh.name}"', "left out: a face uses a vertex that does not exist")
        return None
    poll()
    mesh.calc_loop_triangles()
    poll()
    triangle_count = len(mesh.loop_triangles)
    if triangle_count == 0:
        return None
    corners = _read(mesh.loop_triangles, "loops", (triangle_count, 3), np.uint32)
    if corners.max() >= corner_count:
        reports.add(f'Mesh "{mesh.name}"', "left out: a face uses a corner that does not exist")
        return None
    polygon_of_triangle = _polygon_of_triangle(mesh, triangle_count)
    maps = *_uv_maps(mesh), *_colour_maps(mesh, vertex_of_corner)
    if asked:
        maps = *maps, *read_asked(mesh, asked, [name for name, _ in maps], vertex_of_corner)
    normals, asked_normals = _normals(mesh, polygon_of_triangle), None
    if VERTEX_NORMALS in asked:
        asked_normals = normals["vertex_normals"] if "vertex_normals" in normals else vertex_normals(mesh)
    return _StoredMesh(
        name=mesh.name,
        positions=_positions(mesh),
        vertex_of_corner=vertex_of_corner,
        corners=corners,
        slots=_slots(mesh, polygon_of_triangle),
        asked_normals=asked_normals,
        uv_maps=maps,
        **normals,
    )


def _read(
    collection: Any,  # noqa: ANN401  any bpy_prop_collection
    name: str,
    shape: tuple[int, ...],
    dtype: type[np.generic],
) -> NDArray[Any]:
    array = np.empty(shape, dtype)
    collection.foreach_get(name, array.reshape(-1))
    return array


def _attribute(mesh: bpy.types.Mesh, name: str) -> Any:  # noqa: ANN401  a collection of the attribute's own type
    """The attribute's elements, or None. Versions before 3.5 to 4.1 keep the same values elsewhere."""
    attribute = mesh.attributes.get(name)
    return None if attribute is None else attribute.data


def _positions(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    positions: NDArray[np.float32] = shared_array((len(mesh.vertices), 3), np.dtype(np.float32))
    stored = _attribute(mesh, "position")
    if stored is not None and len(stored) == len(positions):
        stored.foreach_get("vector", positions.reshape(-1))
    else:
        mesh.vertices.foreach_get("co", positions.reshape(-1))
    return positions


def _corner_vertices(mesh: bpy.types.Mesh) -> NDArray[np.uint32]:
    shape = (len(mesh.loops),)
    corner_vertex = _attribute(mesh, ".corner_vert")
    if corner_vertex is not None:
        return _read(corner_vertex, "value", shape, np.int32).view(np.uint32)
    return _read(mesh.loops, "vertex_index", shape, np.uint32)


def _polygon_of_triangle(mesh: bpy.types.Mesh, triangle_count: int) -> NDArray[np.int64] | None:
    """Polygons in order give ``corners - 2`` triangles each; None: every polygon is a triangle."""
    if triangle_count == len(mesh.polygons):
        return None
    corner_counts = _read(mesh.polygons, "loop_total", (len(mesh.polygons),), np.uint32).astype(np.int64)
    return np.repeat(np.arange(len(corner_counts)), np.maximum(corner_counts - 2, 0))


def _per_triangle(per_polygon: NDArray[Any], polygon_of_triangle: NDArray[np.int64] | None) -> NDArray[Any]:
    return per_polygon if polygon_of_triangle is None else per_polygon[polygon_of_triangle]


def _slots(mesh: bpy.types.Mesh, polygon_of_triangle: NDArray[np.int64] | None) -> NDArray[np.uint16] | None:
    if len(mesh.materials) <= 1:
        return None
    if bpy.app.version >= (3, 5, 0):
        stored = _attribute(mesh, "material_index")
        if stored is None:
            return None
        slots = _read(stored, "value", (len(mesh.polygons),), np.int32)
    else:
        slots = _read(mesh.polygons, "material_index", (len(mesh.polygons),), np.int32)
    if not slots.any():
        return None
    slots = np.clip(slots, 0, len(mesh.materials) - 1)  # as Cycles does
    return _per_triangle(slots.astype(np.uint16), polygon_of_triangle)


def _normals(mesh: bpy.types.Mesh, polygon_of_triangle: NDArray[np.int64] | None) -> dict[str, NDArray[Any] | None]:
    """The fields of _StoredMesh that say how the mesh is smoothed; none of them for a flat one."""
    if bpy.app.version >= (4, 1, 0):
        if mesh.normals_domain == "FACE":
            return {}
        if mesh.normals_domain == "POINT":
            return {"vertex_normals": vertex_normals(mesh)}
        return {"corner_normals": _read(mesh.corner_normals, "vector", (len(mesh.loops), 3), np.float32)}
    if mesh.use_auto_smooth:
        mesh.calc_normals_split()
        return {"corner_normals": _read(mesh.loops, "normal", (len(mesh.loops), 3), np.float32)}
    is_flat = ~_read(mesh.polygons, "use_smooth", (len(mesh.polygons),), np.bool_)
    if is_flat.all():
        return {}
    return {
        "vertex_normals": vertex_normals(mesh),
        "is_flat": _per_triangle(is_flat, polygon_of_triangle) if is_flat.any() else None,
    }


def _uv_maps(mesh: bpy.types.Mesh) -> tuple[tuple[str, NDArray[np.float32]], ...]:
    shape = (len(mesh.loops), 2)
    layers = sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)  # stable: the others keep their order
    if bpy.app.version >= (3, 5, 0):
        return tuple((layer.name, _read(layer.uv, "vector", shape, np.float32)) for layer in layers)
    return tuple((layer.name, _read(layer.data, "uv", shape, np.float32)) for layer in layers)


def _colour_maps(
    mesh: bpy.types.Mesh, vertex_of_corner: NDArray[np.uint32]
) -> tuple[tuple[str, NDArray[np.float32]], ...]:
    """Colour attributes, linear, of corners or of points, bytes or floats."""
    colours = mesh.color_attributes
    active = colours.render_color_index
    maps = []
    for _, attribute in sorted(enumerate(colours), key=lambda one: one[0] != active):
        count = {"POINT": len(mesh.vertices), "CORNER": len(mesh.loops)}.get(attribute.domain, 0)
        if count == 0 or len(attribute.data) != count:  # of other domains shaders are told nothing
            continue
        rgba = _read(attribute.data, "color", (count, 4), np.float32)
        if attribute.domain == "POINT":
            rgba = rgba.take(vertex_of_corner.astype(np.intp), axis=0)
        red_green, blue_alpha = attribute_maps(attribute.name)
        maps += [(red_green, rgba[:, :2]), (blue_alpha, rgba[:, 2:])]
    return tuple(maps)
