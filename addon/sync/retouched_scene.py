# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of which only materials, the world, or settings changed since it was read: its objects stay unread.

Of settings a read takes little, which is compared: most changes, and each click that selects, leave all as it was.
A material that changes is read alone where nothing but its own entry of the scene can differ: it has no medium, moves
no mesh, and asks meshes for what it did. From 4.1 on objects that show it have updates with it, as they have when their
own look changes: that is compared.
Differs: nothing of Blender's is kept from read to read but names: after an undo, evaluated objects lie elsewhere.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import bpy

from .instancer_values import InstancerReader
from .instances import OTHER_RAYS
from .light_linking import links_of
from .mesh_attributes import uv_maps_of
from .names import Name, name_of
from .particles import ParticleReader
from .reports import Reports
from .scene_state import scene_state
from .worlds import occlusion_reach_m, world_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from bpy.types import Depsgraph, DepsgraphUpdate, Object, ShaderNodeTree, SpaceView3D

    from tyndall.scene_description import Material

    from .instances import Placement
    from .materials import MaterialReader
    from .relit_scene import ReadScene
    from .worlds import ReadWorld

_SHOWING = (
    bpy.types.Mesh,
    bpy.types.Curve,
    bpy.types.MetaBall,
    bpy.types.Curves,
    bpy.types.PointCloud,
    bpy.types.Volume,
)


@dataclass
class Retouches:
    """What updates tell since the last read."""

    materials: set[Name] = field(default_factory=set)
    objects: set[Name] = field(default_factory=set)  #: That may only show a material, or be in a scene, that changed.
    has_world: bool = False
    has_scene: bool = False

    def clear(self) -> None:
        self.materials.clear()
        self.objects.clear()
        self.has_world = self.has_scene = False

    def hears(self, update: DepsgraphUpdate, depsgraph: Depsgraph) -> bool:
        """Whether it is of these."""
        thing = update.id
        if isinstance(thing, bpy.types.Scene):
            is_own = bool(thing.original == depsgraph.scene)
            self.has_scene |= is_own
            return is_own
        if update.is_updated_transform or update.is_updated_geometry:
            return False
        if isinstance(thing, bpy.types.ShaderNodeTree):
            return self._hears_tree(thing.original)
        if isinstance(thing, bpy.types.Material):
            self.materials.add(name_of(thing))
            return True
        if isinstance(thing, bpy.types.World):
            self.has_world = True
            return True
        if isinstance(thing, bpy.types.Object):
            self.objects.add(name_of(thing))
        return isinstance(thing, (bpy.types.Object, *_SHOWING)) and update.is_updated_shading

    def _hears_tree(self, tree: ShaderNodeTree) -> bool:
        """One that a material or a world has; what shows a group of nodes has updates of its own beside it."""
        if not tree.is_embedded_data:
            return True
        owners = {name_of(material) for material in bpy.data.materials if material.node_tree == tree}
        self.materials |= owners
        is_world = any(world.node_tree == tree for world in bpy.data.worlds)
        self.has_world |= is_world
        return is_world or bool(owners)


@dataclass(frozen=True, kw_only=True, eq=False)
class Retouchable:
    """What a retouched scene is compared with."""

    materials: Mapping[Name, tuple[int, Reports]]  #: Where they are in the description, and what was said of each.
    looks: Mapping[Name, tuple[object, ...]]
    of_world: Reports
    occlusion_reach_m: float  #: Which the world has, and materials read.
    frame: float
    state: tuple[object, ...]

    def serves(self, retouches: Retouches, depsgraph: Depsgraph, viewport: SpaceView3D | None) -> bool:
        """Whether objects look as they did, and what changed is known."""
        if retouches.objects and not (retouches.materials or retouches.has_scene):
            return False  # then it is these that changed
        return (
            self.frame == depsgraph.scene_eval.frame_current_final
            and self.occlusion_reach_m == occlusion_reach_m(depsgraph.scene_eval)
            and retouches.materials <= self.materials.keys()
            and not (retouches.has_scene and self.state != scene_state(depsgraph, viewport))
            and self._look_alike(retouches.objects, depsgraph)
        )

    def _look_alike(self, names: set[Name], depsgraph: Depsgraph) -> bool:
        """What has no look was not drawn, and would have other updates if it were now."""
        if not names:
            return True
        # At once: to look one up by its name goes through all objects of the file.
        found = {name_of(thing): thing for thing in depsgraph.objects}
        drawn = names & self.looks.keys()
        return all(self.looks[name] == _look_now(name, found, depsgraph) for name in drawn)


