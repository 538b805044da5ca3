# SPDX-License-Identifier: GPL-3.0-or-later
"""``object.tyndall_voxels``: the file that an object stands for; ``scene.tyndall.voxelize``: how one is made."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import Collection, PropertyGroup

from .tagging import OVERRIDABLE, tag

#: Levels of a .tdag file: 2^level voxels a side.
LEAST_LEVEL, MOST_LEVEL = 2, 17

#: Without it Blender 4.5 and later warn of a path that begins with "//"; older ones do not know the word.
_MAY_BE_RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()

RESOLUTIONS = tuple(
    (str(2**level), f"{2**level:,}", f"{2**level:,} voxels along each side of a cube around what is voxelized", level)
    for level in range(LEAST_LEVEL, MOST_LEVEL + 1)
)
RULES = (
    ("THIN", "Thin", "Without holes from face to face of voxels (6-separating), and no voxel more than that takes", 0),
    ("CONSERVATIVE", "Conservative", "Every voxel that a face touches (26-separating): about twice as many", 1),
)
SYMMETRIES = (
    ("NONE", "None", "Parts are stored once that are equal as they stand", 0),
    ("REFLECTIONS", "Reflections", "Parts are stored once that are mirror images; smallest for buildings", 1),
    ("CUBE", "All Turns", "Parts are stored once that are equal in any of 48 turns and mirrors; smallest for scans", 2),
)
#: What files may keep beside colours and normals, by name, in their order.
CHANNELS = ("roughness", "metallic", "emission", "reflectance")
PREVIEWS = (
    ("NONE", "None", "The box alone", 0),
    ("POINTS", "Points", "A point for each voxel of the preview's level", 1),
    ("BLOCKS", "Blocks", "A block for each voxel of the preview's level", 2),
)


def channels_of(settings: "TyndallVoxelizeSettings") -> list[str]:
    """Those that are chosen and can be kept, by the names that files have for them."""
    return [] if settings.is_solid else [name for name in CHANNELS if getattr(settings, f"has_{name}")]


class TyndallVoxels(PropertyGroup):
    path: StringProperty(
        name="File",
        description="A .tdag file, whose voxels this object stands for. Its cube lies in the object's own space",
        subtype="FILE_PATH",
        options=_MAY_BE_RELATIVE,
        update=tag,
        override=OVERRIDABLE,
    )
    preview: EnumProperty(
        name="Preview",
        description="What 3D views show of the voxels; renders of Tyndall draw them all",
        items=PREVIEWS,
        default="BLOCKS",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    preview_level: IntProperty(
        name="Level",
        description="The preview has 2^level voxels along a side, or fewer where these would be too many to draw",
        min=0,
        max=MOST_LEVEL,
        default=7,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )


class TyndallVoxelizeSettings(PropertyGroup):
    collection: PointerProperty(
        name="Collection",
        description="What becomes voxels, all of it together. None: what is selected",
        type=Collection,
        update=tag,
        override=OVERRIDABLE,
    )
    resolution: EnumProperty(
        name="Resolution",
        description="Voxels along each side of the cube. Twice as many take four times the time and memory",
        items=RESOLUTIONS,
        default="1024",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    rule: EnumProperty(
        name="Rule",
        description="Which voxels belong to a surface",
        items=RULES,
        default="THIN",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    is_solid: BoolProperty(
        name="Solid",
        description="Fill meshes that close. Voxels inside have no surface, and no voxel has colours, normals or "
        "channels then",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    has_colors: BoolProperty(
        name="Colours",
        description="Keep the colours of materials: pictures, filtered to the size of a voxel, and colour "
        "attributes, as materials use them, or as they are where there is no material",
        default=True,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    color_difference: FloatProperty(
        name="Difference",
        description="How far a kept colour may be from its own, by CIE94: 1 is hardly seen side by side, and takes "
        "fewer bytes. 0 keeps all of them",
        min=0.0,
        max=100.0,
        soft_max=10.0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    has_normals: BoolProperty(
        name="Normals",
        description="Keep the smooth normals of the mesh; without them, surfaces look as the voxels lie",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    normal_bits: IntProperty(
        name="Bits",
        description="Of each kept normal: 16 are 0.64 degrees off at most, 32 are 0.0025",
        min=8,
        max=32,
        default=16,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    has_roughness: BoolProperty(
        name="Roughness",
        description="Keep how rough the surface is: of Principled and glossy shaders; diffuse ones have 1. Materials "
        "of the voxels read it by an Attribute node named roughness",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    has_metallic: BoolProperty(
        name="Metallic",
        description="Keep how much of the surface is metal. Materials of the voxels read it by an Attribute node named "
        "metallic",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    has_emission: BoolProperty(
        name="Emission",
        description="Keep how brightly the surface glows, as a share of what glows most: voxels glow so, in its hues "
        "where they have colours. Their materials read it by an Attribute node named emission",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    has_reflectance: BoolProperty(
        name="Reflectance",
        description="Keep Specular of Principled shaders: 0.5 reflects 4 % of the light from ahead. Materials of the "
        "voxels read it by an Attribute node named reflectance",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    symmetry: EnumProperty(
        name="Symmetry",
        description="What counts as equal",
        items=SYMMETRIES,
        default="CUBE",
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    memory_budget_mib: IntProperty(
        name="Memory, MiB",
        description="Budget of the voxels, and as many again for the graph's tables. What does not fit is made in "
        "parts on disk, where that is possible; 0: no limit",
        min=0,
        soft_max=65536,
        default=4096,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
    path: StringProperty(
        name="File",
        description="Where the .tdag file goes; one that is there is written over. Empty: beside the .blend, with the "
        "name of what becomes voxels, and a number if need be",
        subtype="FILE_PATH",
        options=_MAY_BE_RELATIVE,
        update=tag,
        override=OVERRIDABLE,
    )
    hides_sources: BoolProperty(
        name="Hide Originals",
        description="Hide what became voxels, in views and renders: both lie at the same place",
        default=True,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )


CLASSES = (TyndallVoxels, TyndallVoxelizeSettings)
