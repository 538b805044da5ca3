# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and points: particle systems of hair, hair curves and point clouds, as Cycles draws them.

Based on: blender v4.5.0, intern/cycles/blender/curves.cpp and pointcloud.cpp, for which points and radii there are, and
which of them a child has.
``ParticleSystem.co_hair`` tells one point at a time: what a live depsgraph has not updated is not read again, nor are
hairs that were read when a viewport interrupted.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from tyndall.scene_description import StrandForm, StrandObjects, Strands

from .asking_materials import note_unread
from .mesh_attributes import uv_maps_of
from .placed_objects import placed
from .random_numbers import as_unit_floats, hashes_of_two
from .strand_maps import StrandMaps, attributes_of, generated_at, on_emitter, point_info

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Depsgraph, Object, ParticleSystem, ParticleSystemModifier
    from mathutils import Matrix
    from numpy.typing import NDArray

    from .instances import Placement
    from .materials import MaterialReader
    from .reports import Reports

_FORMS = {"RIBBONS": StrandForm.RIBBON, "THICK": StrandForm.ROUND, "THICK_LINEAR": StrandForm.ROUND_LINEAR}
#: Tubes that let light pass dim what is behind them once in 3.4's Cycles; later ones meet their far sides, too.
_TUBES_DIM_TWICE = bpy.app.version >= (4, 0, 0)
_CURVE_RADIUS_M, _POINT_RADIUS_M = 0.005, 0.01  #: Where there is no such attribute.
_MOST_PIECES = 16
_POLL_EVERY = 256  #: Hairs.


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
            maps = (*attributes_of(placement.data, asked), *point_info(points, asked))
        else:
            points = _points(placement.data, len(placement.data.points), _CURVE_RADIUS_M)
            firsts = np.zeros(len(placement.data.curves), np.int32)
            placement.data.curves.foreach_get("first_point_index", firsts)
            firsts = firsts.astype(np.uint32)
            maps = attributes_of(placement.data, asked)
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
        maps: StrandMaps,
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
            layers=2 if form is StrandForm.ROUND and _TUBES_DIM_TWICE else 1,
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
        material=material,
        **placed(placement),
    )


_Read = tuple["NDArray[np.float32]", "NDArray[np.uint32]", StrandMaps]


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
    maps = (*on_emitter(source, modifier, numbers, asked), *generated_at(points[:, 0, :3], source.data, asked))
    return points.reshape(-1, 4), firsts, maps


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


def _has_poly_curves(data: Any) -> bool:  # noqa: ANN401  Curves
    """Without the attribute all are Catmull-Rom."""
    stored = data.attributes.get("curve_type")
    if stored is None or len(stored.data) == 0:
        return False
    kinds = np.empty(len(stored.data), np.int32)
    stored.data.foreach_get("value", kinds)
    return bool((kinds == 1).any())
