# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and points: particle systems of hair, hair curves and point clouds, as Cycles draws them.

Based on: blender v4.5.0, intern/cycles/blender/curves.cpp and pointcloud.cpp, for which points and radii there are, and
which of them a child has.
``ParticleSystem.co_hair`` tells one point at a time: what a live depsgraph has not updated is not read again, nor are
hairs that were read when a viewport interrupted.
"""

from __future__ import annotations

import hashlib
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from tyndall.linear_colours import linear_from_srgb
from tyndall.scene_description import StrandForm, StrandObjects, Strands, attribute_maps, point_maps

from .asking_materials import note_unread
from .mesh_attributes import GENERATED, in_texture_space, made_maps, told_of, uv_maps_of
from .random_numbers import as_unit_floats, hashes_of_two

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from bpy.types import Depsgraph, Object, ParticleSystem, ParticleSystemModifier
    from mathutils import Matrix
    from numpy.typing import NDArray

    from .instances import Placement
    from .materials import MaterialReader
    from .reports import Reports

_FORMS = {"RIBBONS": StrandForm.RIBBON, "THICK": StrandForm.ROUND, "THICK_LINEAR": StrandForm.ROUND_LINEAR}
_CURVE_RADIUS_M, _POINT_RADIUS_M = 0.005, 0.01  #: Where there is no such attribute.
_MOST_PIECES = 16
_POLL_EVERY = 256  #: Hairs.
_ROOT_UVS = "surface_uv_coordinate"  #: The active UV map of hair curves, as Cycles names it.


def is_strands(placement: Placement) -> bool:
    """Whether it is drawn by strands or spheres."""
    return placement.hair is not None or isinstance(placement.data, (bpy.types.Curves, bpy.types.PointCloud))


class StrandReader:
    """Reads the hair of frames one after another; keeps what the next frame may share."""

    def __init__(self) -> None:
        self._kept: dict[str, Strands] = {}
        self._live: dict[tuple[object, ...], tuple[Strands | None, set[int]]] = {}
        self._begun: dict[tuple[object, ...], _HairPlaces] = {}
        self._finished_count = 0

    @property
    def hair_count(self) -> int:
        """Of particle systems: how many hairs were read so far that stay if a read is interrupted."""
        return self._finished_count + sum(begun.count for begun in self._begun.values())

    def forget_stale(self, stale: set[int] | None) -> None:
        """What depends on these datablocks may be others now; None: all evaluated data may be."""
        if stale is None or stale:
            self._begun.clear()
        self._live = {
            key: (strands, depends_on)
            for key, (strands, depends_on) in self._live.items()
            if stale is not None and not depends_on & stale
        }

    def read(
        self,
        placements: list[Placement],
        depsgraph: Depsgraph,
        materials: MaterialReader,
        reports: Reports,
        poll: Callable[[], None],
    ) -> tuple[StrandObjects, ...]:
        """Of placements that are strands. What has none is left out, with a report."""
        form, pieces = _form_of(depsgraph.scene_eval)
        of_passes = frozenset({""} if depsgraph.view_layer_eval.use_pass_uv else ())
        groups = []
        live: dict[tuple[object, ...], tuple[Strands | None, set[int]]] = {}
        for placement in placements:
            poll()
            note_unread(placement, reports)
            material = materials.index(placement.materials[_slot_of(placement)], placement)
            asked = of_passes.union(uv_maps_of(materials.materials[material]))
            key = (placement.data.as_pointer(), placement.hair, form, pieces, asked)
            if key not in live:
                live[key] = self._live.get(key) or (
                    self._read(placement, depsgraph, form, pieces, asked, reports, poll),
                    placement.depends_on,
                )
                self._live[key] = live[key]  # at once: a viewport reads in slices, and the next one goes on from here
            if (strands := live[key][0]) is not None:
                if materials.materials[material].medium >= 0:
                    reports.add(
                        f'Object "{placement.object_name}"', "hair bounds no medium: its material's volume is left out"
                    )
                groups.append(_group(placement, strands, material))
        self._live = live
        self._kept = {group.strands.key: group.strands for group in groups}
        return tuple(groups)

    def _read(
        self,
        placement: Placement,
        depsgraph: Depsgraph,
        form: StrandForm,
        pieces: int,
        asked: frozenset[str],
        reports: Reports,
        poll: Callable[[], None],
    ) -> Strands | None:
        name = f'Object "{placement.object_name}"'
        if placement.hair is not None:
            modifier = placement.source.modifiers[placement.hair]
            system = f'{name}, particle system "{modifier.particle_system.name}"'
            key = placement.data.as_pointer(), placement.hair
            begun = self._begun.setdefault(key, _HairPlaces())
            found = _particle_hair(placement.source, modifier, asked, begun, poll, is_final=depsgraph.mode == "RENDER")
            self._finished_count += self._begun.pop(key).count
            if found is None:
                reports.add(system, "has no hair")
                return None
            points, firsts, maps = found
        elif isinstance(placement.data, bpy.types.PointCloud):
            form, pieces = StrandForm.SPHERES, 1
            points = _points(placement.data, len(placement.data.points), _POINT_RADIUS_M)
            firsts = np.zeros(0, np.uint32)
            maps = (*_attributes(placement.data, asked), *_of_points(points, asked))
        else:
            points = _points(placement.data, len(placement.data.points), _CURVE_RADIUS_M)
            firsts = np.zeros(len(placement.data.curves), np.int32)
            placement.data.curves.foreach_get("first_point_index", firsts)
            firsts = firsts.astype(np.uint32)
            maps = _attributes(placement.data, asked)
            if bpy.app.version >= (5, 0, 0) and _has_poly_curves(placement.data):
                reports.add(name, "poly curves are drawn smooth; Cycles 5.0 draws them straight from point to point")
        if len(points) == 0:
            reports.add(name, "has no hair or point")
            return None
        randoms = as_unit_floats(hashes_of_two(len(firsts)))
        return self._strands(name, form, pieces, points, firsts, maps, randoms if len(firsts) else None)

    def _strands(
        self,
        name: str,
        form: StrandForm,
        pieces: int,
        points: NDArray[np.float32],
        firsts: NDArray[np.uint32],
        maps: tuple[tuple[str, NDArray[np.float32]], ...],
        randoms: NDArray[np.float32] | None,
    ) -> Strands:
        digest = hashlib.sha256(repr((form, pieces, points.shape, [known for known, _ in maps])).encode())
        for array in (points, firsts, *(values for _, values in maps)):
            if array.size:
                digest.update(memoryview(np.ascontiguousarray(array)).cast("B"))
        key = digest.hexdigest()
        return self._kept.get(key) or Strands(
            key=key,
            name=name,
            form=form,
            points=points,
            first_points=firsts,
            ribbon_pieces=pieces,
            uv_maps=maps,
            randoms=randoms,
        )


def _form_of(scene: bpy.types.Scene) -> tuple[StrandForm, int]:
    """What Cycles is set to draw; it makes as many pieces of a ribbon's segment, and one more."""
    settings = getattr(scene, "cycles_curves", None)  # nothing without Cycles
    if settings is None:
        return StrandForm.RIBBON, 5
    return _FORMS.get(settings.shape, StrandForm.RIBBON), min(2**settings.subdivisions + 1, _MOST_PIECES)


