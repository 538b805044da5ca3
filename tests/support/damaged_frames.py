# SPDX-License-Identifier: GPL-3.0-or-later
"""More cameras, frames, lights and worlds that are broken."""

from __future__ import annotations

from math import inf, nan

import bpy

from support.damaged_nodes import ABSURD, NOT_NUMBERS, spoil
from support.damages import Random, Scene, damage, light_object


@damage("no camera", "camera", "camera")
def _(scene: Scene, _random: Random) -> None:
    scene.camera = None


@damage("a camera in a mesh", None, "camera")
def _(scene: Scene, _random: Random) -> None:
    scene.camera.location = bpy.data.objects["Sound Cube"].location


@damage("depth of field of absurd measures", None, "camera")
def _(scene: Scene, random: Random) -> None:
    field = scene.camera.data.dof
    field.use_dof = True
    field.aperture_fstop = float(random.choice([0.0, 0.001, 1e-30, 1e30, nan]))
    field.focus_distance = float(random.choice([0.0, 1e-30, 1e30, nan, inf]))
    field.aperture_blades, field.aperture_ratio = int(random.choice([0, 1, 16])), float(random.choice([0.01, 100.0]))
    field.focus_object = [None, scene.camera, bpy.data.objects["Sound Cube"]][int(random.integers(3))]


@damage("a camera shifted away, of an absurd sensor", None, "camera")
def _(scene: Scene, random: Random) -> None:
    camera = scene.camera.data
    camera.shift_x, camera.shift_y = float(random.choice([-1e30, 10.0])), float(random.choice([1e30, nan]))
    camera.sensor_width = float(random.choice([0.0, 1.0, 1e9]))


@damage("a panorama", None, "camera")
def _(scene: Scene, random: Random) -> None:
    camera = scene.camera.data
    camera.type = "PANO"
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles
    kinds = [it.identifier for it in owner.bl_rna.properties["panorama_type"].enum_items]
    owner.panorama_type = str(random.choice(kinds))


@damage("one pixel", None, "frame")
def _(scene: Scene, _random: Random) -> None:
    scene.render.resolution_x = scene.render.resolution_y = 1
    scene.render.resolution_percentage = 1


@damage("an exposure that is not a number, and no known look", None, "frame")
def _(scene: Scene, random: Random) -> None:
    scene.view_settings.exposure = float(random.choice([nan, 32.0, -32.0]))
    scene.view_settings.gamma = float(random.choice([0.0, 5.0]))


@damage("a view layer from which all is excluded", None, "frame")
def _(scene: Scene, random: Random) -> None:
    layer = scene.view_layers.new("Void")
    layer.use = bool(random.integers(2))
    for child in layer.layer_collection.children:
        child.exclude = True
    scene.render.use_single_layer = False


@damage("two eyes", None, "frame")
def _(scene: Scene, random: Random) -> None:
    scene.render.use_multiview = True
    scene.render.image_settings.views_format = "STEREO_3D"  # one file
    scene.camera.data.stereo.interocular_distance = float(random.choice([0.0, 1e30, nan]))
    scene.camera.data.stereo.convergence_distance = float(random.choice([0.00001, 1e30]))


@damage("motion blur of absurd shutters", None, "settings")
def _(scene: Scene, random: Random) -> None:
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = float(random.choice([0.0, 1e30]))
    scene.render.fps, scene.render.fps_base = 1, 1e5


@damage("areas of no size, below zero and beyond measure", None, "light")
def _(_scene: Scene, random: Random) -> None:
    for shape in ("SQUARE", "RECTANGLE", "DISK", "ELLIPSE"):
        data = light_object(f"Area {shape}", "AREA").data
        data.shape = shape
        data.size, data.size_y = (float(random.choice([0.0, 1e-30, -1.0, 1e30])) for _ in range(2))


@damage("an area that is not a number", "Mad Area", "light")
def _(_scene: Scene, random: Random) -> None:
    data = light_object("Mad Area", "AREA").data
    data.energy = float(random.choice(NOT_NUMBERS))
    data.size = float(random.choice([1.0, nan]))


@damage("lights whose radii and angles are not numbers", None, "light")
def _(_scene: Scene, random: Random) -> None:
    light_object("Radius", "POINT").data.shadow_soft_size = float(random.choice([nan, inf, -1.0]))
    light_object("Angle", "SUN").data.angle = float(random.choice([nan, -1.0, 100.0]))
    light_object("Cone", "SPOT").data.spot_size = float(random.choice([nan, 0.0, 100.0]))


@damage("powers at the end of floats", None, "light")
def _(_scene: Scene, random: Random) -> None:
    for kind in ("SUN", "POINT", "SPOT", "AREA"):
        data = light_object(f"End {kind}", kind).data
        data.energy = float(random.choice([3e38, 1e-38, 1e-45]))
        data.color = (float(random.choice([1.0, 1e10])), 0.0, 1.0)


@damage("a lamp of broken nodes", None, "light")
def _(_scene: Scene, random: Random) -> None:
    for index in range(3):
        data = light_object(f"Nodes {index}", str(random.choice(["SUN", "POINT", "SPOT", "AREA"]))).data
        data.use_nodes = True
        tree = data.node_tree
        emission = next((it for it in tree.nodes if it.bl_idname == "ShaderNodeEmission"), None)
        if emission is None or index == 0:
            tree.nodes.clear()
            continue
        if index == 1:
            spoil(emission, random, (*ABSURD, *NOT_NUMBERS))
        texture = tree.nodes.new("ShaderNodeTexImage")
        tree.links.new(texture.outputs[0], emission.inputs[0])


@damage("a world without nodes, or of nothing but an output", None, "world")
def _(scene: Scene, random: Random) -> None:
    tree = scene.world.node_tree
    if random.random() < 0.5:
        tree.links.clear()
    else:
        tree.nodes.clear()
        if random.random() < 0.5:
            tree.nodes.new("ShaderNodeOutputWorld")


@damage("a sky of absurd suns", None, "world")
def _(scene: Scene, random: Random) -> None:
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = str(random.choice([it.identifier for it in sky.bl_rna.properties["sky_type"].enum_items]))
    names = ("sun_elevation", "sun_rotation", "sun_size", "sun_intensity", "altitude", "air_density", "dust_density")
    for name in (*names, "ozone_density", "turbidity", "ground_albedo"):
        if hasattr(sky, name) and random.random() < 0.6:
            setattr(sky, name, float(random.choice([0.0, -1e30, 1e30, nan])))
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])


@damage("a sky of suns that are not numbers", "World", "world")
def _(scene: Scene, random: Random) -> None:
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = str(random.choice([it.identifier for it in sky.bl_rna.properties["sky_type"].enum_items]))
    for name in ("sun_elevation", "altitude", "air_density", "ozone_density", "turbidity", "ground_albedo"):
        if hasattr(sky, name):
            setattr(sky, name, nan)
    if hasattr(sky, "sun_direction"):
        sky.sun_direction = (nan, 0.0, 1.0)
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])


@damage("a world full of fog beyond measure", None, "world fog")
def _(scene: Scene, random: Random) -> None:
    tree = scene.world.node_tree
    shader = tree.nodes.new(str(random.choice(["ShaderNodeVolumeScatter", "ShaderNodeVolumePrincipled"])))
    shader.inputs["Density"].default_value = float(random.choice([0.0, -1.0, 1e-30]))
    shader.inputs["Anisotropy"].default_value = float(random.choice([-1.0, 1.0, 0.0]))
    output = next(it for it in tree.nodes if it.type == "OUTPUT_WORLD")
    tree.links.new(shader.outputs[0], output.inputs["Volume"])
