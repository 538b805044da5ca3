# SPDX-License-Identifier: GPL-3.0-or-later
"""Directly lit surfaces without a medium equal Cycles' without bounces, to Cycles' own noise.

Cycles renders each scene with two seeds: their difference is its noise, pixel by pixel. Means over blocks of 9 x 9
pixels must agree within 0.2 % plus 3 sigma.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon.shader_nodes import use_nodes
from support.new_file import new_file
from support.small_scenes import block_shadow_rays

SIZE_PX = 36
BLOCK_PX = 9


def render(scene: bpy.types.Scene, folder: Path, engine: str, seed: int = 0) -> NDArray[np.float32]:
    """Combined, (height, width, 3), rows bottom to top."""
    scene.render.engine = engine
    scene.cycles.seed = seed
    scene.render.filepath = str(folder / f"{engine}{seed}.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.empty(SIZE_PX * SIZE_PX * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(SIZE_PX, SIZE_PX, 4)[..., :3]


def block_means(pixels: NDArray[np.floating]) -> NDArray[np.float64]:
    count = SIZE_PX // BLOCK_PX
    return pixels.astype(np.float64).reshape(count, BLOCK_PX, count, BLOCK_PX, 3).mean(axis=(1, 3))


@pytest.fixture
def stage() -> bpy.types.Scene:
    """A white floor under a camera, black world, and settings under which both engines compute the same."""
    scene = new_file(is_empty=True)
    render = scene.render
    render.resolution_x = render.resolution_y = SIZE_PX
    render.resolution_percentage = 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    cycles = scene.cycles
    cycles.samples = 256
    cycles.max_bounces = cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 128
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.light_sampling_threshold = 0
    # Pixel centres, nearly: Blender fixes the box filter's width to one pixel, the others obey theirs.
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 64, 0.0
    scene.tyndall.pixel_filter, scene.tyndall.filter_width_px = "BLACKMAN_HARRIS", 0.01
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -6, 2.5), (1.2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("World")
    use_nodes(scene.world)
    set_world_strength(scene, 0)
    bpy.ops.mesh.primitive_plane_add(size=12)
    bpy.context.object.data.materials.append(diffuse_material("Floor", (0.8, 0.8, 0.8, 1)))
    return scene


def diffuse_material(name: str, colour: tuple[float, float, float, float]) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    tree = use_nodes(material)
    tree.nodes.clear()
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = colour
    tree.links.new(diffuse.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def set_world_strength(scene: bpy.types.Scene, strength: float) -> None:
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.5, 0.7, 1, 1)
    background.inputs["Strength"].default_value = strength


def add_light(kind: str, **settings: float) -> bpy.types.Object:
    data = bpy.data.lights.new("Light", kind)
    for name, value in settings.items():
        setattr(data, name, value)
    thing = bpy.data.objects.new("Light", data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_ball(segments: int, *, is_smooth: bool = True) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=segments // 2, location=(0, 0, 1))
    ball = bpy.context.object
    if is_smooth:
        bpy.ops.object.shade_smooth()
    ball.data.materials.append(diffuse_material("Diffuse", (0.8, 0.3, 0.2, 1)))
    return ball


def sun_on_a_coarse_smooth_ball(_scene: bpy.types.Scene) -> None:
    """Ten segments: the shadow terminator, where shading and geometry disagree most."""
    add_ball(10)
    add_light("SUN", energy=3, angle=0).rotation_euler = (1.1, 0.3, 0)


def sun_on_a_squashed_cylinder(_scene: bpy.types.Scene) -> None:
    """Seen to fail (by 1.8 % of the mean in a block) where it bulged as it does without its scale."""
    bpy.ops.mesh.primitive_cylinder_add(location=(0, 0, 0.6))
    cylinder = bpy.context.object
    bpy.ops.object.shade_smooth()
    cylinder.scale, cylinder.rotation_euler = (1.6, 1.1, 0.35), (0.3, 0.0, 0.4)
    cylinder.data.materials.append(diffuse_material("Diffuse", (0.8, 0.3, 0.2, 1)))
    add_light("SUN", energy=3, angle=0).rotation_euler = (-0.9, 0.3, 0)


def sun_on_a_flat_ball(_scene: bpy.types.Scene) -> None:
    add_ball(24, is_smooth=False)
    add_light("SUN", energy=3, angle=0).rotation_euler = (0.8, 0.3, 0)


def wide_sun(_scene: bpy.types.Scene) -> None:
    add_ball(24)
    add_light("SUN", energy=3, angle=math.radians(15)).rotation_euler = (0.8, 0.3, 0)


def point(_scene: bpy.types.Scene) -> None:
    add_ball(24)
    add_light("POINT", energy=300, shadow_soft_size=0).location = (1.5, -1, 3)


def point_with_a_radius(_scene: bpy.types.Scene) -> None:
    add_ball(24)
    add_light("POINT", energy=300, shadow_soft_size=0.4).location = (1.5, -1, 3)


def blended_spot_with_a_scale(_scene: bpy.types.Scene) -> None:
    add_ball(24)
    spot = add_light("SPOT", energy=300, shadow_soft_size=0, spot_size=0.8, spot_blend=0.3)
    spot.location, spot.rotation_euler, spot.scale = (1.5, -1, 4), (0.3, 0.3, 0), (1, 1.6, 1)


def bright_world(scene: bpy.types.Scene) -> None:
    add_ball(24)
    set_world_strength(scene, 1)


def alpha_texture(_scene: bpy.types.Scene) -> None:
    """Holes of an image's alpha are seen through, and light falls through them."""
    ball = add_ball(24)
    tree = ball.data.materials[0].node_tree
    image = bpy.data.images.new("Holes", 16, 16, alpha=True)
    pixels = np.random.default_rng(1).random((16, 16, 4), dtype=np.float32)
    pixels[..., 3] = pixels[..., 3] > 0.4
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    transparent, mix = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
    diffuse, output = tree.nodes["Diffuse BSDF"], tree.nodes["Material Output"]
    tree.links.new(texture.outputs["Color"], diffuse.inputs["Color"])
    tree.links.new(texture.outputs["Alpha"], mix.inputs["Fac"])
    tree.links.new(transparent.outputs[0], mix.inputs[1])
    tree.links.new(diffuse.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    add_light("SUN", energy=3, angle=0).rotation_euler = (0.8, 0.3, 0)


def pane_whose_shadow_is_opaque(_scene: bpy.types.Scene) -> None:
    """Of the material's switch, the other way than by default: two thirds of what the camera sees pass."""
    bpy.ops.mesh.primitive_plane_add(size=1.9, location=(0.23, 0.04, 1.17), rotation=(0.47, 0.21, 0.1))
    pane = diffuse_material("Pane", (0.8, 0.5, 0.3, 1))
    nodes, links = pane.node_tree.nodes, pane.node_tree.links
    mix = nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = 2.0 / 3.0
    diffuse = next(node for node in nodes if node.type == "BSDF_DIFFUSE")
    links.new(diffuse.outputs[0], mix.inputs[1])
    links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"])
    block_shadow_rays(pane)
    bpy.context.object.data.materials.append(pane)
    add_light("POINT", energy=300, shadow_soft_size=0).location = (0.4, -0.3, 3)


def glow_below_a_coat(_scene: bpy.types.Scene) -> None:
    """What it sends to the floor. Seen to fail where it sent nothing, and where the coat dimmed that."""
    ball = add_ball(24)
    glowing = bpy.data.materials.new("Glowing")
    inputs = use_nodes(glowing).nodes["Principled BSDF"].inputs
    is_4 = bpy.app.version >= (4, 0, 0)
    inputs["Coat Weight" if is_4 else "Clearcoat"].default_value = 0.8
    inputs["Emission Color" if is_4 else "Emission"].default_value = (1.0, 0.4, 0.2, 1.0)
    inputs["Emission Strength"].default_value = 2.0
    ball.data.materials[0] = glowing
    ball.visible_camera = False


@pytest.mark.dealt
@pytest.mark.parametrize(
    "build",
    [
        glow_below_a_coat,
        pane_whose_shadow_is_opaque,
        sun_on_a_coarse_smooth_ball,
        sun_on_a_squashed_cylinder,
        sun_on_a_flat_ball,
        wide_sun,
        point,
        point_with_a_radius,
        blended_spot_with_a_scale,
        bright_world,
        alpha_texture,
    ],
    ids=lambda build: build.__name__,
)
def test_lit_surfaces_equal_cycles(
    stage: bpy.types.Scene, tmp_path: Path, build: Callable[[bpy.types.Scene], None]
) -> None:
    build(stage)
    is_noisy = build in {glow_below_a_coat, wide_sun, point_with_a_radius, bright_world, alpha_texture}
    stage.tyndall.pixel_samples = 1024 if is_noisy else 64
    stage.tyndall.noise_threshold = 0.0  # as an estimate without bias
    first, second = (render(stage, tmp_path, "CYCLES", seed) for seed in (1, 2))
    truth = block_means((first + second) / 2)
    ours = render(stage, tmp_path, "TYNDALL")
    # Each pixel's difference of two seeds estimates the variance of their mean; a block's mean has 81 of them.
    sigma = np.sqrt(block_means((first - second) ** 2 / 4)) / BLOCK_PX
    if is_noisy:
        sigma *= math.hypot(1.0, math.sqrt(2 * 256 / 1024))  # ours has as many samples, and noise like Cycles'
    error = np.abs(block_means(ours) - truth)
    # Channels of a block share their samples: it strays as one. Of 16 blocks, two beyond 3 sigma are one in 1,000.
    tolerance = 0.002 * truth
    if bpy.app.version < (4, 0, 0):
        # The terminator of 3.4's Cycles lies elsewhere on coarse meshes: 0.54 and 1.04 % of the mean in one block.
        elsewhere = {sun_on_a_coarse_smooth_ball: 0.006, sun_on_a_squashed_cylinder: 0.012}
        tolerance += elsewhere.get(build, 0.0) * truth.mean()
    stray = (error > tolerance + 3 * sigma).any(axis=-1)
    assert stray.sum() <= 1, error.max() / truth.mean()
    assert (error <= tolerance + 6 * sigma).all(), error.max() / truth.mean()
    assert truth.mean() > 0.01  # the scene is not dark
