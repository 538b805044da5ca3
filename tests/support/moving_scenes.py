# SPDX-License-Identifier: GPL-3.0-or-later
"""A wall, a sun and what moves before it while a shutter is open, for tests of motion blur."""

from __future__ import annotations

import math

import bpy
import numpy as np

from addon import last_render
from addon.shader_nodes import use_nodes
from addon.shutter_position import position_settings
from support.cycles_reference import FloatArray, rendered_pixels
from support.new_file import new_file

FRAME = 10
SIZE_PX = 36
Scene = bpy.types.Scene


def curves_of(thing: bpy.types.ID) -> list[bpy.types.FCurve]:
    """Of a datablock's own action."""
    action = thing.animation_data.action
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return list(action.layers[0].strips[0].channelbag(thing.animation_data.action_slot).fcurves)


def animate(
    thing: bpy.types.bpy_struct,
    path: str,
    before: object,
    after: object,
    frames: tuple[int, int] = (9, 11),
    owner: bpy.types.ID | None = None,
) -> None:
    """Evenly from one frame to the other, and beyond; ``owner``: of what is no datablock."""
    for frame, value in zip(frames, (before, after), strict=True):
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)
    for curve in curves_of(owner or thing):
        curve.extrapolation = "LINEAR"
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def add_object(
    scene: Scene, name: str, data: bpy.types.ID | None, place: tuple[float, float, float]
) -> bpy.types.Object:
    thing = bpy.data.objects.new(name, data)
    thing.location = place
    scene.collection.objects.link(thing)
    return thing


def add_mesh(
    scene: Scene, name: str, scale: tuple[float, float, float], place: tuple[float, float, float], glow: float = 0.0
) -> bpy.types.Object:
    """A box of [-1, 1]^3 times the scale; ``glow``: of nothing but emission."""
    mesh = bpy.data.meshes.new(name)
    corners = [(x * scale[0], y * scale[1], z * scale[2]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.from_pydata(corners, [], faces)
    material = bpy.data.materials.new(name)
    use_nodes(material)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader = nodes.new("ShaderNodeEmission" if glow else "ShaderNodeBsdfDiffuse")
    if glow:
        shader.inputs["Strength"].default_value = glow
    links.new(shader.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    mesh.materials.append(material)
    return add_object(scene, name, mesh, place)


def new_stage() -> Scene:
    """A bright wall at z = 0 under a sun, seen from above by an orthographic camera, 4 m wide; frame 10."""
    scene = new_file(is_empty=True)
    render = scene.render
    render.engine = "TYNDALL"
    render.resolution_x = render.resolution_y = SIZE_PX
    render.resolution_percentage = 100
    render.use_motion_blur, render.motion_blur_shutter = True, 1.0
    data = bpy.data.cameras.new("camera")
    data.type, data.ortho_scale = "ORTHO", 4.0
    scene.camera = add_object(scene, "camera", data, (0, 0, 6))
    add_mesh(scene, "wall", (4, 4, 0.1), (0, 0, -0.1))
    lamp = bpy.data.lights.new("sun", "SUN")
    lamp.energy, lamp.angle = 3.0, 0.0
    sun = add_object(scene, "sun", lamp, (0, 0, 5))
    sun.rotation_euler = (0.3, 0.4, 0.0)
    scene.tyndall.pixel_filter, scene.tyndall.filter_width_px = "BOX", 0.01
    scene.tyndall.noise_threshold = 0.0
    scene.tyndall.pixel_samples = scene.tyndall.motion_steps = 16
    scene.tyndall.shafts.method = "EXACT"
    scene.frame_set(FRAME)
    return scene


def set_position(scene: Scene, position: str) -> None:
    position_settings(scene).motion_blur_position = position


def blurred(scene: Scene, samples: int = 16) -> FloatArray:
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples = scene.tyndall.motion_steps = samples
    picture = rendered_pixels(scene)
    assert (scene.frame_current, scene.frame_subframe) == (FRAME, 0.0), "Blender's frame is back where it was"
    return picture


def counts(scene: Scene) -> dict[str, float]:
    found: dict[str, float] = (last_render.statistics_of(scene.name) or {})["counts"]
    return found


def reports(scene: Scene) -> str:
    return "\n".join((last_render.statistics_of(scene.name) or {})["reports"])


def mean_of_stills(scene: Scene, moments: list[float]) -> FloatArray:
    """Brute force: a picture of its own at each moment, in frames from the present one."""
    scene.render.use_motion_blur = False
    pictures = []
    for moment in moments:
        frame = FRAME + moment
        scene.frame_set(math.floor(frame), subframe=frame % 1.0)
        pictures.append(rendered_pixels(scene))
    scene.frame_set(FRAME)
    scene.render.use_motion_blur = True
    mean: FloatArray = np.mean(pictures, axis=0)
    return mean


def middles(count: int, opens: float, closes: float) -> list[float]:
    return [opens + (closes - opens) * (index + 0.5) / count for index in range(count)]


def move_light(scene: Scene) -> None:
    sun = bpy.data.objects["sun"]
    add_mesh(scene, "block", (0.47, 0.52, 0.1), (0, 0, 1))  # no edge through centres of pixels
    animate(sun, "rotation_euler", (0.3, -0.4, 0), (0.3, 0.4, 0))
    animate(sun.data, "energy", 1.0, 5.0)


def move_lens(scene: Scene) -> None:
    add_mesh(scene, "block", (0.5, 0.5, 0.5), (0.5, 0.3, 0.5))
    camera = scene.camera
    camera.data.type = "PERSP"
    animate(camera.data, "lens", 40.0, 70.0)
    animate(camera, "location", (-0.3, 0, 6), (0.3, 0.2, 6))


def move_occluder_in_fog(scene: Scene) -> None:
    fog = add_mesh(scene, "fog", (1.8, 1.8, 1.5), (0, 0, 1.6))
    nodes, links = fog.data.materials[0].node_tree.nodes, fog.data.materials[0].node_tree.links
    nodes.clear()
    scatter = nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Density"].default_value = 0.2
    links.new(scatter.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    roof = add_mesh(scene, "roof", (0.8, 0.8, 0.05), (0, 0, 2.5))
    animate(roof, "location", (-1, 0, 2.5), (1, 0, 2.5))
    scene.camera.data.type, scene.camera.data.lens = "PERSP", 50.0


def deform(scene: Scene) -> None:
    block = add_mesh(scene, "block", (0.5, 0.5, 0.5), (0, 0, 0.5))
    block.shape_key_add(name="Basis")
    key = block.shape_key_add(name="bent")
    for index, corner in enumerate(key.data):
        corner.co.x += 1.0 if index % 2 else -0.3
    animate(key, "value", 0.0, 1.0, owner=block.data.shape_keys)


def move(_scene: Scene) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.6)
    ball = bpy.context.object
    animate(ball, "location", (-1.2, -0.5, 1), (1.2, 0.5, 1.5))


def rotate(scene: Scene) -> None:
    bar = add_mesh(scene, "bar", (1.5, 0.2, 0.1), (0, 0, 1))
    animate(bar, "rotation_euler", (0, 0, -0.8), (0, 0, 0.8))


def move_camera(scene: Scene) -> None:
    add_mesh(scene, "block", (0.5, 0.5, 0.5), (0.5, 0.3, 0.5))
    add_mesh(scene, "post", (0.1, 0.1, 1.0), (-0.8, 0.3, 1.0))
    scene.camera.data.type, scene.camera.data.lens = "PERSP", 50.0
    animate(scene.camera, "location", (-0.8, 0, 6), (0.8, 0.4, 6))
