# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene description in native memory: each mesh and image is sent once, by its key; the rest is small."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tyndall.closed_meshes import open_edge_count

from . import _native
from .fingerprints import fingerprint
from .instance_arrays import colors_of, instancer_values_of, names_of, particles_of, randoms_of, repeated
from .light_textures import build_light_textures
from .memory_estimate import require_room, scene_parts
from .moved_instances import moved_groups
from .native_light_links import group_index, lighting_arrays
from .native_lights import build_light
from .native_materials import build_material
from .native_textures import TextureFiles, build_texture
from .native_volumes import build_volumes
from .native_voxels import build_shapes, relative_matrices, shows_to
from .native_worlds import build_world
from .scene_description import Instances, Material, Medium, PlacedObjects, SceneDescription, TextureUse
from .scene_origin import free_places, origin_of, places_of
from .usable_parts import built

#: What Blender shows where a mesh has no material.
_DEFAULT_MATERIAL = Material(name="(no material)")
_FEW_PLACES = 4096


@dataclass(kw_only=True)
class KeptGeometry:
    """A scene whose geometry, materials and media serve as long as only lights and world change."""

    scene: _native.Scene
    origin_in_world: NDArray[np.float64]
    object_names: list[str]  #: As native instances point to them.
    aov_programs: dict[str, dict[int, int]]  #: By name, of native materials: those that emit their values.
    reports: list[str]  #: About its parts.
    places: NDArray[np.float64]  #: (n, 3), in the world: of all instances, then of what else has one.
    firsts: NDArray[np.int64]  #: Of each group: the number of its first instance; then that of all.
    free_places: int = 0  #: So many of them may go anywhere: the origin stays.
    moved: frozenset[int] = frozenset()  #: Numbers of the instances that did since that was found.
    fingerprint: bytes = b""  #: Empty: not found yet, but ``description`` is there.
    #: Of sessions that follow what moves, where all of it is in the scene.
    description: SceneDescription | None = None

    def serves(self, description: SceneDescription) -> bool:
        """Whether nothing but lights and the world's light differ. Looks at all of both."""
        if not self.fingerprint and self.description is not None:
            self.fingerprint = geometry_fingerprint(self.description)
        return self.fingerprint == geometry_fingerprint(description)


def geometry_fingerprint(description: SceneDescription) -> bytes:
    """Equal where nothing but lights and the world's light differ."""
    has_places = description.instances or description.voxel_objects or description.strand_objects
    places = () if has_places else tuple(light.world_from_light for light in description.lights)
    parts = (
        description.instances,
        description.voxel_objects,
        description.strand_objects,
        description.materials,
        description.media,
        description.volumes,
    )
    return fingerprint((parts, description.world.medium, description.light_groups, places))


@dataclass
class NativeParts:
    """Native objects that outlive a frame, by key, and how many of them the last update sent or found in place."""

    meshes: dict[str, _native.TriangleMesh] = field(default_factory=dict)
    open_edges: dict[str, int] = field(default_factory=dict)  #: Of meshes that bound a medium.
    grids: dict[str, _native.DensityGrid] = field(default_factory=dict)
    voxels: dict[int, _native.VoxelShape] = field(default_factory=dict)
    strands: dict[str, _native.Strands] = field(default_factory=dict)
    textures: dict[tuple[str, int, int], _native.Texture] = field(default_factory=dict)
    light_textures: dict[tuple[str, int, int], _native.FilteredTexture] = field(default_factory=dict)
    texture_files: TextureFiles = field(default_factory=TextureFiles)
    world: tuple[tuple[bytes, int], _native.World] | None = None
    geometry: KeptGeometry | None = None  #: Of the last scene.
    follows_moves: bool = False  #: At the cost of keeping the description.
    keeps_trees: bool = False  #: Of what did not move; see ``Session``.
    builds_hastily: bool = False  #: See ``Session``.
    counts: dict[str, float] = field(default_factory=dict)

    def begin_update(self) -> None:
        """Set the counts of this update to 0."""
        self.counts = {
            "meshes sent": 0,
            "meshes reused": 0,
            "images sent": 0,
            "images reused": 0,
            "grids sent": 0,
            "grids reused": 0,
            "voxels sent": 0,
            "voxels reused": 0,
            "strands sent": 0,
            "strands reused": 0,
            "scene rebuilt": 0,
            "scene relit": 0,
            "scene moved": 0,
        }

    def count_geometry_as_reused(self) -> None:
        """Meshes and materials are in place."""
        self.counts["meshes reused"] = len(self.meshes)
        self.counts["images reused"] = len(self.textures)
        self.counts["grids reused"] = len(self.grids)
        self.counts["voxels reused"] = len(self.voxels)
        self.counts["strands reused"] = len(self.strands)

    def count_all_as_reused(self) -> None:
        """Nothing has changed: everything is in place."""
        self.count_geometry_as_reused()
        self.counts["images reused"] += len(self.light_textures)


