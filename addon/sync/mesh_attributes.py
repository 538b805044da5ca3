# SPDX-License-Identifier: GPL-3.0-or-later
"""What meshes have for the materials that ask: texture space, tangents, and attributes of any kind.

Four numbers at each corner each, as two UV maps under names that no UV map and no attribute has.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from tyndall.scene_description import ATTRIBUTE_MARK, attribute_maps

from .corner_tangents import corner_tangents
from .mesh_structure import pointiness, random_per_island

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from tyndall.scene_description import Material

GENERATED = "generated"
VERTEX_NORMALS = "vertex normals"  #: What is no map: smooth, also where faces are flat.
UNDISPLACED = "undisplaced"  #: Position before the material's displacement, in the object.
POINTINESS = "pointiness"
ISLAND = "random per island"
_TANGENT = "tangent "  #: And the name of a UV map.
_OF_COLOURS = attribute_maps("")[0]
_TOLD = f"{ATTRIBUTE_MARK}is "  #: And the name of an attribute.
#: Properties of an attribute's elements, and how many numbers they are; a fourth number is 1.
_VALUES = {
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "INT8": ("value", 1),
    "BOOLEAN": ("value", 1),
    "FLOAT2": ("vector", 2),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
}


def made_maps(name: str) -> tuple[str, str]:
    """Names of the two UV maps that hold x and y, and z and w."""
    return f"{ATTRIBUTE_MARK}xy {name}", f"{ATTRIBUTE_MARK}zw {name}"


def tangent_of(uv_map: str) -> str:
    """What to ask for: the tangent along u of a UV map, "" the active one, and on which side v lies."""
    return _TANGENT + uv_map


def told_of(attribute: str) -> str:
    """What to ask for: a map of whether there is such an attribute, and whether that is a pair, 1 or 0 each."""
    return _TOLD + attribute


def asked_of_meshes(materials: Iterable[Material], data: bpy.types.ID | None = None) -> frozenset[str]:
    """What materials read beside UV maps: first names of pairs, ``VERTEX_NORMALS``, and of other maps.

    Of ``data``, a mesh, also attributes that are read as UV maps, and are none.
    """
    firsts, used = (made_maps("")[0], _OF_COLOURS, _TOLD), list(materials)
    names = {name for material in used for name in uv_maps_of(material)}
    asked = {name for name in names if name.startswith(firsts)}
    if isinstance(data, bpy.types.Mesh):
        asked |= {name for name in names - asked if name in data.attributes and name not in data.uv_layers}
    are_moved = any(material.displacement is not None for material in used)
    return frozenset(asked | {VERTEX_NORMALS} if are_moved else asked)


def uv_maps_of(material: Material) -> tuple[str, ...]:
    """What it reads, for its passes, too."""
    of_passes = (name for _, program in material.aovs for name in program.uv_maps)
    if material.displacement is None:
        return (*material.uv_maps, *of_passes)
    return (*material.uv_maps, *of_passes, *material.displacement.program.uv_maps)


def what_is_missing(asked: Iterable[str], has: Iterable[str]) -> list[str]:
    """In words, of what only this file makes."""
    first, known = made_maps("")[0], set(has)
    missing = []
    for name in asked:
        if not name.startswith(first) or name in known:
            continue
        made = name[len(first) :]
        uv_map = made[len(_TANGENT) :]
        of_map = f'of UV map "{uv_map}" ' if uv_map else ""
        missing.append(
            f"tangents {of_map}(no UV map)"
            if made.startswith(_TANGENT)
            else made
            if made in {POINTINESS, ISLAND}
            else "texture space"
        )
    return missing


def read_asked(
    mesh: bpy.types.Mesh, asked: Iterable[str], known: Iterable[str], vertex_of_corner: NDArray[np.uint32]
) -> tuple[tuple[str, NDArray[np.float32]], ...]:
    """Of the maps asked for those that are not known and that the mesh can have: (corners, 2) each."""
    maps: list[tuple[str, NDArray[np.float32]]] = []
    has = set(known)

    def stand_in(names: Iterable[str]) -> None:
        """For what goes by no name, which is the first of its kind, where there is none: not another attribute."""
        maps.extend((name, np.zeros((len(vertex_of_corner), 2), np.float32)) for name in names)

    colours = {name for name in (*asked, *has) if name.startswith(_OF_COLOURS)}
    if _OF_COLOURS in colours and len(colours) > 1 and not any(name in colours for name in has):
        stand_in(attribute_maps(""))
        has |= {_OF_COLOURS}
    has_other_uvs = any(not name.startswith(ATTRIBUTE_MARK) and name != VERTEX_NORMALS for name in asked)
    if has_other_uvs and len(mesh.uv_layers) == 0:
        stand_in([""])
    for name in sorted(asked):
        if name in has or name == VERTEX_NORMALS:
            continue
        if name.startswith(_TOLD):
            maps += _told(mesh, name, vertex_of_corner)
            continue
        if not name.startswith(ATTRIBUTE_MARK):
            as_uvs = _any_attribute(mesh, name, vertex_of_corner)
            maps += [] if as_uvs is None else [(name, as_uvs[:, :2])]
            continue
        if name.startswith(_OF_COLOURS):
            attribute = name[len(_OF_COLOURS) :]
            values, pair = _any_attribute(mesh, attribute, vertex_of_corner), attribute_maps(attribute)
        else:
            made = name[len(made_maps("")[0]) :]
            values, pair = _made(mesh, made, vertex_of_corner), made_maps(made)
        if values is not None:
            maps += [(pair[0], values[:, :2]), (pair[1], values[:, 2:])]
    return tuple(maps)


def _told(
    mesh: bpy.types.Mesh, name: str, vertex_of_corner: NDArray[np.uint32]
) -> list[tuple[str, NDArray[np.float32]]]:
    attribute = name[len(_TOLD) :]
    if _any_attribute(mesh, attribute, vertex_of_corner) is None:
        return []
    is_pair = attribute in mesh.uv_layers or mesh.attributes[attribute].data_type == "FLOAT2"
    return [(name, np.full((len(vertex_of_corner), 2), (1.0, 1.0 if is_pair else 0.0), np.float32))]


def _made(mesh: bpy.types.Mesh, name: str, vertex_of_corner: NDArray[np.uint32]) -> NDArray[np.float32] | None:
    of_vertices = _OF_VERTICES.get(name)
    if of_vertices is not None:
        return _with_one(of_vertices(mesh).take(vertex_of_corner.astype(np.intp), axis=0))
    return _tangents(mesh, name[len(_TANGENT) :]) if name.startswith(_TANGENT) else None


def vertex_normals(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    return _stored(mesh.vertex_normals, "vector", 3)


def _positions(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    return _stored(mesh.vertices, "co", 3)


def _edges(mesh: bpy.types.Mesh) -> NDArray[np.intp]:
    edges = np.empty((len(mesh.edges), 2), np.int32)
    mesh.edges.foreach_get("vertices", edges.reshape(-1))
    return edges.astype(np.intp)


def _pointiness(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    return np.repeat(pointiness(_positions(mesh), vertex_normals(mesh), _edges(mesh))[:, None], 3, axis=1)


def _island(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    return np.repeat(random_per_island(len(mesh.vertices), _edges(mesh))[:, None], 3, axis=1)


def _generated(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    undeformed = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("undeformed_co", undeformed.reshape(-1))
    return in_texture_space(mesh, undeformed)


def in_texture_space(mesh: bpy.types.Mesh, places: NDArray[np.float32]) -> NDArray[np.float32]:
    """(places, 3), as Cycles scales them."""
    location, size = (np.array(value, np.float32) for value in (mesh.texspace_location, mesh.texspace_size))
    per_metre = np.divide(np.float32(0.5), size, out=np.zeros(3, np.float32), where=size != 0.0)
    scaled: NDArray[np.float32] = (places - location) * per_metre + np.float32(0.5)
    return scaled


_OF_VERTICES = {
    GENERATED: _generated,
    UNDISPLACED: _positions,
    POINTINESS: _pointiness,
    ISLAND: _island,
}


def _tangents(mesh: bpy.types.Mesh, uv_map: str) -> NDArray[np.float32] | None:
    layers = mesh.uv_layers
    if not uv_map:
        uv_map = next((layer.name for layer in layers if layer.active_render), "")
    if uv_map not in layers:
        return None
    try:
        mesh.calc_tangents(uvmap=uv_map)
    except RuntimeError:  # of polygons with more than four corners
        return _tangents_by_triangles(mesh, uv_map)
    values = np.empty((len(mesh.loops), 4), np.float32)
    tangents = np.empty((len(mesh.loops), 3), np.float32)
    signs = np.empty(len(mesh.loops), np.float32)
    mesh.loops.foreach_get("tangent", tangents.reshape(-1))
    mesh.loops.foreach_get("bitangent_sign", signs)
    values[:, :3], values[:, 3] = tangents, signs
    mesh.free_tangents()
    return values


def _tangents_by_triangles(mesh: bpy.types.Mesh, uv_map: str) -> NDArray[np.float32]:
    corners = len(mesh.loops)
    vertices, triangles = np.empty(corners, np.int32), np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    mesh.loop_triangles.foreach_get("loops", triangles.reshape(-1))
    if bpy.app.version >= (4, 1, 0):
        normals = _stored(mesh.corner_normals, "vector", 3)
    else:
        mesh.calc_normals_split()
        normals = _stored(mesh.loops, "normal", 3)
    uvs = _stored(mesh.uv_layers[uv_map].data, "uv", 2)
    return corner_tangents(_positions(mesh)[vertices], normals, uvs, triangles.astype(np.intp))


def _any_attribute(mesh: bpy.types.Mesh, name: str, vertex_of_corner: NDArray[np.uint32]) -> NDArray[np.float32] | None:
    """A number is a grey colour; what is neither of points, corners nor faces is not known."""
    if name in mesh.uv_layers:
        layer = mesh.uv_layers[name]
        uvs = np.empty((len(mesh.loops), 2), np.float32)
        layer.data.foreach_get("uv", uvs.reshape(-1))
        return _with_one(np.column_stack([uvs, np.zeros(len(uvs), np.float32)]))
    attribute = mesh.attributes.get(name) if name else None
    if attribute is None or attribute.data_type not in _VALUES:
        return None
    field, channels = _VALUES[attribute.data_type]
    stored = _stored(attribute.data, field, channels)
    if attribute.domain == "POINT":
        stored = stored.take(vertex_of_corner.astype(np.intp), axis=0)
    elif attribute.domain == "FACE":
        counts = np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("loop_total", counts)
        stored = np.repeat(stored, counts, axis=0)
    elif attribute.domain != "CORNER":
        return None
    if len(stored) != len(mesh.loops):
        return None
    if channels == 1:
        stored = np.repeat(stored, 3, axis=1)
    elif channels == 2:  # noqa: PLR2004  x and y
        stored = np.column_stack([stored, np.zeros(len(stored), np.float32)])
    return stored if stored.shape[1] == 4 else _with_one(stored)  # noqa: PLR2004


def _stored(elements: Any, field: str, channels: int) -> NDArray[np.float32]:  # noqa: ANN401  any bpy_prop_collection
    values = np.empty(len(elements) * channels, np.float32)
    elements.foreach_get(field, values)
    return values.reshape(-1, channels)


def _with_one(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    ones = np.ones((len(vectors), 1), np.float32)
    with_one: NDArray[np.float32] = np.concatenate([vectors.astype(np.float32), ones], axis=1)
    return with_one
