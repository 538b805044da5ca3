# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole depsgraph as a scene description.

One Blender unit is one metre, always. What did not change is not read again: a live depsgraph says which geometry it
updated; one that is built anew for every frame of an animation cannot, and meshes are told apart by their content.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from tyndall.emitter_programs import EmitterPictures
from tyndall.scene_description import Instances, Mesh, SceneDescription

from .displaced_meshes import DisplacedMeshes
from .field_media import FieldVolumes, with_fields
from .images import ImageReader, images_of
from .instances import Placement, leave_out_flat_copies, read_placements, shown_kinds
from .light_linking import LinkedMedia, make_dark_media
from .light_masks import MaskReader
from .lights import lights_of
from .materials import MaterialReader, note_missing_attributes, scene_materials
from .mesh_attributes import asked_of_meshes
from .meshes import passing_mesh, read_mesh
from .names import address_of, name_of
from .object_lighting import light_groups, report_left_out
from .occluder_edits import OccluderEditReader
from .placed_objects import placed
from .relit_scene import (
    MovedMesh,
    ReadScene,
    is_camera,
    is_light,
    light_names,
    links_of_lights,
    moved_mesh,
)
from .reports import Reports
from .retouched_scene import Retouches, retouchable, retouched
from .strands import StrandReader, is_strands
from .texture_budget import budget_bytes
from .volume_nodes import note_hidden_medium
from .volume_sources import is_volume
from .volumes import VolumeReader
from .voxel_objects import VoxelReader, without_and_with_voxels
from .world_fields import world_fields
from .world_suns import WorldSuns
from .worlds import ReadWorld, WorldBakes, read_world, world_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from bpy.types import Depsgraph, Object, SpaceView3D, ViewLayer
    from mathutils import Matrix

    from .names import Name