@dataclass(frozen=True, kw_only=True)
class BuiltScene:
    """A native scene, where it lies, and what had to be left out."""

    scene: _native.Scene
    origin_in_world: NDArray[np.float64]  #: (3,): what native positions are relative to.
    light_names: list[str]  #: Of the native lights, in their order.
    aov_programs: dict[str, dict[int, int]]
    reports: list[str]


def update_geometry(description: SceneDescription, parts: NativeParts, progress: _native.Progress) -> KeptGeometry:
    """All but the lights; new meshes and images go into ``parts``, those that are gone leave it. Raises Cancelled.

    Where nothing of it changed, that of the last scene is kept.
    """
    kept = parts.geometry
    if kept is not None:
        changed = None if kept.description is None else moved_groups(kept.description, description)
        moved = _moved(kept, description, changed, parts, progress) if changed else None
        if moved is not None:
            parts.counts["scene moved"] = 1
        elif changed == [] or (not changed and kept.serves(description)):
            moved = kept
        if moved is not None:
            if moved.description is not None:
                moved.description = description
            parts.geometry = moved
            parts.count_geometry_as_reused()
            return moved
    parts.geometry = _build_geometry(description, parts, progress)
    parts.counts["scene rebuilt"] = 1
    return parts.geometry


def light_scene(description: SceneDescription, kept: KeptGeometry, parts: NativeParts) -> BuiltScene:
    """The geometry under the description's lights."""
    if not (parts.counts["scene rebuilt"] or parts.counts["scene moved"]):
        parts.counts["scene relit"] = 1
    reports = [*description.reports, *kept.reports]
    light_textures = build_light_textures(description.lights, parts, reports)
    origin = kept.origin_in_world
    lights = built(
        description.lights,
        lambda light: build_light(
            light,
            origin,
            kept.object_names,
            light_textures.get(id(light)),
            group_index(light.light_group, description.light_groups),
            reports,
        ),
        "Light",
        reports,
    )
    named = [
        (source.name, light) for source, light in zip(description.lights, lights, strict=True) if light is not None
    ]
    world = build_world(description, parts, reports)
    return BuiltScene(
        scene=kept.scene.relit([light for _, light in named], world),
        origin_in_world=origin,
        light_names=[name for name, _ in named],
        aov_programs=kept.aov_programs,
        reports=reports,
    )


def _moved(
    kept: KeptGeometry,
    description: SceneDescription,
    changed: list[int],
    parts: NativeParts,
    progress: _native.Progress,
) -> KeptGeometry | None:
    """With some groups elsewhere; None where that takes a new scene."""
    firsts = kept.firsts
    if kept.scene.instance_count != firsts[-1]:
        return None  # some were left out: the native ones have other numbers
    groups = [description.instances[index] for index in changed]
    indices = np.concatenate([np.arange(firsts[index], firsts[index + 1], dtype=np.uint32) for index in changed])
    places = kept.places.copy()
    places[indices] = np.concatenate([group.world_from_object[:, :3, 3] for group in groups])
    free, indices_moved = kept.free_places, kept.moved.union(indices.tolist())
    if len(indices_moved) > free:
        if not np.array_equal(origin_of(places), kept.origin_in_world):
            return None
        free, indices_moved = _free_places(places) if free else 0, frozenset()
    matrices = relative_matrices([group.world_from_object for group in groups], kept.origin_in_world)
    try:
        scene = kept.scene.moved(indices, matrices, parts.keeps_trees, progress)
    except _native.InvalidInput:  # a new scene reports what it leaves out
        return None
    return replace(kept, scene=scene, places=places, free_places=free, moved=indices_moved, fingerprint=b"")


