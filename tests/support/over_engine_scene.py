# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene for the shafts over another engine's picture, and its renders."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from addon import over_engine
from addon.over_engine import compositor, fog

from .exr import read_planes
from .small_scenes import cube, empty_scene, light, material, node, plane

Picture = NDArray[np.float32]
WIDTH_PX, HEIGHT_PX = 32, 18


def hall_in_fog(folder: Path) -> bpy.types.Scene:
    """Cubes on a floor in coloured fog under a sun, against a black sky; Cycles, a ray through each pixel's centre."""
    scene = empty_scene()
    scene.render.resolution_x, scene.render.resolution_y = WIDTH_PX, HEIGHT_PX
    scene.camera.data.type = "PERSP"
    scene.camera.location, scene.camera.rotation_euler = (0, -9, 3), (math.radians(80), 0, 0)
    for index, place in enumerate(((-2, 0, 1), (2.5, 3, 1))):
        surface = (0.7, 0.5 - 0.2 * index, 0.3, 1)
        grey = material(
            "Paint", lambda new, _, colour=surface: node(new, "ShaderNodeBsdfDiffuse", Color=colour).outputs[0]
        )
        cube(f"Cube {index}", grey).location = place
    plane(material=bpy.data.materials["Paint"])
    light("SUN", (0, 0, 5), energy=10.0, angle=0.0).rotation_euler = (0.7, 0.4, 0)
    box = cube(
        "Fog",
        material(
            "Fog",
            volume=lambda new, _: node(
                new, "ShaderNodeVolumeScatter", Color=(0.9, 0.6, 0.3, 1), Density=0.08, Anisotropy=0.2
            ).outputs[0],
        ),
    )
    box.scale, box.location = (12, 12, 4), (0, 0, 3)
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 1, 0.0
    scene.tyndall.shafts.method = "EXACT"
    use_cycles(scene)
    scene.render.filepath = str(folder / "frame.exr")
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode = "OPEN_EXR", "RGBA"
    settings.color_depth, settings.exr_codec = "32", "NONE"
    bpy.context.view_layer.update()
    return scene


def use_cycles(scene: bpy.types.Scene, samples: int = 1) -> None:
    """Direct light alone, through pixel centres where there is one sample, else over the whole pixel."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples = "CPU", samples
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.volume_bounces = 0
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    if samples > 1:
        cycles.pixel_filter_type = "BOX"


def rendered(scene: bpy.types.Scene) -> Picture:
    """F12, and what it writes: (height, width, 4)."""
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return read_planes(Path(scene.render.filepath))[""].copy()


def set_up(scene: bpy.types.Scene) -> None:
    """As an artist does it: two buttons."""
    assert bpy.ops.tyndall.over_engine_set_up() == {"FINISHED"}
    assert bpy.ops.tyndall.leave_fog() == {"FINISHED"}
    assert over_engine.problems(scene) == []


def own_render(scene: bpy.types.Scene) -> Picture:
    """All of it by us: surfaces, fog and shafts."""
    scene.tyndall.over_engine.is_enabled, scene.render.engine = False, "TYNDALL"
    return rendered(scene)


def node_output(scene: bpy.types.Scene, name: str) -> Picture:
    """What an output of our node has, as a render."""
    tree = compositor.tree_of(scene)
    (output,) = compositor.outputs_of(tree)
    before = output.links[0].from_socket
    tree.links.new(compositor.compose_node(scene).outputs[name], output)
    picture = rendered(scene)
    tree.links.new(before, output)
    return picture


def picture_without_fog(scene: bpy.types.Scene) -> Picture:
    """What the scene's engine gives to the compositor: the switch is off, and the fog left out all the same."""
    scene.tyndall.over_engine.is_enabled = False
    for _, left in fog.left_nodes():
        left.mute = False
    picture = rendered(scene)
    scene.tyndall.over_engine.is_enabled = True
    return picture
