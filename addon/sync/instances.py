# SPDX-License-Identifier: GPL-3.0-or-later
"""Every placement of every mesh, volume and hair that Cycles would draw, grouped so that 100,000 of them cost 0.2 s.

The depsgraph yields what is drawn: objects, and instances of collections, particles and geometry nodes, nested ones
already resolved. Curves, texts and metaballs come twice, as themselves and as the mesh they evaluate to: only items
whose data is a Mesh count, as in Cycles. An object's particle hair comes with each of its items that shows particles.
What hides an instance is its instancer: the view layer's "indirect only", and in a window what that viewport hides, as
in local view. The depsgraph of a window is that of all its viewports, and holds collections that are hidden there.
Reading ``instance.object`` makes a new Python object each time (1.4 us), ``instance.instance_object`` does not: it
alone names the mesh of an instance, unless that object has geometry nodes, whose instances may be of any mesh.
``object_instances.foreach_get`` would read the matrices three times as fast, but leaks the instances of the last object
(219 bytes each, in 3.4 to 5.0).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from itertools import chain, compress
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..baked_air import is_baked_air
from .adaptive_subdivision import note_adaptive
from .instancer_values import InstancerReader
from .names import address_of, name_of
from .object_lighting import LightingReader
from .particles import ParticleReader
from .random_numbers import random_number_of
from .terminator_offsets import note_terminator

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from bpy.types import (
        Curves,
        Depsgraph,
        DepsgraphObjectInstance,
        LayerCollection,
        Material,
        Mesh,
        Object,
        PointCloud,
        SpaceView3D,
        Volume,
    )
    from mathutils import Matrix
    from numpy.typing import NDArray

    from tyndall.scene_description import ObjectLighting

    from .asked_properties import Asked
    from .instancer_values import Row
    from .names import Name
    from .reports import Reports

_POLL_EVERY = 2048  #: Instances between two polls, about 5 ms.
#: Ray visibility of an object, beside that to cameras.
OTHER_RAYS = ("visible_shadow", "visible_diffuse", "visible_glossy", "visible_transmission")

_INSTANCING = {"NODES", "PARTICLE_SYSTEM"}  #: Modifiers.

#: Of a 3D viewport, by kind of object: all that may have a mesh or instances, lights and volumes.
_SWITCHES = {
    "MESH": "show_object_viewport_mesh",
    "CURVE": "show_object_viewport_curve",
    "SURFACE": "show_object_viewport_surf",
    "META": "show_object_viewport_meta",
    "FONT": "show_object_viewport_font",
    "EMPTY": "show_object_viewport_empty",
    "LIGHT": "show_object_viewport_light",
    "VOLUME": "show_object_viewport_volume",
    "CURVES": "show_object_viewport_curves",
    "POINTCLOUD": "show_object_viewport_pointcloud",
}


@dataclass(kw_only=True, eq=False)
class Placement:
    """Instances that share mesh, materials and visibility."""

    object_name: str
    data: Mesh | Volume | Curves | PointCloud | None  #: None for a light.
    materials: tuple[Material | None, ...]  #: Evaluated; one per slot.
    source: Object  #: Evaluated object whose data it is; valid while the depsgraph is.
    is_camera_visible: bool
    casts_shadow: bool
    is_bounce_visible: bool = True
    is_mirror_visible: bool = True
    is_glass_visible: bool = True
    lights_media: bool = True  #: If it glows.
    is_held_out: bool = False
    is_shadow_catcher: bool = False  #: Of a light: its shadows show on catchers.
    lighting: ObjectLighting | None = None
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    pass_index: int = 0
    matrices: list[Matrix] = field(default_factory=list)  #: World from object, one per instance.
    random_numbers: list[int] = field(default_factory=list)  #: 32 bits, one per instance.
    #: Addresses (address_of) of datablocks whose geometry updates make this mesh stale.
    depends_on: set[int] = field(default_factory=set)
    own_random_number: int | None = None  #: Of what is no instance.
    is_instanced: bool = False  #: By another object; one of its instances is, if it is a light.
    particle_rows: list[int] | None = None  #: Of ParticleReader, one per instance; None: no material asks.
    instancer_rows: list[Row] | None = None  #: Likewise of InstancerReader, and the numbers of its values.
    instancer_numbers: dict[Asked, int] | None = None
    #: What these say: arrays of tyndall.scene_description.Instances, by name.
    told: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    hair: str | None = None  #: The modifier of the particle hair that is drawn in place of the data.

    def add(self, instance: DepsgraphObjectInstance) -> None:
        self.matrices.append(instance.matrix_world.copy())
        is_own = self.own_random_number is not None and not instance.is_instance
        self.random_numbers.append(self.own_random_number if is_own else instance.random_id & 0xFFFFFFFF)

    def world_from_object(self) -> NDArray[np.float64]:
        """All instances, (count, 4, 4), [row, column]."""
        # Twice as fast as numpy.array.
        numbers: Iterator[float] = chain.from_iterable(chain.from_iterable(self.matrices))
        return np.fromiter(numbers, np.float64, 16 * len(self.matrices)).reshape(-1, 4, 4)


def read_placements(
    depsgraph: Depsgraph, reports: Reports, poll: Callable[[], None], viewport: SpaceView3D | None = None
) -> list[Placement]:
    """Of meshes, volumes, hair and lights, what ``viewport`` shows. ``poll`` is called often, may raise."""
    grouping = _Grouping(depsgraph, reports, viewport)
    for index, instance in enumerate(depsgraph.object_instances):
        if index % _POLL_EVERY == 0:
            poll()
        for of_hair in grouping.hair_of(instance):
            of_hair.add(instance)
        placement = grouping.placement_of(instance)
        if placement is not None:
            placement.add(instance)
            if placement.particle_rows is not None:
                placement.particle_rows.append(grouping.particles.row_of(instance))
            if placement.instancer_rows is not None:
                placement.instancer_rows.append(grouping.instancers.row_of(instance))
    return grouping.placements()


def may_stand_alone(source: Object, depsgraph: Depsgraph) -> bool:
    """Whether an evaluated object is drawn as itself, and instances no other."""
    return not (
        source.is_instancer
        or source.instance_type != "NONE"
        or any(modifier.type in _INSTANCING for modifier in source.modifiers)
        or source.hide_viewport
        or not source.visible_get(view_layer=depsgraph.view_layer_eval)
    )


def shown_kinds(viewport: SpaceView3D | None) -> tuple[object, ...]:
    """Everything that decides what a viewport shows and is told by no update of a depsgraph."""
    if viewport is None:
        return ()
    view = viewport.local_view
    switches = (getattr(viewport, shows) for shows in _SWITCHES.values())
    return viewport.as_pointer(), view and view.as_pointer(), viewport.use_local_collections, *switches


def instanced_names(depsgraph: Depsgraph, poll: Callable[[], None]) -> dict[Name, set[str]]:
    """By an object of the scene: names, as placements have them, of all that it instances."""
    names: dict[Name, set[str]] = {}
    for index, instance in enumerate(depsgraph.object_instances):
        if index % _POLL_EVERY == 0:
            poll()
        if instance.is_instance:
            names.setdefault(name_of(instance.parent), set()).add(instance.instance_object.name)
    return names


class _Grouping:
    def __init__(self, depsgraph: Depsgraph, reports: Reports, viewport: SpaceView3D | None) -> None:
        self._depsgraph = depsgraph
        self._reports = reports
        self._viewport = viewport
        self._hidden_kinds = {kind for kind, shows in _SWITCHES.items() if viewport and not getattr(viewport, shows)}
        of_layer = depsgraph.view_layer_eval.layer_collection
        self._has_indirect_only = _is_any(of_layer, "indirect_only")
        self._has_holdouts = _is_any(of_layer, "holdout")
        self._placements: dict[tuple[object, ...], Placement | None] = {}
        # Of objects all of whose instances look the same, but for what limits their instancer.
        self._plain: dict[tuple[Object, Object | None], Placement | None] = {}
        self._hair = _hair_by_object(depsgraph)
        self._lighting = LightingReader.of(depsgraph, reports)
        self.particles = ParticleReader(depsgraph)
        self.instancers = InstancerReader(depsgraph, reports)
        indirect = depsgraph.scene_eval.tyndall.indirect
        self._bends = indirect.has_mirrors and indirect.has_refraction
        self._limited = {thing for thing in depsgraph.objects if self._is_limited(thing)}

    def _is_limited(self, thing: Object) -> bool:
        """Whether it is hidden from something, lit by itself, or catches shadows, and what it instances with it."""
        is_seen_by_all = self._is_camera_visible(thing) and all(
            getattr(thing, switch) for switch in (*OTHER_RAYS, "visible_volume_scatter")
        )
        if not is_seen_by_all or thing.is_shadow_catcher or self._lighting.concerns(thing):
            return True
        return self._is_held_out(thing) or self._is_hidden(thing)

    def _is_held_out(self, thing: Object) -> bool:
        """By its own switch, or its collection's."""
        if self._has_holdouts and thing.holdout_get(view_layer=self._depsgraph.view_layer_eval):
            return True
        return bool(thing.is_holdout)

    def _is_camera_visible(self, thing: Object) -> bool:
        if self._has_indirect_only and thing.indirect_only_get(view_layer=self._depsgraph.view_layer_eval):
            return False
        return bool(thing.visible_camera)

    def _is_hidden(self, thing: Object) -> bool:
        """In the viewport, and what it instances with it: a hidden kind of object hides no instances of another one."""
        viewport = self._viewport
        if viewport is None:
            return False
        if thing.type not in self._hidden_kinds:
            return not thing.visible_in_viewport_get(viewport)
        if viewport.local_view and not thing.local_view_get(viewport):
            return True
        return not thing.visible_get(view_layer=self._depsgraph.view_layer_eval)

    def placement_of(self, instance: DepsgraphObjectInstance) -> Placement | None:
        source, limit = instance.instance_object, None
        if source is not None:
            limit = self._limit(instance.parent) if self._limited else None
            if (source, limit) in self._plain:
                return self._plain[source, limit]
        thing, parent = instance.object, instance.parent if source is not None else None
        data = thing.data
        if data is None or not instance.show_self:  # an empty, or an instancer that hides itself
            return None
        # Addresses are compared within one pass over one depsgraph, in which they are stable; nothing is read there.
        # An instance, and the mesh of a curve, come as a copy of their object that lives for one step.
        owner = source or thing
        limit = self._limit(parent or thing)
        key = (owner.as_pointer(), data.as_pointer(), limit and limit.as_pointer())
        if key not in self._placements:
            self._placements[key] = self._new_placement(thing, owner, parent)
        if source is not None and not _may_hold_other_meshes(source):
            self._plain[source, limit] = self._placements[key]
        return self._placements[key]

    def hair_of(self, instance: DepsgraphObjectInstance) -> list[Placement]:
        """One per particle system of the instance's object."""
        if not self._hair or not instance.show_particles:
            return []
        source = instance.instance_object
        owner = source or instance.object
        if (modifiers := self._hair.get(owner.as_pointer())) is None or not isinstance(
            instance.object.data, bpy.types.Mesh
        ):
            return []
        parent = instance.parent if source is not None else None
        limit = self._limit(parent or instance.object)
        found = []
        for modifier in modifiers:
            key = (owner.as_pointer(), modifier, limit and limit.as_pointer())
            if key not in self._placements:
                placement = self._new_placement(owner, owner, parent)
                self._placements[key] = placement and replace(placement, hair=modifier)
            if (of_hair := self._placements[key]) is not None:
                found.append(of_hair)
        return found

    def _limit(self, shown_by: Object) -> Object | None:
        return shown_by if shown_by in self._limited else None

    def _new_placement(self, thing: Object, owner: Object, parent: Object | None) -> Placement | None:
        is_light = isinstance(thing.data, bpy.types.Light)
        has_shape = isinstance(thing.data, (bpy.types.Mesh, bpy.types.Volume, bpy.types.Curves, bpy.types.PointCloud))
        # Not asked of `thing`: Python's copy of an instance is that of its original, with the original's visibility.
        if owner.type in self._hidden_kinds or self._is_hidden(parent or thing):
            return None
        if is_baked_air(thing.data):  # the texture of the air is what it shows
            return None
        if not (has_shape or is_light):
            return None
        is_camera_visible = owner.visible_camera and self._is_camera_visible(parent or owner)
        casts_shadow, is_bounce_visible, is_mirror_visible, is_glass_visible = (
            getattr(owner, switch) and (parent is None or getattr(parent, switch)) for switch in OTHER_RAYS
        )
        seen_by = (
            is_camera_visible,
            casts_shadow,
            is_bounce_visible,
            is_mirror_visible,
            is_glass_visible and self._bends,
        )
        if has_shape and not any(seen_by):
            return None
        materials = materials_of(thing) if has_shape else ()
        asks = self.particles.is_asked_for(materials)
        asks_instancer = isinstance(thing.data, bpy.types.Mesh) and self.instancers.is_asked_for(materials)
        if has_shape:
            note_adaptive(owner, self._depsgraph, self._reports)
        if isinstance(thing.data, bpy.types.Mesh):
            note_terminator(owner, self._reports)
        return Placement(
            object_name=owner.name,
            data=thing.data if has_shape else None,
            materials=materials,
            source=owner,
            is_camera_visible=is_camera_visible,
            casts_shadow=casts_shadow,
            is_bounce_visible=is_bounce_visible,
            is_mirror_visible=is_mirror_visible,
            is_glass_visible=is_glass_visible,
            lights_media=owner.visible_volume_scatter and (parent is None or parent.visible_volume_scatter),
            is_held_out=has_shape and self._is_held_out(parent or owner),
            is_shadow_catcher=owner.is_shadow_catcher or (parent is not None and parent.is_shadow_catcher),
            lighting=self._lighting.read(owner, parent),
            depends_on={address_of(one, self._depsgraph) for one in (thing.data, owner, parent) if one is not None},
            is_instanced=parent is not None,
            color=tuple(owner.color),
            pass_index=owner.pass_index,
            own_random_number=random_number_of(owner.name),
            particle_rows=[] if asks else None,
            instancer_rows=[] if asks_instancer else None,
            instancer_numbers=self.instancers.numbers if asks_instancer else None,
        )

    def placements(self) -> list[Placement]:
        found = [placement for placement in self._placements.values() if placement is not None]
        for placement in found:
            if placement.particle_rows is not None:
                particles = self.particles.states(placement.particle_rows)
                if particles is not None:
                    placement.told["particles"] = particles
            if placement.instancer_rows is not None:
                placement.told["instancer_values"] = self.instancers.values(placement.instancer_rows, placement)
        return found