def _free_places(places: NDArray[np.float64]) -> int:
    """None of a few: their origin is found as soon."""
    return free_places(places) if len(places) > _FEW_PLACES else 0


def _build_geometry(description: SceneDescription, parts: NativeParts, progress: _native.Progress) -> KeptGeometry:
    require_room(scene_parts(description, {*parts.meshes, *parts.strands}))
    reports: list[str] = []
    groups = _build_meshes(description.instances, parts, reports, progress)
    _report_open_media(groups, description.materials, parts, reports)
    places = places_of(groups, description)
    origin = origin_of(places)
    with_aovs, aov_programs = _with_aov_programs(description.materials)
    materials = _build_materials(with_aovs, parts, reports)
    default_material = len(materials)
    materials.append(build_material(_DEFAULT_MATERIAL, []))
    slots = [group.materials or (default_material,) for group in groups]
    first_slots = np.cumsum([0, *map(len, slots)])[:-1]
    shapes = build_shapes(description, parts, origin, default_material, reports, progress)
    names, name_counts, name_indices = names_of(groups)
    named: list[PlacedObjects] = [*groups, *shapes.groups]
    for placed in shapes.groups:
        names += placed.object_names
        name_counts.append(len(placed.object_names))
    # A medium is pointed to by index: one that cannot be used becomes an empty one.
    media = [
        part if part is not None else _build_medium(Medium(name=medium.name))
        for medium, part in zip(
            description.media, built(description.media, _build_medium, "Volume", reports), strict=True
        )
    ]
    volumes = build_volumes(description.volumes, parts, origin, reports, progress)
    particles, instance_particles = particles_of(groups)
    instancer_values, instancer_rows = instancer_values_of(groups)
    counts = [len(group.object_names) for group in groups]
    mesh_keys = list(dict.fromkeys(group.mesh.key for group in groups))
    mesh_index = {key: index for index, key in enumerate(mesh_keys)}
    scene = _native.Scene(
        origin_in_world=tuple(origin),
        meshes=[parts.meshes[key] for key in mesh_keys],
        mesh_indices=repeated([mesh_index[group.mesh.key] for group in groups], counts, np.uint32),
        world_from_object=relative_matrices([group.world_from_object for group in groups], origin),
        object_names=names,
        name_indices=name_indices,
        first_slot_materials=repeated(first_slots, counts, np.uint32),
        slot_counts=repeated([len(slot) for slot in slots], counts, np.uint16),
        shows_to=repeated([shows_to(group) for group in groups], counts, np.uint8),
        slot_materials=np.array([index for slot in slots for index in slot], dtype=np.uint32),
        randoms=randoms_of(groups),
        object_colors=colors_of(named, name_counts),
        object_indices=repeated([group.pass_index for group in named], name_counts, np.float32),
        **lighting_arrays([group.lighting for group in named], name_counts, description.light_groups),
        **shapes.arguments,
        materials=materials,
        media=media,
        volumes=volumes,
        world_medium=description.world.medium,
        particles=particles,
        instance_particles=instance_particles,
        instancer_values=instancer_values,
        instancer_rows=instancer_rows,
        progress=progress,
    )
    follows = parts.follows_moves and len(groups) == len(description.instances)
    return KeptGeometry(
        scene=scene,
        origin_in_world=origin,
        object_names=names,
        aov_programs=aov_programs,
        reports=reports,
        places=places if follows else np.zeros((0, 3)),
        firsts=np.cumsum([0, *counts]),
        free_places=_free_places(places) if follows else 0,
        fingerprint=b"" if follows else geometry_fingerprint(description),
        description=description if follows else None,
    )


