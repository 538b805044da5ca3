# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials ask of hair, curves and points: maps of two numbers each, one per strand or per point, by name.

Based on: blender v4.5.0, intern/cycles/blender/curves.cpp and pointcloud.cpp, for where each is read.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tyndall.linear_colours import linear_from_srgb
from tyndall.scene_description import attribute_maps, point_maps

from .mesh_attributes import GENERATED, in_texture_space, made_maps, told_of
from .random_numbers import as_unit_floats, hashes_of_two

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    import bpy
    from bpy.types import Object, ParticleSystemModifier
    from numpy.typing import NDArray

StrandMaps = tuple[tuple[str, "NDArray[np.float32]"], ...]

_ROOT_UVS = "surface_uv_coordinate"  #: The active UV map of hair curves, as Cycles names it.


def on_emitter(source: Object, modifier: ParticleSystemModifier, numbers: range, asked: Iterable[str]) -> StrandMaps:
    """What materials ask of the emitter's UV maps and colours, at the roots."""
    system, mesh = modifier.particle_system, source.data
    uv_layers, colours = list(mesh.uv_layers), list(mesh.vertex_colors)
    particles = list(system.particles)

    def values(read: Callable[..., Iterable[float]], width: int) -> NDArray[np.float32]:
        rows = [
            tuple(read(modifier, particles[min(number, len(particles) - 1)], particle_no=number))[:width]
            for number in numbers
        ]
        return np.array(rows, np.float32).reshape(-1, width)

    maps: dict[str, NDArray[np.float32]] = {}
    of_colours = attribute_maps("")[0]
    for name in sorted(asked):
        is_asked = [one.active_render if not name else one.name == name for one in uv_layers]
        uv = is_asked.index(True) if any(is_asked) else None
        if uv is not None:
            maps[uv_layers[uv].name] = values(partial(system.uv_on_emitter, uv_no=uv), 2)
        elif name.startswith(of_colours):
            wanted = name[len(of_colours) :]
            colour = next((at for at, one in enumerate(colours) if one.name == wanted), None)
            if colour is not None:
                stored = linear_from_srgb(values(partial(system.mcol_on_emitter, vcol_no=colour), 3))
                pair = attribute_maps(wanted)
                maps[pair[0]] = np.ascontiguousarray(stored[:, :2])
                maps[pair[1]] = np.column_stack([stored[:, 2], np.ones(len(stored), np.float32)])
    return tuple(maps.items())


def generated_at(
    roots: NDArray[np.float32], emitter: bpy.types.Mesh, asked: frozenset[str]
) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """Curves and points have no texture space: native code takes their places in the object, as Cycles does."""
    names = made_maps(GENERATED)
    if asked.intersection(names):
        values = np.column_stack([in_texture_space(emitter, roots), np.ones(len(roots), np.float32)])
        yield from zip(names, (np.ascontiguousarray(values[:, :2]), np.ascontiguousarray(values[:, 2:])), strict=True)


def point_info(points: NDArray[np.float32], asked: frozenset[str]) -> StrandMaps:
    """What Point Info tells, if a material asks."""
    xy, zr, random = point_maps()
    randoms = as_unit_floats(hashes_of_two(len(points) if random in asked else 0))
    made = {
        xy: points[:, :2],
        zr: points[:, 2:],
        random: np.column_stack([randoms, np.ones(len(randoms), np.float32)]),
    }
    return tuple((name, np.ascontiguousarray(values)) for name, values in made.items() if name in asked)


#: Properties of an attribute's elements, and how many numbers they are.
_VALUES = {
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "BOOLEAN": ("value", 1),
    "FLOAT2": ("vector", 2),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
}


def attributes_of(
    data: Any,  # noqa: ANN401  Curves, PointCloud
    asked: Iterable[str],
) -> StrandMaps:
    """Of what materials ask, one per strand or per point, as it is stored."""
    maps: dict[str, NDArray[np.float32]] = {}
    of_colours, tells = attribute_maps("")[0], told_of("")
    for name in sorted(asked):
        is_colour = name.startswith(of_colours)
        wanted = name[len(of_colours) :] if is_colour else name.removeprefix(tells) or _ROOT_UVS
        attribute = data.attributes.get(wanted)
        if attribute is None or attribute.data_type not in _VALUES:
            continue
        if name.startswith(tells):
            is_pair = attribute.data_type == "FLOAT2"
            maps[name] = np.full((len(attribute.data), 2), (1.0, 1.0 if is_pair else 0.0), np.float32)
            continue
        field, width = _VALUES[attribute.data_type]
        stored = np.empty(len(attribute.data) * width, np.float32)
        attribute.data.foreach_get(field, stored)
        values = stored.reshape(-1, width)
        if not is_colour:
            both = np.repeat(values, 2, axis=1) if width == 1 else values
            maps[attribute.name] = np.ascontiguousarray(both[:, :2])
            continue
        four = np.zeros((len(values), 4), np.float32)
        four[:, 3] = 1.0
        four[:, : 3 if width == 1 else width] = values  # a number is a grey colour
        red_green, blue_alpha = attribute_maps(attribute.name)
        maps[red_green] = np.ascontiguousarray(four[:, :2])
        maps[blue_alpha] = np.ascontiguousarray(four[:, 2:])
    return tuple(maps.items())
