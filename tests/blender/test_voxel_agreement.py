# SPDX-License-Identifier: GPL-3.0-or-later
"""Are voxels in pictures right? A voxel object looks as its exported box mesh does, in ours and in Cycles.

The pictures' pixels are box-filtered squares; edges of voxels cross most of them. Coloured voxels are told from each
other by the colour attribute that the export writes, which the material of the box reads of either.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from numpy.typing import NDArray

from support.cycles_reference import prepare_cycles, rendered_pixels, save_side_by_side
from support.small_scenes import Node, add, empty_scene, light, material, node, plane
from tyndall.voxel_dag import Config, from_coordinates

PICTURES = Path(__file__).parents[2] / "out" / "voxel_agreement"
SIZE_PX, BLOCK_PX = 72, 9
RESOLUTION = 32
#: Of a pixel's area, in either engine: the noise of an edge through it is half of the contrast over the root of that.
SAMPLES = 256


def torus(*, is_coloured: bool, glows: bool, path: Path) -> None:
    """Of voxels, tilted; coloured by where they are, each differently; a tenth glows, farthest along x."""
    around = (np.indices((RESOLUTION,) * 3).reshape(3, -1).T + 0.5 - RESOLUTION / 2) / (RESOLUTION / 2)
    around = around @ np.array(Matrix.Rotation(0.5, 3, (1.0, 0.3, 0.2)))
    ring = np.hypot(around[:, 0], around[:, 1]) - 0.6
    voxels = np.indices((RESOLUTION,) * 3).reshape(3, -1).T[np.hypot(ring, around[:, 2]) < 0.3]
    colors = (32 + 6 * voxels).astype(np.uint8) if is_coloured else None
    channels = {"emission": np.where(voxels[:, 0] >= 26, 153, 0).astype(np.uint8)} if glows else {}
    bounds = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    config = Config(resolution=RESOLUTION, bounds_m=bounds, colors=colors, channels=channels)
    from_coordinates(voxels, config).save(path)


@pytest.fixture(params=["plain", "coloured"])
def stage(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A voxel object and its box mesh at one place, turned and stretched, over a floor and under a hard sun."""
    scene = empty_scene(SIZE_PX)
    scene.render.resolution_percentage = 100
    camera = scene.camera
    camera.data.type, camera.data.lens = "PERSP", 50.0
    camera.location = (1.5, -4.5, 2.6)
    camera.rotation_euler = (-Vector(camera.location)).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = math.pi, 0.0
    add("Sun", sun).rotation_euler = (0.7, 0.3, 0.0)
    floor = material("Floor", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.6, 0.6, 0.6, 1)).outputs[0])
    plane(-0.9, floor)
    torus(is_coloured=request.param != "plain", glows=request.param == "glowing", path=tmp_path / "torus.tdag")
    assert bpy.ops.tyndall.import_tdag(filepath=str(tmp_path / "torus.tdag")) == {"FINISHED"}
    box = bpy.context.object
    if request.param == "plain":
        clay = material("Clay", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)).outputs[0])
        box.data.materials.append(clay)
    box.rotation_euler, box.scale = (0.2, 0.3, 0.4), (1.0, 0.9, 0.8)
    bpy.context.view_layer.update()
    assert bpy.ops.tyndall.voxels_to_mesh() == {"FINISHED"}
    return box, bpy.context.object


def shown(
    engine: str, thing: bpy.types.Object, *others: bpy.types.Object, samples: int = SAMPLES
) -> NDArray[np.float64]:
    """The one, and not the others; box-filtered."""
    scene = bpy.context.scene
    for one in (thing, *others):
        one.hide_render = one is not thing
    if engine == "CYCLES":
        prepare_cycles(scene, samples, seed=1)
        scene.cycles.pixel_filter_type = "BOX"
    else:
        scene.render.engine, ours = engine, scene.tyndall
        ours.pixel_samples, ours.noise_threshold = samples, 0.0
        ours.pixel_filter, ours.filter_width_px = "BOX", 1.0
    return rendered_pixels(scene)