def _slot_of(placement: Placement) -> int:
    if placement.hair is None:
        return 0
    wanted: int = placement.source.modifiers[placement.hair].particle_system.settings.material - 1
    return max(0, min(wanted, len(placement.materials) - 1))


def _group(placement: Placement, strands: Strands, material: int) -> StrandObjects:
    return StrandObjects(
        strands=strands,
        world_from_object=placement.world_from_object(),
        object_names=(placement.object_name,) * len(placement.matrices),
        material=material,
        is_camera_visible=placement.is_camera_visible,
        casts_shadow=placement.casts_shadow,
        is_bounce_visible=placement.is_bounce_visible,
        is_mirror_visible=placement.is_mirror_visible,
        is_glass_visible=placement.is_glass_visible,
        is_held_out=placement.is_held_out,
        is_shadow_catcher=placement.is_shadow_catcher,
        lighting=placement.lighting,
        color=placement.color,
        pass_index=float(placement.pass_index),
        random=as_unit_floats(placement.random_numbers),
    )


_Read = tuple["NDArray[np.float32]", "NDArray[np.uint32]", "tuple[tuple[str, NDArray[np.float32]], ...]"]


class _HairPlaces:
    """Points of a particle system's hairs in the world. A read that is interrupted goes on where it was."""

    def __init__(self) -> None:
        self.count = 0  #: Hairs that are read.
        self._places = np.empty((0, 0, 3))
        self._world_from_emitter: Matrix | None = None

    def read(
        self, source: Object, system: ParticleSystem, numbers: range, steps: int, poll: Callable[[], None]
    ) -> NDArray[np.float64]:
        """(hairs, steps, 3)."""
        if self._world_from_emitter != source.matrix_world or self._places.shape[:2] != (len(numbers), steps):
            self._world_from_emitter = source.matrix_world.copy()
            self._places, self.count = np.empty((len(numbers), steps, 3)), 0
        co_hair: Any = system.co_hair
        places, of_hair = self._places, range(steps)
        while self.count < len(numbers):
            poll()
            for row in range(self.count, min(self.count + _POLL_EVERY, len(numbers))):
                places[row] = [co_hair(source, particle_no=numbers[row], step=step) for step in of_hair]
                self.count += 1
        return places


