# SPDX-License-Identifier: GPL-3.0-or-later
"""What the example scenes share: shapes, plain materials, lights, a fog box, a camera, and saving.

Runs in Blender 3.4, so that the files open in every later version. Materials are Diffuse and Emission: what Cycles
shows of them with direct light only is exactly Lambert's law in every version (the Principled node's diffuse lobe
changed in 4.0).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, pi, radians, sin
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

Rgb = tuple[float, float, float]
Point = tuple[float, float, float]


@dataclass
class Shape:
    """Polygons under construction, in metres; several solids may share one."""

    points: list[Vector] = field(default_factory=list)
    faces: list[tuple[int, ...]] = field(default_factory=list)
    slots: list[int] = field(default_factory=list)  #: Material slot of each face.

    def add(
        self,
        points: Sequence[Sequence[float]],
        faces: Sequence[Sequence[int]],
        slot: int = 0,
        place: Matrix | None = None,
    ) -> Shape:
        """Append polygons, placed by a matrix; returns itself for chains."""
        first = len(self.points)
        at = place or Matrix()
        self.points += [at @ Vector(point) for point in points]
        self.faces += [tuple(first + corner for corner in face) for face in faces]
        self.slots += [slot] * len(faces)
        return self

    def box(self, low: Point, high: Point, slot: int = 0, place: Matrix | None = None) -> Shape:
        """Add a closed box between two corners, outward faces."""
        points = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
        faces = [
            (0, 2, 3, 1),
            (4, 5, 7, 6),
            (0, 1, 5, 4),
            (2, 6, 7, 3),
            (0, 4, 6, 2),
            (1, 3, 7, 5),
        ]
        return self.add(points, faces, slot, place)

    def lathe(
        self,
        profile: Sequence[tuple[float, float]],
        sides: int = 24,
        slot: int = 0,
        place: Matrix | None = None,
    ) -> Shape:
        """Turn (radius, height) pairs, from bottom to top, around Z; ends with a radius above zero are capped."""
        points = [
            (
                radius * cos(2 * pi * side / sides),
                radius * sin(2 * pi * side / sides),
                height,
            )
            for radius, height in profile
            for side in range(sides)
        ]
        faces: list[tuple[int, ...]] = [
            (
                ring * sides + side,
                ring * sides + turn,
                (ring + 1) * sides + turn,
                (ring + 1) * sides + side,
            )
            for ring in range(len(profile) - 1)
            for side in range(sides)
            for turn in ((side + 1) % sides,)
        ]
        faces.append(tuple(reversed(range(sides))))
        faces.append(tuple((len(profile) - 1) * sides + side for side in range(sides)))
        return self.add(points, faces, slot, place)

    def tube(
        self,
        start: Sequence[float],
        end: Sequence[float],
        radius: float,
        sides: int = 8,
        slot: int = 0,
    ) -> Shape:
        """Add a capped cylinder from start to end."""
        axis = Vector(end) - Vector(start)
        place = Matrix.Translation(start) @ axis.to_track_quat("Z", "Y").to_matrix().to_4x4()
        return self.lathe([(radius, 0.0), (radius, axis.length)], sides, slot, place)

    def ball(
        self,
        centre: Sequence[float],
        radii: Sequence[float],
        slot: int = 0,
        sides: int = 16,
    ) -> Shape:
        """Add an ellipsoid."""
        rings = sides // 2
        profile = [(max(sin(pi * ring / rings), 1e-3), -cos(pi * ring / rings)) for ring in range(rings + 1)]
        return self.lathe(
            profile,
            sides,
            slot,
            Matrix.Translation(centre) @ Matrix.Diagonal((*radii, 1.0)),
        )

    def mesh(self, name: str, *materials: bpy.types.Material, smooth: bool = False) -> bpy.types.Mesh:
        """Make the mesh datablock."""
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(self.points, [], self.faces)
        mesh.polygons.foreach_set("material_index", self.slots)
        mesh.polygons.foreach_set("use_smooth", [smooth] * len(self.faces))
        for material in materials:
            mesh.materials.append(material)
        mesh.update()
        return mesh


def clear_file() -> None:
    """Start from nothing: no start-up cube, light or camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)


def link(
    name: str,
    data: bpy.types.ID | None,
    collection: bpy.types.Collection | None = None,
    place: Matrix | None = None,
) -> bpy.types.Object:
    """Make an object of a datablock (None: an empty) and put it into a collection (None: the scene's)."""
    made = bpy.data.objects.new(name, data)
    (collection or bpy.context.scene.collection).objects.link(made)
    made.matrix_world = place or Matrix()
    return made


