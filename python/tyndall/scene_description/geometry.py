# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, voxels and strands, and where they stand."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray

if TYPE_CHECKING:
    from tyndall.voxel_dag import VoxelDag


ATTRIBUTE_MARK = "\x1f"  #: What no UV map's name begins with.


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Triangles in object space. Normals and UVs are per corner of a triangle.

    What ``_native.shared_array`` made is shared with native code, any other array copied.
    """

    key: str
    name: str
    positions: FloatArray  #: (vertices, 3), metres.
    triangles: NDArray[np.uint32]  #: (triangles, 3), into positions.
    material_slots: NDArray[np.uint16] | None = None  #: (triangles,); None: all 0.
    corner_normals: FloatArray | None = None  #: (triangles, 3, 3), unit; None: flat shading.
    #: Name and (triangles, 3, 2), the active one first; then colours, likewise, as attribute_maps() names them.
    uv_maps: tuple[tuple[str, FloatArray], ...] = ()
    vertex_normals: FloatArray | None = None  #: (vertices, 3), smooth; asked for by what moves the mesh alone.


def attribute_maps(name: str) -> tuple[str, str]:
    """Names of two UV maps that are an attribute of a surface: red and green, blue and alpha, linear.

    "": the active one. Voxels have "Color" and the names of their channels, numbers as colours of three equal parts.
    """
    return f"{ATTRIBUTE_MARK}rg {name}", f"{ATTRIBUTE_MARK}ba {name}"


ALL_SETS = (1 << 64) - 1


@dataclass(frozen=True, kw_only=True)
class LightLinks:
    """Which sets of objects an emitter lights, and which cast its shadows: bit s is set s, of up to 64."""

    receiver_sets: int = ALL_SETS
    blocker_sets: int = ALL_SETS


@dataclass(frozen=True, kw_only=True)
class ObjectLighting:
    """How light meets an object, beside its visibility; most objects have none of it."""

    light_group: str = ""  #: Of what it emits; one of SceneDescription.light_groups, or none.
    receiver_set: int = 0  #: That emitters light, or do not.
    blocker_set: int = 0  #: That casts emitters' shadows, or does not.
    links: LightLinks | None = None  #: Of what it emits; None: all.


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedObjects:
    """Every placement of the same geometry that shares its flags."""

    world_from_object: NDArray[np.float64]  #: (count, 4, 4), affine, may mirror.
    object_names: tuple[str, ...]  #: count names, for reports.
    is_camera_visible: bool = True
    casts_shadow: bool = True
    is_bounce_visible: bool = True  #: Its light falls on other surfaces by a bounce.
    is_mirror_visible: bool = True
    is_glass_visible: bool = True  #: Through what bends rays.
    lights_media: bool = True  #: Its light falls on media, if it glows.
    is_held_out: bool = False  #: What cameras see of it is cut out of the picture.
    is_shadow_catcher: bool = False  #: Of it cameras see only the shadows that others cast on it.
    lighting: ObjectLighting | None = None  #: None: as it begins.
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)  #: The object's own, for materials that ask.
    pass_index: float = 0.0
    random: NDArray[np.float32] | None = None  #: (count,) in [0, 1), for materials that ask; None: all 0.


@dataclass(frozen=True, kw_only=True, eq=False)
class Instances(PlacedObjects):
    """Every placement of one mesh that shares a material assignment and flags."""

    mesh: Mesh
    materials: tuple[int, ...]  #: Per material slot, into SceneDescription.materials.
    #: (count, 14), for materials that ask which particle each is: its index, a random number in [0, 1), age and
    #: lifetime in frames, size; location, velocity and angular velocity in the world. NaN: none. None: none is one.
    particles: NDArray[np.float32] | None = None
    #: (count, values, 4), for materials that ask what their instancer gives each: colours with alpha, as many for all
    #: groups that have some. None: all are 0.
    instancer_values: NDArray[np.float32] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class VoxelObjects(PlacedObjects):
    """Every placement of the same voxels that shares a material and flags. Voxels are opaque."""

    dag: VoxelDag  #: Told by itself, not by its content: keep it from frame to frame. Its bounds are in object space.
    material: int | None = None  #: Into SceneDescription.materials; None: grey.


class StrandForm(IntEnum):
    """How strands are drawn; native/scene/strands.hpp says what each is."""

    RIBBON = 0
    ROUND = 1
    ROUND_LINEAR = 2
    SPHERES = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Strands:
    """Hair in object space: smooth lines through points, each with a radius. Or, as SPHERES, points alone."""

    key: str
    name: str
    form: StrandForm
    points: FloatArray  #: (points, 4), metres: position and radius.
    first_points: NDArray[np.uint32]  #: (strands,), ascending from 0; of SPHERES empty.
    ribbon_pieces: int = 4  #: Straight pieces that a ribbon's segment is made of, [1, 16].
    layers: int = 1  #: How often a strand dims a ray that passes it on its way to light, 1 or 2.
    #: As those of Mesh, with one (strands, 2) or (points, 2) each; of points straight between them.
    uv_maps: tuple[tuple[str, FloatArray], ...] = ()
    randoms: FloatArray | None = None  #: Likewise, [0, 1), for materials that ask.


def hair_maps() -> dict[str, str]:
    """Names of UV maps that only strands have: what materials may ask of them, two numbers each.

    ``axy`` and ``az``, the way along a strand, are followed by two digits, the corners of a triangle between which a
    mesh's way is.
    """
    return {name: f"{ATTRIBUTE_MARK}hair {name}" for name in ("is", "il", "rt", "xy", "z", "axy", "az")}


def point_maps() -> tuple[str, str, str]:
    """Names of UV maps that only point clouds have: x and y of a point's centre, its z and radius, random and 1."""
    return f"{ATTRIBUTE_MARK}point xy", f"{ATTRIBUTE_MARK}point zr", f"{ATTRIBUTE_MARK}point random"


@dataclass(frozen=True, kw_only=True, eq=False)
class StrandObjects(PlacedObjects):
    """Every placement of the same strands that shares a material and flags. Strands are opaque."""

    strands: Strands
    material: int | None = None  #: Into SceneDescription.materials; None: grey.
