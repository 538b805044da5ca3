# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of which only lights or cameras changed since it was read, or a few meshes moved: thousands stay unread.

Differs: nothing of Blender's is kept from read to read but names: after an undo, evaluated objects lie elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import bpy
import numpy as np

from .instances import Placement, may_stand_alone, shown_kinds
from .light_linking import LinkedMedia, links_of
from .names import name_of
from .object_lighting import LightingReader
from .random_numbers import random_number_of
from .seen_camera import seen_camera

if TYPE_CHECKING:
    import numpy as np
    from bpy.types import ID, Depsgraph, DepsgraphUpdate, Object, SpaceView3D
    from numpy.typing import NDArray

    from tyndall.scene_description import Light, SceneDescription

    from .names import Name
    from .reports import Reports
    from .retouched_scene import Retouchable
    from .seen_camera import SeenCamera


@dataclass(frozen=True, kw_only=True, eq=False)
class MovedMesh:
    """What an update tells of an object; held until the next read, so nothing of Blender's is in it."""

    name: Name
    world_from_object: NDArray[np.float64]  #: (1, 4, 4)


@dataclass(frozen=True, kw_only=True)
class ReadScene:
    """The last read of a live depsgraph."""

    description: SceneDescription
    reports: Reports  #: About all but its lights.
    depsgraph: int  #: By address.
    shown_kinds: tuple[object, ...]  #: What the viewport was set to show.
    is_lit: bool
    drawn: frozenset[str]  #: Names of the objects with a mesh.
    lights: tuple[Name, ...]  #: Of their objects.
    sky_suns: tuple[Light, ...]  #: Of the world, which no object has.
    has_instanced_lights: bool
    media: LinkedMedia
    links: tuple[tuple[str, str], ...]  #: Of the lights: another one may change what objects are to it.
    #: Which of the description's instances is an object with a mesh that is drawn once, as itself.
    lone: dict[Name, int]
    camera: SeenCamera | None  #: That materials were told of; None: none asks for it.
    frame: float | None  #: Of particles, whose age is told, but not updated; None: no material asks for it.
    retouchable: Retouchable | None  #: None: materials and the world are not read alone.

    def serves(self, depsgraph: Depsgraph, viewport: SpaceView3D | None, *, is_lit: bool) -> bool:
        """Whether a read of this would differ in lights alone, if nothing but lights was updated."""
        return (
            not self.has_instanced_lights
            and self.depsgraph == depsgraph.as_pointer()
            and self.shown_kinds == shown_kinds(viewport)
            and self.is_lit == is_lit
            and (self.camera is None or self.camera == seen_camera(depsgraph))
            and self.frame in {None, depsgraph.scene_eval.frame_current_final}
        )

    def serves_lights(self, originals: list[Object | None]) -> bool:
        """Whether its lights may be read alone: ``originals`` are their objects now."""
        return self.links == tuple(links_of(light) if light is not None else None for light in originals)

    def light_objects(self) -> list[Object | None]:
        """Original ones; None: there is none of that name. Looking one up walks through all objects of the file."""
        return [bpy.data.objects.get(light) for light in self.lights]

    def moved(self, to: dict[Name, MovedMesh]) -> ReadScene | None:
        """With these objects there; None where that may not be all that there is to change."""
        if not to:
            return self
        if not to.keys() <= self.lone.keys():
            return None
        instances = list(self.description.instances)
        for name, moved in to.items():
            before = instances[self.lone[name]]
            instances[self.lone[name]] = replace(before, world_from_object=moved.world_from_object)
        return replace(self, description=replace(self.description, instances=tuple(instances)))

    def light_placements(self, depsgraph: Depsgraph, originals: list[Object]) -> list[Placement]:
        """Where its lights are now."""
        placements = []
        is_linked = any(collection for collections in self.links for collection in collections)
        lighting = LightingReader.of(depsgraph) if is_linked else LightingReader.of_groups(depsgraph)
        for original in originals:
            source = original.evaluated_get(depsgraph)
            placements.append(
                Placement(
                    object_name=original.name,
                    data=None,
                    materials=(),
                    source=source,
                    is_camera_visible=source.visible_camera,
                    casts_shadow=source.visible_shadow,
                    is_shadow_catcher=source.is_shadow_catcher,
                    lighting=lighting.read(source, None),
                    color=tuple(source.color),
                    pass_index=source.pass_index,
                    matrices=[source.matrix_world.copy()],
                    random_numbers=[random_number_of(original.name)],
                )
            )
        return placements


def links_of_lights(placements: list[Placement]) -> tuple[tuple[str, str], ...]:
    """In the order of light_names()."""
    return tuple(links_of(placement.source) for placement in placements if placement.data is None)


def is_light(thing: ID) -> bool:
    """The object of a light, its data, or its nodes, used or not. What depends on it has updates of its own."""
    if isinstance(thing, bpy.types.ShaderNodeTree):  # one in a light, a material or a world does not tell its owner
        return any(light.node_tree == thing.original for light in bpy.data.lights)
    return isinstance(thing, bpy.types.Light) or (isinstance(thing, bpy.types.Object) and thing.type == "LIGHT")


def is_camera(thing: ID) -> bool:
    """The object of a camera, or its data: nothing is drawn for it. What depends on it has updates of its own."""
    is_object = isinstance(thing, bpy.types.Object) and thing.type == "CAMERA" and thing.instance_type == "NONE"
    return is_object or isinstance(thing, bpy.types.Camera)


def moved_mesh(update: DepsgraphUpdate, depsgraph: Depsgraph) -> MovedMesh | None:
    """An object of which nothing but its place was updated, and where it is now.

    What else hangs on it, as materials in its coordinates do, has updates of its own; and so has its look, animated.
    """
    thing = update.id
    if not (isinstance(thing, bpy.types.Object) and thing.type == "MESH" and update.is_updated_transform):
        return None
    if update.is_updated_geometry or update.is_updated_shading:
        return None
    if not may_stand_alone(thing, depsgraph):
        return None
    return MovedMesh(name=name_of(thing), world_from_object=np.array(thing.matrix_world, np.float64)[None])


def light_names(placements: list[Placement]) -> tuple[Name, ...]:
    """As ``bpy.data.objects`` takes them."""
    return tuple(name_of(placement.source) for placement in placements if placement.data is None)
