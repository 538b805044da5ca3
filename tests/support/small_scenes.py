# SPDX-License-Identifier: GPL-3.0-or-later
"""Small things to put into Blender's scene, by data alone: no operator, no context."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from addon.shader_nodes import use_nodes
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from tyndall.scene_description import Instances, SceneDescription

from .new_file import new_file

Node = bpy.types.Node
#: Builds a shader from `new(type)` and `link(output, input)`, and returns its output.
Build = Callable[[Callable[[str], Node], Callable[..., object]], bpy.types.NodeSocket]

CUBE_CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def empty_scene(size_px: int = 8) -> bpy.types.Scene:
    """A black world and an orthographic camera at z = 3 that looks down on one centimetre around the origin."""
    scene = new_file(is_empty=True)
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x = scene.render.resolution_y = size_px
    scene.world = bpy.data.worlds.new("World")
    use_nodes(scene.world)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 0.01
    scene.camera = add("Camera", camera, location=(0, 0, 3))
    return scene


def add(name: str, data: bpy.types.ID | None, location: Sequence[float] = (0, 0, 0)) -> bpy.types.Object:
    thing = bpy.data.objects.new(name, data)
    thing.location = location
    bpy.context.scene.collection.objects.link(thing)
    return thing


def mesh(
    name: str,
    corners: Sequence[Sequence[float]],
    faces: Sequence[Sequence[int]],
    material: bpy.types.Material | None = None,
) -> bpy.types.Mesh:
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    if material is not None:
        data.materials.append(material)
    return data


def cube(name: str = "Cube", material: bpy.types.Material | None = None) -> bpy.types.Object:
    return add(name, mesh(name, CUBE_CORNERS, CUBE_FACES, material))


def plane(z: float = 0.0, material: bpy.types.Material | None = None, half_side: float = 10.0) -> bpy.types.Object:
    corners = [(x * half_side, y * half_side, z) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    data = mesh("Plane", corners, [(0, 1, 2, 3)], material)
    data.uv_layers.new(name="UV")
    return add("Plane", data)


def light(kind: str, location: Sequence[float], **properties: object) -> bpy.types.Object:
    data = bpy.data.lights.new(kind.title(), kind)
    for name, value in properties.items():
        setattr(data, name, value)
    return add(kind.title(), data, location)


def material(name: str, surface: Build | None = None, volume: Build | None = None) -> bpy.types.Material:
    data = bpy.data.materials.new(name)
    use_nodes(data)
    data.node_tree.nodes.clear()
    output = data.node_tree.nodes.new("ShaderNodeOutputMaterial")
    for socket, build in (("Surface", surface), ("Volume", volume)):
        if build is not None:
            data.node_tree.links.new(build(data.node_tree.nodes.new, data.node_tree.links.new), output.inputs[socket])
    return data


def node(new: Callable[[str], Node], kind: str, **inputs: object) -> Node:
    """A node with these default values; underscores in names are spaces, numbers are repeated as a colour needs."""
    created = new(kind)
    for name, value in inputs.items():
        created.inputs[name.replace("_", " ")].default_value = value
    return created


def red_green() -> tuple[bpy.types.Material, bpy.types.Material]:
    """Two materials, to tell slots apart."""
    return tuple(
        material(
            name, surface=lambda new, _link, colour=colour: node(new, "ShaderNodeBsdfDiffuse", Color=colour).outputs[0]
        )
        for name, colour in (("Red", (1, 0, 0, 1)), ("Green", (0, 1, 0, 1)))
    )


def read(reader: SceneReader | None = None, *, is_live: bool = False) -> SceneDescription:
    """What a render of the scene would be given."""
    reader = SceneReader() if reader is None else reader
    return reader.read(bpy.context.evaluated_depsgraph_get(), Reports(), lambda: None, is_live=is_live)


def placements(description: SceneDescription, object_name: str) -> list[Instances]:
    return [group for group in description.instances if object_name in group.object_names]


def world_positions(group: Instances) -> NDArray[np.float64]:
    """Every vertex of every instance, (count, vertices, 3)."""
    corners = np.concatenate([group.mesh.positions, np.ones((len(group.mesh.positions), 1))], axis=1)
    return np.einsum("nij,vj->nvi", group.world_from_object, corners)[..., :3]


def displace(shown: bpy.types.Material, moved: Build, method: str) -> None:
    """Give a material a displacement, by a bump, by moving its meshes or by both."""
    if bpy.app.version >= (4, 1, 0):
        shown.displacement_method = method
    else:
        shown.cycles.displacement_method = method
    tree = shown.node_tree
    output = next(each for each in tree.nodes if each.type == "OUTPUT_MATERIAL")
    tree.links.new(moved(tree.nodes.new, tree.links.new), output.inputs["Displacement"])


def block_shadow_rays(shown: bpy.types.Material) -> None:
    """Switch "Transparent Shadows" off, which moved out of Cycles' settings in 4.2."""
    owner = shown if hasattr(shown, "use_transparent_shadow") else shown.cycles
    owner.use_transparent_shadow = False