def placed(
    location: Sequence[float],
    turn_degrees: Sequence[float] = (0, 0, 0),
    scale: Sequence[float] = (1, 1, 1),
) -> Matrix:
    """Matrix of a location, XYZ Euler angles in degrees, and a scale."""
    return Matrix.LocRotScale(
        Vector(location),
        Euler([radians(angle) for angle in turn_degrees]),
        Vector(scale),
    )


def shared_collection(name: str) -> bpy.types.Collection:
    """Make a collection outside the scene: only its instances are drawn, and all share its meshes."""
    return bpy.data.collections.new(name)


def instance(
    collection: bpy.types.Collection,
    place: Matrix,
    parent: bpy.types.Collection | None = None,
) -> None:
    """Draw a collection once more."""
    empty = link(collection.name, None, parent, place)
    empty.instance_type = "COLLECTION"
    empty.instance_collection = collection
    empty.empty_display_size = 0.5


def _empty_nodes(tree: bpy.types.NodeTree, output: str) -> bpy.types.Node:
    tree.nodes.clear()
    return tree.nodes.new(output)


def diffuse(name: str, colour: Rgb, image: bpy.types.Image | None = None) -> bpy.types.Material:
    """Lambert's law, with a constant colour or an image over the active UV map."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.diffuse_color = (*colour, 1.0)
    tree = material.node_tree
    output = _empty_nodes(tree, "ShaderNodeOutputMaterial")
    surface = tree.nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = (*colour, 1.0)
    surface.location.x = -250
    if image is not None:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        texture.location.x = -600
        tree.links.new(texture.outputs["Color"], surface.inputs["Color"])
    tree.links.new(surface.outputs[0], output.inputs["Surface"])
    return material


def emission(name: str, colour: Rgb, strength: float) -> bpy.types.Material:
    """A surface that glows for the camera; in direct light only, what it lights is left to real lights."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.diffuse_color = (*colour, 1.0)
    tree = material.node_tree
    output = _empty_nodes(tree, "ShaderNodeOutputMaterial")
    surface = tree.nodes.new("ShaderNodeEmission")
    surface.inputs["Color"].default_value = (*colour, 1.0)
    surface.inputs["Strength"].default_value = strength
    surface.location.x = -250
    tree.links.new(surface.outputs[0], output.inputs["Surface"])
    # Cycles would sample the mesh as a light, which direct light only would then show.
    if hasattr(material.cycles, "sample_as_light"):
        material.cycles.sample_as_light = False
    return material


def packed_image(name: str, pixels: NDArray[np.float32]) -> bpy.types.Image:
    """Image of float32 (height, width, 4), sRGB values, rows bottom to top, stored inside the file."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=True)
    image.pixels.foreach_set(np.clip(pixels, 0.0, 1.0).astype(np.float32).ravel())
    image.pack()
    return image


def fog_box(
    low: Point,
    high: Point,
    per_m: float,
    colour: Rgb = (1, 1, 1),
    asymmetry_g: float = 0.0,
) -> bpy.types.Object:
    """A closed box without a surface that holds a homogeneous Volume Scatter; ``per_m`` is its density."""
    material = bpy.data.materials.new("Fog")
    material.use_nodes = True
    output = _empty_nodes(material.node_tree, "ShaderNodeOutputMaterial")
    medium = material.node_tree.nodes.new("ShaderNodeVolumeScatter")
    medium.inputs["Color"].default_value = (*colour, 1.0)
    medium.inputs["Density"].default_value = per_m
    medium.inputs["Anisotropy"].default_value = asymmetry_g
    medium.location.x = -250
    material.node_tree.links.new(medium.outputs[0], output.inputs["Volume"])
    box = link("Fog Box", Shape().box(low, high).mesh("Fog Box", material))
    box.display_type = "WIRE"
    return box


def sun(
    name: str,
    towards_sun: Point,
    strength: float,
    colour: Rgb,
    angle_degrees: float = 0.5,
) -> bpy.types.Object:
    """A sun; strength in W/m^2 on a plane that faces it."""
    data = bpy.data.lights.new(name, "SUN")
    data.energy, data.color, data.angle = strength, colour, radians(angle_degrees)
    turn = Vector(towards_sun).to_track_quat("Z", "Y").to_matrix().to_4x4()
    return link(
        name,
        data,
        place=Matrix.Translation(Vector(towards_sun).normalized() * 30) @ turn,
    )


def point_light(name: str, location: Point, watt: float, colour: Rgb, radius: float = 0.05) -> bpy.types.Object:
    """A point light with a small body."""
    data = bpy.data.lights.new(name, "POINT")
    data.energy, data.color, data.shadow_soft_size = watt, colour, radius
    return link(name, data, place=Matrix.Translation(location))


def spot_light(
    name: str,
    location: Point,
    target: Point,
    watt: float,
    colour: Rgb,
    cone_degrees: float,
    blend: float = 0.15,
) -> bpy.types.Object:
    """A spot light of 2 cm radius that points at a target."""
    data = bpy.data.lights.new(name, "SPOT")
    data.energy, data.color, data.shadow_soft_size = watt, colour, 0.02
    data.spot_size, data.spot_blend = radians(cone_degrees), blend
    turn = (Vector(location) - Vector(target)).to_track_quat("Z", "Y").to_matrix().to_4x4()
    return link(name, data, place=Matrix.Translation(location) @ turn)


def camera(location: Point, target: Point, lens_mm: float, shift_y: float = 0.0) -> bpy.types.Object:
    """The scene's camera, on a 36 mm sensor."""
    data = bpy.data.cameras.new("Camera")
    data.lens, data.shift_y, data.clip_start, data.clip_end = (
        lens_mm,
        shift_y,
        0.1,
        1000.0,
    )
    turn = (Vector(location) - Vector(target)).to_track_quat("Z", "Y").to_matrix().to_4x4()
    made = link("Camera", data, place=Matrix.Translation(location) @ turn)
    bpy.context.scene.camera = made
    return made