def _is_any(collection: LayerCollection, switch: str) -> bool:
    return getattr(collection, switch) or any(_is_any(child, switch) for child in collection.children)


def _hair_by_object(depsgraph: Depsgraph) -> dict[int, list[str]]:
    """By address of an evaluated object, the modifiers whose particles are drawn as strands."""
    shows = "show_render" if depsgraph.mode == "RENDER" else "show_viewport"
    found = {}
    for thing in depsgraph.objects:
        if thing.type != "MESH" or not thing.particle_systems:
            continue
        modifiers = [
            modifier.name
            for modifier in thing.modifiers
            if modifier.type == "PARTICLE_SYSTEM"
            and getattr(modifier, shows)
            and modifier.particle_system.settings.type == "HAIR"
            and modifier.particle_system.settings.render_type == "PATH"
        ]
        if modifiers:
            found[thing.as_pointer()] = modifiers
    return found


def _may_hold_other_meshes(source: Object) -> bool:
    """Whether instances of this object may show a mesh that is not its own, which geometry nodes and curves do."""
    return not isinstance(source.data, (bpy.types.Mesh, bpy.types.Light, bpy.types.Volume)) or any(
        modifier.type == "NODES" for modifier in source.modifiers
    )


def leave_out_flat_copies(meshes: list[Placement]) -> None:
    """What a scale of 0 has made flat: as in Cycles a mesh that is drawn once stays, its copies do not.

    Cycles draws copies through the inverse of their matrix, which there is not, and a lone mesh where it stands. Hiding
    instances of geometry nodes by a height of 0 relies on it.
    """
    drawn: Counter[tuple[object, ...]] = Counter()
    for placement in meshes:
        drawn[_geometry_of(placement)] += len(placement.matrices)
    for placement in meshes:
        if drawn[_geometry_of(placement)] == 1:
            continue
        axes = placement.world_from_object()[:, :3, :3]
        is_kept = (axes != 0.0).any(axis=1).all(axis=1)
        if not is_kept.all():
            placement.matrices = list(compress(placement.matrices, is_kept))
            placement.random_numbers = list(compress(placement.random_numbers, is_kept))
            placement.told = {name: values[is_kept] for name, values in placement.told.items()}


def _geometry_of(placement: Placement) -> tuple[object, ...]:
    """What Cycles keeps once: the mesh, or that of an object with materials of its own."""
    has_own = any(slot.link == "OBJECT" for slot in placement.source.material_slots)
    return placement.data.as_pointer(), placement.object_name if has_own else ""


def materials_of(thing: Object) -> tuple[Material | None, ...]:
    """One per slot, linked to the object or to its mesh; a mesh without a slot has one empty one."""
    slots = tuple(slot.material for slot in thing.material_slots)
    return slots or (None,)