def _build_meshes(
    groups: tuple[Instances, ...], parts: NativeParts, reports: list[str], progress: _native.Progress
) -> list[Instances]:
    """Send the meshes that are new; returns the groups whose mesh can be used."""
    kept: dict[str, _native.TriangleMesh] = {}
    refused: set[str] = set()
    for group in groups:
        mesh = group.mesh
        if mesh.key in kept or mesh.key in refused:
            continue
        if (native := parts.meshes.get(mesh.key)) is not None:
            parts.counts["meshes reused"] += 1
        else:
            progress.message = f"Sending {mesh.name}"
            try:
                native = _native.TriangleMesh(
                    mesh.name,
                    mesh.positions,
                    mesh.triangles,
                    mesh.material_slots,
                    mesh.corner_normals,
                    mesh.uv_maps,
                    progress,
                    parts.builds_hastily,
                )
            except _native.InvalidInput as error:
                reports.append(f"{error}: left out")
                refused.add(mesh.key)
                continue
            parts.counts["meshes sent"] += 1
        kept[mesh.key] = native
        # What a cancelled update has built serves the next one.
        parts.meshes[mesh.key] = native
    parts.meshes = kept
    return [group for group in groups if group.mesh.key in kept]


def _report_open_media(
    groups: list[Instances], materials: tuple[Material, ...], parts: NativeParts, reports: list[str]
) -> None:
    """One line per object whose mesh bounds a medium without closing around it."""
    kept = {}
    for group in groups:
        if all(materials[index].medium < 0 for index in group.materials):
            continue
        key = group.mesh.key
        kept[key] = parts.open_edges[key] if key in parts.open_edges else open_edge_count(group.mesh)
        if kept[key]:
            reports.append(
                f"object '{group.object_names[0]}' bounds a medium, but its mesh is not closed: {kept[key]} edges "
                "have no face on one side; where a ray passes there, the medium begins or ends at a wrong place"
            )
    parts.open_edges = kept


def _with_aov_programs(materials: tuple[Material, ...]) -> tuple[tuple[Material, ...], dict[str, dict[int, int]]]:
    """The materials, and behind them what fills their passes; by name, of a material the one that does."""
    built, programs = list(materials), dict[str, dict[int, int]]()
    for index, material in enumerate(materials):
        for name, program in material.aovs:
            programs.setdefault(name, {})[index] = len(built)
            built.append(program)
    return tuple(built), programs


def _build_materials(materials: tuple[Material, ...], parts: NativeParts, reports: list[str]) -> list[_native.Material]:
    """One per material; one that cannot be used becomes the default grey, with a report."""
    kept: dict[tuple[str, int, int], _native.Texture] = {}

    def texture(use: TextureUse) -> _native.Texture:
        key = (use.image.key, int(use.extension), int(use.interpolation))
        if key not in kept:
            native = parts.textures.get(key)
            parts.counts["images sent" if native is None else "images reused"] += 1
            kept[key] = native if native is not None else build_texture(use, reports)
        return kept[key]

    result = []
    for material in materials:
        try:
            result.append(build_material(material, [texture(use) for use in material.textures]))
        except _native.InvalidInput as error:
            reports.append(f'Material "{material.name}" is drawn grey: {error}')
            result.append(build_material(replace(_DEFAULT_MATERIAL, name=material.name, medium=material.medium), []))
    parts.textures = kept
    parts.texture_files = TextureFiles(materials)
    return result


def _build_medium(medium: Medium) -> _native.Medium:
    return _native.Medium(
        name=medium.name,
        lobes=[(lobe.sigma_s_per_m, lobe.asymmetry_g, lobe.draine_alpha) for lobe in medium.lobes],
        sigma_a_per_m=medium.sigma_a_per_m,
        emission_w_per_m3_sr=medium.emission_w_per_m3_sr,
        receiver_set=medium.receiver_set,
    )