def _particle_hair(
    source: Object,
    modifier: ParticleSystemModifier,
    asked: frozenset[str],
    begun: _HairPlaces,
    poll: Callable[[], None],
    *,
    is_final: bool,
) -> _Read | None:
    system = modifier.particle_system
    settings = system.settings
    parents = len(system.particles)
    children = len(system.child_particles)
    if not is_final:
        children = int(children * settings.display_percentage / 100.0)
    numbers = range(parents, parents + children) if settings.child_type != "NONE" and children else range(parents)
    steps = 2 ** (settings.render_step if is_final else settings.display_step) + 1
    if settings.kink == "SPIRAL":
        steps += settings.kink_extra_steps
    if not numbers:
        return None
    places = begun.read(source, system, numbers, steps, poll)
    object_from_world = np.linalg.pinv(np.array(source.matrix_world, np.float64))
    places = places @ object_from_world[:3, :3].T + object_from_world[:3, 3]
    points = np.empty((len(numbers), steps, 4), np.float32)
    points[..., :3] = places
    points[..., 3] = _radii(settings, places)
    firsts = np.arange(len(numbers), dtype=np.uint32) * np.uint32(steps)
    maps = (*_on_emitter(source, modifier, numbers, asked), *_generated_at(points[:, 0, :3], source.data, asked))
    return points.reshape(-1, 4), firsts, maps


def _generated_at(
    roots: NDArray[np.float32], emitter: bpy.types.Mesh, asked: frozenset[str]
) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """Curves and points have no texture space: native code takes their places in the object, as Cycles does."""
    names = made_maps(GENERATED)
    if asked.intersection(names):
        values = np.column_stack([in_texture_space(emitter, roots), np.ones(len(roots), np.float32)])
        yield from zip(names, (np.ascontiguousarray(values[:, :2]), np.ascontiguousarray(values[:, 2:])), strict=True)


def _radii(settings: bpy.types.ParticleSettings, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """By the share of its length at which a point lies."""
    with np.errstate(invalid="ignore", divide="ignore"):
        steps_m = np.linalg.norm(np.diff(places, axis=1), axis=2)
        along = np.concatenate([np.zeros((len(places), 1)), np.cumsum(steps_m, axis=1)], axis=1)
        share = np.where(along[:, -1:] > 0.0, along / along[:, -1:], 0.0)
        left = np.clip(1.0 - share, 0.0, 1.0)
        shape = settings.shape
        left = left ** (1.0 + shape if shape < 0.0 else 1.0 / max(1.0 - shape, 1e-9))
    root, tip = (0.5 * settings.radius_scale * radius for radius in (settings.root_radius, settings.tip_radius))
    radii: NDArray[np.float64] = left * (root - tip) + tip
    if settings.use_close_tip:
        radii[:, -1] = 0.0
    return radii


def _on_emitter(
    source: Object, modifier: ParticleSystemModifier, numbers: range, asked: Iterable[str]
) -> tuple[tuple[str, NDArray[np.float32]], ...]:
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


def _points(data: Any, count: int, default_radius_m: float) -> NDArray[np.float32]:  # noqa: ANN401  Curves, PointCloud
    points = np.zeros((count, 4), np.float32)
    if count == 0:  # it may lack the attributes, too
        return points
    places = np.empty(3 * count, np.float32)
    data.attributes["position"].data.foreach_get("vector", places)
    radii = np.full(count, default_radius_m, np.float32)
    if (stored := data.attributes.get("radius")) is not None and stored.domain == "POINT":
        stored.data.foreach_get("value", radii)
    points[:, :3], points[:, 3] = places.reshape(-1, 3), radii
    return points


def _of_points(points: NDArray[np.float32], asked: frozenset[str]) -> tuple[tuple[str, NDArray[np.float32]], ...]:
    """What Point Info tells, if a material asks."""
    xy, zr, random = point_maps()
    randoms = as_unit_floats(hashes_of_two(len(points) if random in asked else 0))
    made = {
        xy: points[:, :2],
        zr: points[:, 2:],
        random: np.column_stack([randoms, np.ones(len(randoms), np.float32)]),
    }
    return tuple((name, np.ascontiguousarray(values)) for name, values in made.items() if name in asked)


def _has_poly_curves(data: Any) -> bool:  # noqa: ANN401  Curves
    """Without the attribute all are Catmull-Rom."""
    stored = data.attributes.get("curve_type")
    if stored is None or len(stored.data) == 0:
        return False
    kinds = np.empty(len(stored.data), np.int32)
    stored.data.foreach_get("value", kinds)
    return bool((kinds == 1).any())


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


def _attributes(
    data: Any,  # noqa: ANN401  Curves, PointCloud
    asked: Iterable[str],
) -> tuple[tuple[str, NDArray[np.float32]], ...]:
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