def world(colour: Rgb, strength: float) -> None:
    """A constant sky."""
    made = bpy.data.worlds.new("World")
    made.use_nodes = True
    background = made.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*colour, 1.0)
    background.inputs["Strength"].default_value = strength
    made.color = tuple(channel * strength for channel in colour)
    bpy.context.scene.world = made


def towards(azimuth_degrees: float, height_degrees: float) -> Vector:
    """Unit vector; azimuth from straight ahead, +Y, to the right."""
    azimuth, height = radians(azimuth_degrees), radians(height_degrees)
    return Vector((sin(azimuth) * cos(height), cos(azimuth) * cos(height), sin(height)))


def edit_occluders(light: bpy.types.Object, kind: str, **settings: object) -> bpy.types.PropertyGroup:
    """Add an edit of a light's occluders; settings of the noise are given as they are called there."""
    edits = light.data.tyndall.occluder_edits
    edit = edits.add()
    edit.kind, edit.order = kind, len(edits)
    edit.name = edit.bl_rna.properties["kind"].enum_items[kind].name
    for name, value in settings.items():
        setattr(edit.noise if hasattr(edit.noise, name) else edit, name, value)
    return edit


def paint_air(
    places_m: Sequence[Sequence[float]],
    volume: str,
    value: float,
    radius_m: float,
    *,
    normal: Sequence[float] = (0.0, 0.0, 1.0),
    **brush_settings: float,
) -> None:
    """Paint one stroke, at full opacity unless told otherwise, through places in the world; the box is the scene's."""
    brush = bpy.context.scene.tyndall.air_brush
    brush.volume, brush.mode, brush.opacity, brush.radius_m = volume, "PAINT", 1.0, radius_m
    setattr(brush, volume.lower(), value)
    for name, setting in brush_settings.items():
        setattr(brush, name, setting)
    dabs = [{"name": "", "location": place_m, "pressure": 1.0} for place_m in places_m]
    bpy.ops.tyndall.paint_air_stroke(dabs=dabs, normal=normal)


def set_up(*, view: str, look: str = "None", exposure: float = 0.0) -> None:
    """Set the render up: full HD, direct light and single scattering only."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 1920, 1080
    scene.view_settings.view_transform, scene.view_settings.look = view, look
    scene.view_settings.exposure = exposure
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = (
        64,
        False,
        False,
    )
    cycles.max_bounces = cycles.diffuse_bounces = cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 64


def save(script: str) -> None:
    """Save the scene beside the script, compressed."""
    bpy.context.scene.render.filepath = "//" + Path(script).stem
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(Path(script).with_suffix(".blend").resolve()), compress=True)


def finish(script: str, *, view: str, look: str = "None", exposure: float = 0.0) -> None:
    """Set the render up, and save."""
    set_up(view=view, look=look, exposure=exposure)
    save(script)
