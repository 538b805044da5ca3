# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's materials: a surface program and the medium inside."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from tyndall.scene_description import Material, Medium, attribute_maps

from ..shader_nodes import ALWAYS_HAS_NODES, shader_tree
from .aov_nodes import read_aovs
from .asked_properties import PropertyReader
from .displacement_nodes import displaced_normal, read_displacement
from .field_media import read_fields
from .lobe_nodes import plain_principled
from .mesh_attributes import uv_maps_of, what_is_missing
from .names import Name, name_of
from .node_graph import output_input
from .program import BLACK, WHITE, grey
from .reports import Reports
from .seen_camera import seen_camera
from .shadow_rays import passable
from .surface_nodes import Shares, SharpSurfaces, read_surface
from .value_nodes import Domain, ValueReader
from .worlds import occlusion_reach_m

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import bpy
    from bpy.types import Depsgraph

    from tyndall.scene_description import Mesh

    from .asked_properties import Rgba
    from .field_media import DensityField
    from .images import ImageReader
    from .instances import Placement
    from .node_graph import Socket
    from .seen_camera import SeenCamera

COLOUR = ""  #: What voxels keep, beside the names of channels.
_OF_ATTRIBUTES = attribute_maps("")[0]  #: What names of their first maps begin with.


class MaterialReader:
    """The materials and media of one frame, each read once; indices are those of the scene description."""

    def __init__(
        self,
        reports: Reports,
        images: ImageReader,
        override: bpy.types.Material | None = None,
        *,
        is_lit: bool = True,
        sharp: SharpSurfaces | None = None,
        is_voxels: bool = False,
        camera: SeenCamera | None = None,
    ) -> None:
        """``override`` is the view layer's: in place of all others, as in Cycles.

        Without ``is_lit`` surfaces give no light: they let as much through as they do, and cost no shadow ray.
        ``sharp`` says what mirrors, and bends what is seen through it; None: nothing does.
        ``is_voxels`` fills ``channels``; gloss counts as diffuse.
        ``camera`` is what surfaces may ask for.
        """
        self.materials: list[Material] = []
        self.names: list[Name | None] = []  #: Of Blender's; None: of an empty slot, or a copy with another medium.
        self.notes: list[Reports] = []  #: About each alone.
        #: Passes that materials may fill, by name: whether they are colours.
        self.aovs: Mapping[str, bool] = {}
        #: Of Ambient Occlusion nodes without a distance; None: surfaces stand alone, and no node traces rays.
        self.occlusion_reach_m: float | None = None
        self.properties: PropertyReader | None = None  #: None: surfaces are on no object whose own are known.
        #: Of each material, by name: colour (COLOUR), roughness, metallic and reflectance, the diffuse part of a
        #: program of which the transparent part is their weight; and emission, the diffuse part.
        self.channels: list[dict[str, Material]] = []
        self.media: list[Medium] = []
        self._reports = reports
        self._images = images
        self._override = override
        self._is_lit = is_lit
        self._sharp = sharp if is_lit else None
        self._is_voxels = is_voxels
        self._camera = camera
        self.asked_camera: SeenCamera | None = None  #: Once a material has asked for it.
        self._placement: Placement | None = None  #: Whose material is read.
        self._asked: dict[bpy.types.Material | None, dict[tuple[str, str], None]] = {}  #: Of objects.
        self._index_of: dict[tuple[bpy.types.Material | None, tuple[Rgba | int | None, ...]], int] = {}
        self._fields: dict[int, list[tuple[DensityField, int]]] = {}

    def index(self, material: bpy.types.Material | None, placement: Placement | None = None) -> int:
        """None is an empty slot: Blender's default, which is grey and diffuse before 5.0.

        What its nodes ask of the object is that of ``placement``: of others it may be another material.
        """
        material = self.shader_of(material)
        self._placement = placement
        key = material, self._told(material)
        if key not in self._index_of:
            index = len(self.materials)
            self.channels.append({})
            reports, self._reports = self._reports, Reports()
            read = self._with_displacement(self._read(material), material)
            self._append(self._with_aovs(read, material), material, self._reports)
            reports.include(self._reports)
            self._reports = reports
            key = material, self._told(material)  # what it asks is known now
            self._index_of[key] = index
        return self._index_of[key]

    def _append(self, read: Material, material: bpy.types.Material | None, notes: Reports) -> None:
        self.materials.append(read)
        self.names.append(None if material is None else name_of(material))
        self.notes.append(notes)

    def add_copy(self, index: int, medium: int) -> int:
        """Of a material, with another medium."""
        self._append(replace(self.materials[index], medium=medium), None, Reports())
        self.channels.append(self.channels[index])
        return len(self.materials) - 1

    def has_medium(self, index: int) -> bool:
        """Whether something is inside, also if nothing of it is the same everywhere."""
        return self.materials[index].medium >= 0 or index in self._fields

    @property
    def asks_properties(self) -> bool:
        """Of objects, by any of them."""
        return any(self._asked.values())

    def indices(self, placement: Placement) -> list[int]:
        """One per slot."""
        return [self.index(material, placement) for material in placement.materials]

    def _told(self, material: bpy.types.Material | None) -> tuple[Rgba | int | None, ...]:
        return tuple(self._property_of(*asked) for asked in self._asked.get(material, ()))

    def _property_of(self, kind: str, name: str) -> Rgba | int | None:
        if self.properties is None or self._placement is None:
            return None
        return self.properties.read(kind, name, self._placement)

    def fields(self, material: bpy.types.Material | None, placement: Placement) -> list[tuple[DensityField, int]]:
        """What varies in its volume, and the media that this multiplies."""
        return self._fields.get(self.index(material, placement), [])

    def add_medium(self, medium: Medium | None) -> int:
        if medium is None:
            return -1
        self.media.append(medium)
        return len(self.media) - 1

    def shader_of(self, material: bpy.types.Material | None) -> bpy.types.Material | None:
        """What is drawn in place of a slot's material: itself, unless the view layer has one for all."""
        return self._override or material

    def _read(self, material: bpy.types.Material | None) -> Material:
        if material is None:
            self.channels[-1] = {
                COLOUR: Material(name="no material", transparent=WHITE),
                "roughness": Material(name="no material", diffuse=WHITE, transparent=WHITE),
            }
            if not self._is_lit:
                return Material(name="no material", diffuse=BLACK)
            if ALWAYS_HAS_NODES and not self._is_voxels:
                return Material(name="no material", diffuse=BLACK, lobes=(plain_principled().constant(lambda _: -1),))
            return Material(name="no material")
        tree = shader_tree(material)
        if tree is None:
            colour = material.diffuse_color
            diffuse = (colour[0], colour[1], colour[2]) if self._is_lit else BLACK
            plain = {
                COLOUR: diffuse,
                "roughness": grey(material.roughness),
                "metallic": grey(material.metallic),
                "reflectance": grey(material.specular_intensity),
            }
            self.channels[-1] = {
                name: Material(name=material.name, diffuse=value, transparent=WHITE) for name, value in plain.items()
            }
            return Material(name=material.name, diffuse=diffuse)
        surface, volume = (output_input(tree, name) for name in ("Surface", "Volume"))
        medium = -1
        has_volume = volume is not None and volume.is_connected()
        if volume is not None and has_volume:
            medium = self._medium(volume, material)
            if surface is None or not surface.is_connected():
                return Material(name=material.name, has_surface=False, medium=medium)
        values = self._on_instances(material)
        # Without an output it is black, as in Cycles.
        shares = Shares()
        if surface is not None:
            values.displaced_normal = displaced_normal(values, material, output_input(tree, "Displacement"))
            shares = read_surface(values, surface, self._sharp, is_voxels=self._is_voxels)
        shares.transparent = passable(values.program, shares, material, has_volume=has_volume)
        if not self._is_lit:
            shares.diffuse = shares.emission = shares.held_out = BLACK
        if (finish := shares.finish) is not None:
            program = values.program
            self.channels[-1] = {
                name: program.material(material.name, (value, finish.weight, BLACK))
                for name, value in (
                    (COLOUR, finish.colour),
                    ("roughness", finish.roughness),
                    ("metallic", finish.metallic),
                    ("reflectance", finish.reflectance),
                )
            } | {"emission": program.material(material.name, (shares.emission, BLACK, BLACK))}
        results = (shares.diffuse, shares.transparent, shares.emission)
        lobes = shares.lobes if self._is_lit and shares.lobes is not None else ()
        return values.program.material(material.name, results, shares.gloss, lobes, shares.held_out, medium=medium)

    def _medium(self, volume: Socket, material: bpy.types.Material) -> int:
        """Of what does not vary; notes what does."""
        of_all, fields = read_fields(self._values(material, Domain.SURFACE), volume, material.name)
        medium = self.add_medium(of_all)
        if fields:
            self._fields[len(self.materials)] = [(field, self.add_medium(field.medium)) for field in fields]
        return medium

    def _with_displacement(self, read: Material, material: bpy.types.Material | None) -> Material:
        tree = None if material is None else shader_tree(material)
        at = output_input(tree, "Displacement")
        if material is None or at is None:
            return read
        displacement = read_displacement(self._values(material, Domain.SURFACE), material, at)
        return read if displacement is None else replace(read, displacement=displacement)

    def _with_aovs(self, read: Material, material: bpy.types.Material | None) -> Material:
        tree = None if material is None or not self.aovs else shader_tree(material)
        if tree is None:
            return read
        return replace(read, aovs=read_aovs(self._on_instances(material), tree, self.aovs, read.name))

    def _ask_camera(self) -> SeenCamera | None:
        self.asked_camera = self._camera
        return self._camera

    def _on_instances(self, material: bpy.types.Material) -> ValueReader:
        """On what is drawn; surfaces that stand alone are of no instance."""
        reader = self._values(material, Domain.SURFACE)
        reader.tells_particles = self.occlusion_reach_m is not None
        return reader

    def _values(self, material: bpy.types.Material, domain: Domain) -> ValueReader:
        is_seen = self._is_lit or domain is Domain.CONSTANT
        reports = self._reports if is_seen else Reports()  # nobody misses the gloss of black surfaces
        reader = ValueReader(f'Material "{material.name}"', reports, self._images, domain)
        reader.camera, reader.material_index = self._ask_camera, material.pass_index
        reader.occlusion_reach_m = self.occlusion_reach_m
        reader.misses_surroundings = self.occlusion_reach_m is None
        of_cycles = getattr(material, "cycles", None)  # where its add-on is on
        reader.corrects_bumps = getattr(of_cycles, "use_bump_map_correction", True)
        asked = self._asked.setdefault(material, {})

        def property_of(kind: str, name: str) -> Rgba | int | None:
            asked[kind, name] = None
            return self._property_of(kind, name)

        reader.property_of = property_of
        return reader