def _look_now(name: Name, found: Mapping[Name, Object], depsgraph: Depsgraph) -> tuple[object, ...] | None:
    thing = found.get(name)
    if thing is None and (original := bpy.data.objects.get(name)) is not None:  # one that is only instanced
        thing = original.evaluated_get(depsgraph)
    return None if thing is None else look_of(thing)


def retouchable(
    materials: MaterialReader,
    placements: Iterable[Placement],
    of_world: Reports,
    depsgraph: Depsgraph,
    viewport: SpaceView3D | None,
) -> Retouchable | None:
    """Of a whole read; None: what materials ask of objects would have to be compared, too."""
    shown = list(placements)
    if materials.asks_properties or any(placement.told for placement in shown):
        return None
    counts, scene = Counter(materials.names), depsgraph.scene_eval
    looking = {name_of(thing): thing for thing in depsgraph.objects}
    looking |= {name_of(one.source): one.source for one in shown}  # what is only instanced is in none
    return Retouchable(
        materials={
            name: (index, materials.notes[index])
            for index, name in enumerate(materials.names)
            if name is not None and counts[name] == 1 and not materials.has_medium(index)
        },
        looks={name: look_of(thing) for name, thing in looking.items()},
        of_world=of_world,
        occlusion_reach_m=occlusion_reach_m(scene),
        frame=scene.frame_current_final,
        state=scene_state(depsgraph, viewport),
    )


def look_of(thing: Object) -> tuple[object, ...]:
    """All that a placement takes from an evaluated object but its place and its geometry."""
    return (
        thing.visible_camera,
        *(getattr(thing, switch) for switch in OTHER_RAYS),
        thing.visible_volume_scatter,
        thing.is_holdout,
        thing.is_shadow_catcher,
        tuple(thing.color),
        thing.pass_index,
        thing.lightgroup,
        links_of(thing),
        thing.hide_viewport,
        thing.hide_render,
    )


def retouched(
    last: ReadScene,
    retouches: Retouches,
    depsgraph: Depsgraph,
    viewport: SpaceView3D | None,
    new_reader: Callable[[], MaterialReader],
    read_world: Callable[[Reports], ReadWorld],
) -> ReadScene | None:
    """With materials and the world as they are now; None where that is not all that there is to change."""
    known = last.retouchable
    if known is None or not known.serves(retouches, depsgraph, viewport):
        return None
    description, sky_suns = last.description, last.sky_suns
    materials = list(description.materials)
    for name in retouches.materials:
        index, notes = known.materials[name]
        material, reader = bpy.data.materials[name].evaluated_get(depsgraph), new_reader()
        reader.index(material)
        is_alone = _is_alone(reader, last) and not (reader.has_medium(0) or _asks_instances(material, depsgraph))
        says_the_same = reader.notes[0].lines() == notes.lines()
        if not (is_alone and says_the_same and _may_replace(materials[index], reader.materials[0])):
            return None
        materials[index] = reader.materials[0]
    description = replace(description, materials=tuple(materials))
    if retouches.has_world:
        reports, world = Reports(), world_of(depsgraph)
        if world is not None and world.original.tyndall.takes_sun:
            return None  # an object is in its place
        found = read_world(reports)
        has_medium = found.medium is not None or bool(found.fields) or description.world.medium >= 0
        if has_medium or reports.lines() != known.of_world.lines():
            return None
        lamps = description.lights[: len(description.lights) - len(sky_suns)]
        sky_suns = found.sky_suns()
        description = replace(description, world=found.world, lights=(*lamps, *sky_suns))
    return replace(last, description=description, sky_suns=sky_suns)


def _is_alone(reader: MaterialReader, last: ReadScene) -> bool:
    """Whether its only material asks nothing of objects, and of the camera what others did."""
    sees_the_same = reader.asked_camera is None or reader.asked_camera == last.camera
    return sees_the_same and not reader.asks_properties


def _may_replace(before: Material, after: Material) -> bool:
    moves = before.displacement is not None or after.displacement is not None
    return not moves and uv_maps_of(before) == uv_maps_of(after)


def _asks_instances(material: bpy.types.Material, depsgraph: Depsgraph) -> bool:
    """What is read of each instance while they are gone through."""
    readers = ParticleReader(depsgraph), InstancerReader(depsgraph, Reports())
    return any(reader.is_asked_for([material]) for reader in readers)
