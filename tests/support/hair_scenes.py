# SPDX-License-Identifier: GPL-3.0-or-later
"""A patch of hair, and curves that nodes make, in both engines: compared are the mean and blocks of pixels.

The pictures' pixels are box-filtered squares, and hairs are thinner than some.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

from support.cycles_reference import prepare_cycles, rendered_pixels, save_side_by_side
from support.small_scenes import add, empty_scene, material, mesh, node, plane

PICTURES = Path(__file__).parents[2] / "out" / "hair_agreement"
SIZE_PX, BLOCK_PX = 90, 9
SAMPLES = 144


def stage() -> bpy.types.Scene:
    """A hard sun and a camera that looks down on a grey floor."""
    scene = empty_scene(SIZE_PX)
    scene.render.resolution_percentage = 100
    camera = scene.camera
    camera.data.type, camera.data.lens = "PERSP", 90.0
    camera.location = (1.2, -3.2, 2.2)
    camera.rotation_euler = (Vector((0, 0, 0.3)) - Vector(camera.location)).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = math.pi, 0.0
    add("Sun", sun).rotation_euler = (0.6, 0.5, 0.0)
    plane(-0.01, diffuse("Floor", (0.5, 0.5, 0.5, 1)))
    return scene


def diffuse(name: str, color: tuple[float, ...]) -> bpy.types.Material:
    return material(name, lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=color).outputs[0])


def furry(scene: bpy.types.Scene, shape: str) -> bpy.types.Object:
    """A patch with 300 hairs, of a material of their own; thick enough to be told from each other."""
    corners = [(-0.6, -0.6, 0), (0.6, -0.6, 0), (0.6, 0.6, 0), (-0.6, 0.6, 0)]
    patch = add("Patch", mesh("Patch", corners, [(0, 1, 2, 3)], diffuse("Skin", (0.1, 0.3, 0.1, 1))))
    patch.data.materials.append(diffuse("Hair", (0.7, 0.45, 0.2, 1)))
    patch.scale, patch.rotation_euler = (1.0, 1.0, 1.0), (0.0, 0.0, 0.3)
    patch.modifiers.new("Fur", "PARTICLE_SYSTEM")
    settings = patch.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length = "HAIR", 300, 0.7
    settings.factor_random = 0.05  # they stand at an angle each
    settings.brownian_factor = 0.03
    settings.render_step, settings.display_step = 3, 3
    settings.material = 2
    settings.radius_scale, settings.root_radius, settings.tip_radius, settings.shape = 1.0, 0.05, 0.01, 0.2
    scene.cycles_curves.shape = shape
    return patch


def made_by_nodes(data: bpy.types.ID, kinds: list[tuple[str, dict[str, object]]]) -> bpy.types.Object:
    """An object of which geometry nodes, one after another, make what it shows."""
    thing = add("Made", data)
    tree = bpy.data.node_groups.new("Made", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        for way in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    last = tree.nodes.new("NodeGroupInput").outputs[0]
    for kind, inputs in kinds:
        new = tree.nodes.new(kind)
        if hasattr(new, "spline_type"):  # poly curves are another thing in 5.0
            new.spline_type = "CATMULL_ROM"
        for name, value in inputs.items():
            new.inputs[name].default_value = value
        if new.inputs and new.inputs[0].type == "GEOMETRY":
            tree.links.new(last, new.inputs[0])
        last = new.outputs[0]
    tree.links.new(last, tree.nodes.new("NodeGroupOutput").inputs[0])
    thing.modifiers.new("Nodes", "NODES").node_group = tree
    return thing


def both_engines(scene: bpy.types.Scene, samples: int = SAMPLES) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    scene.render.engine, settings = "TYNDALL", scene.tyndall
    settings.pixel_samples, settings.noise_threshold = samples, 0.0
    settings.pixel_filter, settings.filter_width_px = "BOX", 1.0
    ours = rendered_pixels(scene)
    prepare_cycles(scene, samples, seed=1)
    scene.cycles.pixel_filter_type = "BOX"
    return ours, rendered_pixels(scene)


def block_means(picture: NDArray[np.float64], block_px: int = BLOCK_PX) -> NDArray[np.float64]:
    blocks = SIZE_PX // block_px
    return picture.reshape(blocks, block_px, blocks, block_px, 3).mean(axis=(1, 3))


def agree(
    name: str,
    ours: NDArray[np.float64],
    cycles: NDArray[np.float64],
    *,
    block_px: int = BLOCK_PX,
    mean_bound: float = 0.01,
    median_bound: float = 0.01,
    block_bound: float = 0.08,
) -> None:
    save_side_by_side(PICTURES / f"{name}.png", ours, cycles)
    level = float(cycles.mean())
    errors = np.abs(block_means(ours, block_px) - block_means(cycles, block_px)).mean(axis=2)
    mean, median = abs(float(ours.mean()) / level - 1.0), float(np.median(errors)) / level
    print(f"{name}: mean {mean:.3%}, median block {median:.3%}, largest block {errors.max() / level:.3%}")
    assert mean < mean_bound
    assert median < median_bound
    assert errors.max() < block_bound * level