def note_missing_attributes(
    object_name: str, mesh: Mesh, indices: Iterable[int], materials: MaterialReader, reports: Reports
) -> None:
    """Say what its materials read as black, as Cycles does."""
    has = {name for name, _ in mesh.uv_maps}
    for index in indices:
        asked = uv_maps_of(materials.materials[index])
        for what in what_is_missing(asked, has):
            reports.add(f'Object "{object_name}"', f"has no {what}, which its material reads")
        for name in asked:
            _, mark, attribute = name.partition(_OF_ATTRIBUTES)
            if mark and not any(
                known == name if attribute else known != name and known.startswith(name) for known in has
            ):
                wanted = f'colour attribute "{attribute}"' if attribute else "colour attribute"
                reports.add(f'Object "{object_name}"', f"has no {wanted}, which its material reads: black")


def scene_materials(
    depsgraph: Depsgraph, images: ImageReader, reports: Reports, *, is_lit: bool, is_preview: bool = False
) -> MaterialReader:
    """For all that a depsgraph draws. ``is_preview``: with mirrors and glass that bends, whatever it asks."""
    layer, indirect = depsgraph.view_layer_eval, depsgraph.scene_eval.tyndall.indirect
    sharp = None
    if is_preview or indirect.has_mirrors:
        sharp = SharpSurfaces(indirect.mirror_roughness, bend=is_preview or indirect.has_refraction)
    camera = seen_camera(depsgraph)
    materials = MaterialReader(reports, images, layer.material_override, is_lit=is_lit, sharp=sharp, camera=camera)
    materials.occlusion_reach_m = occlusion_reach_m(depsgraph.scene_eval)
    materials.properties = PropertyReader(depsgraph)
    if depsgraph.mode != "VIEWPORT":  # which shows the picture alone
        materials.aovs = {aov.name: aov.type == "COLOR" for aov in layer.aovs if aov.is_valid}
    return materials