def block_means(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    blocks = SIZE_PX // BLOCK_PX
    return picture.reshape(blocks, BLOCK_PX, blocks, BLOCK_PX, 3).mean(axis=(1, 3))


@pytest.mark.dealt
def test_voxels_look_as_their_boxes(
    stage: tuple[bpy.types.Object, bpy.types.Object], request: pytest.FixtureRequest
) -> None:
    """In ours sample by sample, but for rays that graze an edge; in Cycles within the noise of its samples."""
    box, boxes = stage
    voxels, mesh = shown("TYNDALL", box, boxes), shown("TYNDALL", boxes, box)
    cycles = shown("CYCLES", boxes, box)
    save_side_by_side(PICTURES / f"{request.node.callspec.id}.png", voxels, cycles)
    level = float(cycles.mean())
    assert float(np.ptp(block_means(voxels).mean(axis=2))) > 0.3 * level
    difference = np.abs(voxels - mesh)
    assert difference.mean() < 1e-4 * level
    assert (difference.max(axis=2) > 0.02 * level).mean() < 0.002
    # A block's noise: 81 pixels of 256 samples, each of an edge between light and shadow at worst: 0.5 / 144 = 0.35 %.
    errors = np.abs(block_means(voxels) - block_means(cycles))
    assert abs(float(voxels.mean() - cycles.mean())) < 0.001 * level
    assert float(np.median(errors)) < 0.002 * level
    assert float(errors.max()) < 0.012 * float(cycles.max())


def _glow(new: Callable[[str], Node], link: Callable[..., object], *, in_stripes: bool) -> bpy.types.NodeSocket:
    color, emission, times = node(new, "ShaderNodeAttribute"), node(new, "ShaderNodeAttribute"), new("ShaderNodeMath")
    color.attribute_name, emission.attribute_name = "Color", "emission"
    times.operation, times.inputs[1].default_value = "MULTIPLY", 50.0
    link(emission.outputs["Fac"], times.inputs[0])
    glow = new("ShaderNodeEmission")
    link(color.outputs["Color"], glow.inputs["Color"])
    link(times.outputs[0], glow.inputs["Strength"])
    if in_stripes:  # finer than voxels, across them
        waves, dimmed = node(new, "ShaderNodeTexWave", Scale=9.0), node(new, "ShaderNodeMath")
        dimmed.operation = "MULTIPLY"
        link(new("ShaderNodeTexCoord").outputs["Object"], waves.inputs["Vector"])
        link(times.outputs[0], dimmed.inputs[0])
        link(waves.outputs["Fac"], dimmed.inputs[1])
        link(dimmed.outputs[0], glow.inputs["Strength"])
    return glow.outputs[0]


# Seen to fail where voxels lit nothing, and where their boxes knew of no emission.
@pytest.mark.dealt
@pytest.mark.parametrize("in_stripes", [False, True])
@pytest.mark.parametrize("stage", ["glowing"], indirect=True)
def test_voxels_that_glow_light_the_floor_and_each_other_as_their_boxes_do(
    stage: tuple[bpy.types.Object, bpy.types.Object], *, in_stripes: bool
) -> None:
    box, boxes = stage
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    glow = material("Glow", partial(_glow, in_stripes=in_stripes))
    for thing in stage:
        thing.data.materials.clear()
        thing.data.materials.append(glow)
    voxels, mesh = (shown("TYNDALL", *pair, samples=100) for pair in (stage, stage[::-1]))
    cycles = shown("CYCLES", boxes, box)
    save_side_by_side(PICTURES / "glow.png", voxels, cycles)
    lit = cycles.max(axis=2) < 0.5 * cycles.max()  # the floor, not what glows
    level = float(cycles[lit].mean())
    assert level > 0.02
    assert float(voxels[lit].mean()) == pytest.approx(level, rel=0.015)
    assert float(voxels[lit].mean()) == pytest.approx(float(mesh[lit].mean()), rel=0.005)
    errors = np.abs(block_means(voxels) - block_means(cycles)).mean(axis=2)
    assert float(np.median(errors)) < 0.01 * level


def test_voxels_with_normals_look_smooth(tmp_path: Path) -> None:
    """As the ball that they were made of, but for its silhouette; their steps cast no shadows on each other."""
    scene = empty_scene(SIZE_PX)
    scene.render.resolution_percentage = 100
    scene.camera.data.ortho_scale = 1.2  # within the ball
    light("SUN", (0, 0, 5), energy=math.pi, angle=0.0).rotation_euler = (0.9, 0.6, 0.0)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48)
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    # What has no material is glossy in 5.0.
    ball.data.materials.append(material("matt", lambda new, _: node(new, "ShaderNodeBsdfDiffuse").outputs[0]))
    before = rendered_pixels(scene)
    settings = scene.tyndall.voxelize
    settings.resolution, settings.has_normals, settings.path = "256", True, str(tmp_path / "ball.tdag")
    ball.select_set(True)
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    after = rendered_pixels(scene)
    level = float(before.mean())
    assert level > 0.2
    assert abs(float(after.mean()) - level) < 0.01 * level
    assert float(np.sqrt(((after - before) ** 2).mean())) < 0.03 * level