class SceneReader:
    """Reads frames one after another; keeps meshes and images that the next frame may share."""

    def __init__(self) -> None:
        self._images = ImageReader()
        self._masks = MaskReader()
        self._volumes = VolumeReader()
        self._fields = FieldVolumes()
        self._voxels = VoxelReader()
        self._strands = StrandReader()
        self._suns = WorldSuns()
        self._bakes = WorldBakes()
        self._pictures = EmitterPictures()
        self._displaced = DisplacedMeshes()
        self._meshes: dict[str, Mesh] = {}
        # By address of the evaluated mesh, while it lives, and by what its materials ask of it.
        self._live: dict[tuple[int, frozenset[str]], tuple[Mesh | None, set[int]]] = {}
        self._live_depsgraph = 0
        self._stale: set[int] = set()
        self._last: ReadScene | None = None  # of the live depsgraph, unless more than this was updated since:
        self._moved: dict[Name, MovedMesh] = {}  # the places of objects with meshes
        self._retouches = Retouches()  # materials and the world
        self._are_lights_outdated = False

    @property
    def read_count(self) -> int:
        """Of what takes long, meshes, moved ones and hairs: how many were read that stay if a read is interrupted."""
        return len(self._live) + self._displaced.count + self._strands.hair_count

    def begin_moments(self, *, is_live: bool) -> None:
        """Before the first read of a render; ``is_live``: of the same depsgraph, those of a shutter follow."""
        self._images.hold_frames(is_held=is_live)
        self._live_depsgraph, self._last = 0, None  # this one may lie where another did
        self._moved.clear()
        self._retouches.clear()

    def note_updates(self, depsgraph: Depsgraph) -> None:
        """Call from ``view_update`` and handlers: remembers which geometry changed until the next read."""
        has_updates = False
        for update in depsgraph.updates:  # looked through once: a length, or a list, looks at all of the scene twice
            has_updates = True
            if self._last is None or isinstance(update.id, bpy.types.Action) or is_camera(update.id):
                pass  # what they move has updates of its own
            elif is_light(update.id):
                self._are_lights_outdated = True
            elif (moved := moved_mesh(update, depsgraph)) is not None:
                self._moved[moved.name] = moved
            elif not self._retouches.hears(update, depsgraph):
                self._last = None
            if update.is_updated_geometry:
                self._stale.add(address_of(update.id, depsgraph))
        if not has_updates:
            self._last = None

    def read(
        self,
        depsgraph: Depsgraph,
        reports: Reports,
        poll: Callable[[], None],
        *,
        is_live: bool = False,
        viewport: SpaceView3D | None = None,
        is_lit: bool = True,
        is_preview: bool = False,
    ) -> SceneDescription:
        """Everything that renders. ``poll`` is called every few milliseconds and may raise to stop.

        ``is_live`` promises that ``note_updates`` heard of every update of this depsgraph since the last read of it.
        ``viewport`` leaves out what it hides: in local view, by collection, by kind of object.
        Without ``is_lit`` surfaces give no light, and the media all of theirs. ``is_preview``: with mirrors and glass
        that bends, whatever it asks.
        """
        if is_live and self._last is not None and self._last.serves(depsgraph, viewport, is_lit=is_lit):
            followed = self._follow(self._last, depsgraph, viewport, reports, poll)
            if followed is not None:
                return followed
        self._last = None
        self._moved.clear()
        self._retouches.clear()
        self._forget_stale(depsgraph, is_live=is_live)
        self._images.start_frame(budget := budget_bytes(depsgraph.scene_eval))
        self._images.read_ahead(lambda: images_of(depsgraph), budget)
        for started in (self._masks, self._displaced):
            started.start_frame()
        poll()
        layer = depsgraph.view_layer_eval
        found_placements = read_placements(depsgraph, reports, poll, viewport)
        volumes, strands, placements = _sorted_by_kind(found_placements, layer)
        is_viewport = depsgraph.mode == "VIEWPORT"  # which shows the picture alone
        materials = scene_materials(depsgraph, self._images, reports, is_lit=is_lit, is_preview=is_preview)
        meshes, voxels = without_and_with_voxels([placement for placement in placements if placement.data is not None])
        voxel_objects = self._voxels.read(voxels, materials, reports, poll)
        strand_objects = self._strands.read(strands, depsgraph, materials, reports, poll)
        media = LinkedMedia(materials)
        lone: dict[Name, int] = {}
        found_meshes = self._instances(meshes, (materials, media), reports, poll, lone, is_viewport=is_viewport)
        instances = tuple(group for _, group in found_meshes)
        varying = with_fields(found_meshes, materials)
        for placement, _ in varying:
            lone.pop(name_of(placement.source), None)  # its grids move with it
        light_places = {one.object_name: one.matrices[0] for one in placements if one.data is None}
        of_world = Reports()
        found = self._read_world(depsgraph, light_places, of_world)
        of_air = world_fields(found.world.name, found.fields, found_placements, depsgraph, materials, of_world)
        reports.include(of_world)
        groups = light_groups(layer)
        report_left_out(layer, reports)
        poll()
        drawn = frozenset(placement.object_name for placement in (*meshes, *voxels, *strands))
        sky_suns = found.sky_suns()
        world = replace(found.world, medium=materials.add_medium(found.medium))
        of_fields = self._fields.read(
            [*(of_mesh for _, of_mesh in varying), *of_air], reports, poll, is_viewport=is_viewport
        )
        read_volumes = self._volumes.read(volumes, materials, self._images, reports, poll)
        of_all_but_lights = Reports()
        of_all_but_lights.include(reports)
        edits = OccluderEditReader(depsgraph, drawn, self._images, self._masks, reports, poll)
        make_dark_media(placements, volumes, media, reports)
        description = SceneDescription(
            instances=instances,
            voxel_objects=voxel_objects,
            strand_objects=strand_objects,
            lights=(*lights_of(placements, edits, media, (self._images, self._pictures), reports), *sky_suns),
            world=world,
            light_groups=groups,
            materials=tuple(materials.materials),
            volumes=(*read_volumes, *of_fields),
            media=tuple(materials.media),
            reports=reports.lines(),
        )
        for kept in (self._images, self._masks, self._displaced):
            kept.end_frame()
        self._meshes = {group.mesh.key: group.mesh for group in instances}
        self._are_lights_outdated = False
        if is_live:
            self._last = ReadScene(
                description=description,
                reports=of_all_but_lights,
                depsgraph=depsgraph.as_pointer(),
                shown_kinds=shown_kinds(viewport),
                is_lit=is_lit,
                drawn=drawn,
                lights=light_names(placements),
                media=media,
                links=links_of_lights(placements),
                sky_suns=sky_suns,
                lone={} if of_air else lone,  # what moves may leave the air's box
                camera=materials.asked_camera,
                frame=None
                if not any("particles" in one.told for one in found_placements)
                else depsgraph.scene_eval.frame_current_final,
                has_instanced_lights=any(one.data is None and one.is_instanced for one in placements),
                retouchable=retouchable(materials, found_placements, of_world, depsgraph, viewport),
            )
        return description

    def _read_world(self, depsgraph: Depsgraph, light_places: Mapping[str, Matrix], reports: Reports) -> ReadWorld:
        """Without the suns that are lights of their own."""
        world = world_of(depsgraph)
        found = read_world(world, reports, self._images, self._bakes)
        if world is None:
            return found
        found = replace(found, world=replace(found.world, light_group=world.lightgroup))
        return self._suns.take_out(world.original, found, light_places, reports)

    def _follow(
        self,
        last: ReadScene,
        depsgraph: Depsgraph,
        viewport: SpaceView3D | None,
        reports: Reports,
        poll: Callable[[], None],
    ) -> SceneDescription | None:
        """What was retouched, what moved, and lights; None where there is more."""
        has_less = (bool(self._moved) or self._retouches != Retouches()) and not self._are_lights_outdated
        lights = [] if has_less else last.light_objects()
        if not (has_less or last.serves_lights(lights)):
            return None
        found = self._retouched(last, depsgraph, viewport)
        found = found and found.moved(self._moved)
        if found is None:
            return None
        self._moved.clear()
        self._retouches.clear()
        self._last = found
        if has_less:
            return found.description
        originals = [light for light in lights if light is not None]  # all, if they serve
        return self._read_lights(found, depsgraph, originals, reports, poll)

    def _retouched(self, last: ReadScene, depsgraph: Depsgraph, viewport: SpaceView3D | None) -> ReadScene | None:
        """The last read with its materials, and its world, as they are now."""
        if self._retouches == Retouches():
            return last
        return retouched(
            last,
            self._retouches,
            depsgraph,
            viewport,
            lambda: scene_materials(depsgraph, self._images, Reports(), is_lit=last.is_lit),
            lambda reports: self._read_world(depsgraph, {}, reports),
        )

    def _read_lights(
        self,
        last: ReadScene,
        depsgraph: Depsgraph,
        originals: list[Object],
        reports: Reports,
        poll: Callable[[], None],
    ) -> SceneDescription:
        """The scene of the last read under its lights as they are now; their images join those of the last read."""
        reports.include(last.reports)
        edits = OccluderEditReader(depsgraph, last.drawn, self._images, self._masks, reports, poll)
        lights = lights_of(
            last.light_placements(depsgraph, originals), edits, last.media, (self._images, self._pictures), reports
        )
        description = replace(last.description, lights=(*lights, *last.sky_suns), reports=reports.lines())
        self._last, self._are_lights_outdated = replace(last, description=description), False
        return description

    def _forget_stale(self, depsgraph: Depsgraph, *, is_live: bool) -> None:
        still_lives = is_live and depsgraph.as_pointer() == self._live_depsgraph
        self._volumes.forget_stale(self._stale if still_lives else None)
        self._strands.forget_stale(self._stale if still_lives else None)
        if not still_lives:
            self._live.clear()
        else:
            self._live = {
                address: (mesh, depends_on)
                for address, (mesh, depends_on) in self._live.items()
                if not depends_on & self._stale
            }
        self._live_depsgraph = depsgraph.as_pointer() if is_live else 0
        self._stale.clear()

    def _instances(
        self,
        placements: list[Placement],
        materials_and_media: tuple[MaterialReader, LinkedMedia],
        reports: Reports,
        poll: Callable[[], None],
        lone: dict[Name, int],
        *,
        is_viewport: bool,
    ) -> list[tuple[Placement, Instances]]:
        """``lone`` becomes where in them objects are that are drawn once, as themselves."""
        materials, media = materials_and_media
        groups: list[tuple[Placement, Instances]] = []
        met: set[Name] = set()
        leave_out_flat_copies(placements)
        seen: dict[tuple[int, frozenset[str]], tuple[Mesh | None, set[int]]] = {}
        for placement in placements:
            poll()
            slots = [materials.materials[index] for index in materials.indices(placement)]
            asked = asked_of_meshes(slots, placement.data)
            key = placement.data.as_pointer(), asked
            if key not in seen:
                seen[key] = self._live.get(key) or (
                    self._read_mesh(placement, reports, poll, asked, is_viewport=is_viewport),
                    set(),
                )
                self._live[key] = seen[key]  # at once: a viewport reads in slices, and the next one goes on from here
            mesh, depends_on = seen[key]
            depends_on |= placement.depends_on
            if mesh is not None:
                name = name_of(placement.source)
                if name in met or placement.is_instanced or len(placement.matrices) > 1:
                    lone.pop(name, None)
                else:
                    lone[name] = len(groups)
                met.add(name)
                poll()
                drawn = self._displaced.moved(mesh, slots, placement, reports)
                group = _group(placement, drawn, materials, media)
                groups.append((placement, group))
                note_missing_attributes(placement.object_name, mesh, group.materials, materials, reports)
                note_hidden_medium(placement, materials, reports)
        self._live = seen
        return groups

    def _read_mesh(
        self,
        placement: Placement,
        reports: Reports,
        poll: Callable[[], None],
        asked: frozenset[str],
        *,
        is_viewport: bool,
    ) -> Mesh | None:
        source = placement.source
        is_subdivided_late = is_viewport and source.modifiers and source.modifiers[-1].type == "SUBSURF"
        # A window may leave the last subdivision to its graphics card: `data` is the coarse mesh, `to_mesh` is not.
        # While it is edited, `data` has counts, but no attributes.
        is_complete = not (is_subdivided_late or placement.data.is_editmode)
        with passing_mesh(source, placement.data, is_complete=is_complete) as mesh:
            # Of a mesh that a slice of a viewport's reading ends in nothing would stay.
            return read_mesh(mesh, reports, self._meshes, (lambda: None) if is_viewport else poll, asked)


def _sorted_by_kind(found: list[Placement], layer: ViewLayer) -> tuple[list[Placement], ...]:
    """Volumes, strands and all others, of what the view layer draws."""
    volumes, strands, others = [], [], []
    for placement in found:
        if is_volume(placement):
            if layer.use_volumes:
                volumes.append(placement)
        elif is_strands(placement):
            if layer.use_strand if placement.hair is not None else layer.use_solid:
                strands.append(placement)
        elif layer.use_solid or placement.data is None:
            others.append(placement)
    return volumes, strands, others


def _group(placement: Placement, mesh: Mesh, materials: MaterialReader, media: LinkedMedia) -> Instances:
    receiver_set = 0 if placement.lighting is None else placement.lighting.receiver_set
    return Instances(
        mesh=mesh,
        materials=tuple(media.material_in(index, receiver_set) for index in materials.indices(placement)),
        **placed(placement),
        **placement.told,
    )
