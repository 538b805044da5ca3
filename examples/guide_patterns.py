# SPDX-License-Identifier: GPL-3.0-or-later
"""The shelf of the guide to voxels: marble, brass, wood and bricks that nodes make, as meshes and as voxels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from guide_edits import become_voxels
from mathutils import Vector

if TYPE_CHECKING:
    from collections.abc import Callable

#: Of voxels along the longest side.
RESOLUTION = 512
Ramp = tuple[tuple[float, tuple[float, float, float]], ...]
MARBLE: Ramp = ((0.38, (0.02, 0.05, 0.08)), (0.48, (0.5, 0.55, 0.58)), (0.62, (0.85, 0.83, 0.78)))
WOOD: Ramp = ((0.2, (0.09, 0.03, 0.01)), (0.8, (0.42, 0.2, 0.08)))
PATINA: Ramp = ((0.46, (0.82, 0.5, 0.16)), (0.58, (0.1, 0.42, 0.34)))
METAL: Ramp = ((0.46, (1.0, 1.0, 1.0)), (0.58, (0.0, 0.0, 0.0)))


def show_patterns(*, are_voxels: bool) -> None:
    """Build the scene anew."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    _thing("primitive_plane_add", "Floor", _bricks, size=16.0)
    head = _thing("primitive_monkey_add", "Head", _marble, location=(0.0, 0.1, 0.74), rotation=(-0.6, 0.0, -0.1))
    head.modifiers.new("Smooth", "SUBSURF").render_levels = head.modifiers[0].levels = 3
    _thing("primitive_cube_add", "Block", _wood, size=1.5, location=(-2.1, 0.2, 0.75), rotation=(0.0, 0.0, 0.5))
    ring = {"major_radius": 0.75, "minor_radius": 0.3, "major_segments": 96, "minor_segments": 48}
    _thing("primitive_torus_add", "Ring", _brass, location=(2.1, -0.2, 0.98), rotation=(1.25, 0.2, 0.5), **ring)
    for thing in scene.objects:
        for face in thing.data.polygons:
            face.use_smooth = thing.name in {"Head", "Ring"}
    _light(scene)
    if are_voxels:
        settings = scene.tyndall.voxelize
        settings.has_normals = settings.has_roughness = settings.has_metallic = True
        become_voxels(RESOLUTION)


def _light(scene: bpy.types.Scene) -> None:
    for name, kind, place, energy in (
        ("Key", "AREA", (-3.0, -4.0, 5.0), 700.0),
        ("Rim", "AREA", (4.5, 2.5, 3.0), 350.0),
    ):
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
        lamp.data.energy, lamp.data.size, lamp.location = energy, 2.5, place
        lamp.rotation_euler = (Vector((0.0, 0.0, 0.8)) - lamp.location).to_track_quat("-Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("Sky")
    if not scene.world.use_nodes:
        scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.06, 0.08, 0.11, 1)
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.camera.data.lens, scene.camera.location = 42, (0.6, -7.6, 3.0)
    scene.camera.rotation_euler = (Vector((0.0, 0.0, 0.85)) - scene.camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 64, 0.01
    scene.view_settings.view_transform = "Filmic" if bpy.app.version < (4, 0, 0) else "AgX"


def _thing(
    operator: str, name: str, pattern: Callable[[bpy.types.ShaderNodeTree, bpy.types.Node], None], **fields: object
) -> bpy.types.Object:
    getattr(bpy.ops.mesh, operator)(**fields)
    thing = bpy.context.object
    thing.name = name
    material = bpy.data.materials.new(name)
    if not material.use_nodes:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfPrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    pattern(tree, shader)
    thing.data.materials.append(material)
    return thing


def _texture(tree: bpy.types.ShaderNodeTree, kind: str, **inputs: float) -> bpy.types.Node:
    """Of the object's own coordinates."""
    place, texture = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new(kind)
    for name, value in inputs.items():
        texture.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(place.outputs["Object"], texture.inputs["Vector"])
    return texture


def _ramp(tree: bpy.types.ShaderNodeTree, value: bpy.types.NodeSocket, colours: Ramp) -> bpy.types.NodeSocket:
    node = tree.nodes.new("ShaderNodeValToRGB")
    elements = node.color_ramp.elements
    while len(elements) < len(colours):
        elements.new(0.5)
    for element, (place, colour) in zip(elements, colours, strict=True):
        element.position, element.color = place, (*colour, 1.0)
    tree.links.new(value, node.inputs[0])
    return node.outputs["Color"]


def _marble(tree: bpy.types.ShaderNodeTree, shader: bpy.types.Node) -> None:
    noise = _texture(tree, "ShaderNodeTexNoise", Scale=2.2, Detail=8.0, Distortion=1.6)
    tree.links.new(_ramp(tree, noise.outputs[0], MARBLE), shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.25


def _wood(tree: bpy.types.ShaderNodeTree, shader: bpy.types.Node) -> None:
    wave = _texture(tree, "ShaderNodeTexWave", Scale=2.0, Distortion=5.0, Detail=3.0)
    wave.wave_type = "RINGS"
    tree.links.new(_ramp(tree, wave.outputs["Color"], WOOD), shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.6


def _brass(tree: bpy.types.ShaderNodeTree, shader: bpy.types.Node) -> None:
    noise = _texture(tree, "ShaderNodeTexNoise", Scale=3.0, Detail=6.0)
    tree.links.new(_ramp(tree, noise.outputs[0], PATINA), shader.inputs["Base Color"])
    tree.links.new(_ramp(tree, noise.outputs[0], METAL), shader.inputs["Metallic"])
    shader.inputs["Roughness"].default_value = math.sqrt(0.1)


def _bricks(tree: bpy.types.ShaderNodeTree, shader: bpy.types.Node) -> None:
    bricks = _texture(tree, "ShaderNodeTexBrick", Scale=1.0, Mortar_Size=0.03)
    bricks.inputs["Color1"].default_value = (0.2, 0.14, 0.11, 1)
    bricks.inputs["Color2"].default_value = (0.3, 0.2, 0.15, 1)
    bricks.inputs["Mortar"].default_value = (0.05, 0.05, 0.05, 1)
    tree.links.new(bricks.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.8
