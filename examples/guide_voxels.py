# SPDX-License-Identifier: GPL-3.0-or-later
"""The courtyard of the guide to indirect light: voxels made of arrays, a tree, walls, and a pond that mirrors them."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from guide_edits import compositor
from mathutils import Vector
from numpy.typing import NDArray

from tyndall import voxel_dag

SIDE_M = 0.05  #: Of a voxel.
SIZE = (160, 130, 96)
RED, PLASTER, STONE, TILE = (178, 62, 38), (236, 228, 214), (206, 190, 160), (58, 92, 110)
BARK, BLOSSOM, GREEN, GOLD = (96, 66, 46), (232, 132, 170), (86, 150, 66), (240, 176, 48)
POND = (slice(62, 126), slice(26, 78))


class Blocks:
    """Voxels with colours, as arrays."""

    def __init__(self) -> None:
        self.is_set = np.zeros(SIZE, bool)
        self.colors = np.zeros((*SIZE, 3), np.uint8)
        self.at = np.stack(np.meshgrid(*map(np.arange, SIZE), indexing="ij"), -1)
        self._shades = np.random.default_rng(2).normal(1.0, 0.04, (*SIZE, 1))

    def fill(self, where: NDArray[np.bool_], color: tuple[int, int, int]) -> None:
        """Set voxels in shades of a colour."""
        self.is_set |= where
        self.colors[where] = np.clip(np.array(color) * self._shades[where], 0, 255)

    def clear(self, where: NDArray[np.bool_]) -> None:
        """Take voxels away."""
        self.is_set &= ~where

    def ball(self, centre: tuple[float, float, float], radius: float) -> NDArray[np.bool_]:
        """Voxels in a ball."""
        found: NDArray[np.bool_] = ((self.at - centre) ** 2).sum(-1) < radius**2
        return found


def courtyard() -> voxel_dag.VoxelDag:
    """Terracotta to the left, plaster with two arches behind, stone below, a pond, a tree in blossom, a golden ball."""
    blocks = Blocks()
    x, y, z = np.moveaxis(blocks.at, -1, 0)
    blocks.fill(z < 4, STONE)
    blocks.fill((z < 4) & ((x // 16 + y // 16) % 2 == 0), (190, 172, 140))
    pond = np.zeros(SIZE, bool)
    pond[POND] = True
    blocks.clear(pond & (z >= 1))
    blocks.fill(pond & (z < 1), TILE)
    edge = np.zeros(SIZE, bool)
    edge[POND[0].start - 3 : POND[0].stop + 3, POND[1].start - 3 : POND[1].stop + 3] = True
    blocks.fill(edge & ~pond & (z < 6), PLASTER)
    wall = (x < 7) & (z < 78)
    blocks.fill(wall, RED)
    mortar = (z % 6 == 0) | ((y + 6 * (z // 6 % 2)) % 12 == 0)
    blocks.fill(wall & mortar & (x < 6), (150, 96, 76))
    blocks.clear((x == 6) & mortar & (z < 78) & (z >= 4))
    behind = (y >= 122) & (z < 70)
    blocks.fill(behind, PLASTER)
    blocks.fill((y >= 120) & (z >= 70) & (z < 74), RED)
    for middle in (66, 122):
        opening = (np.abs(x - middle) < 16) & (z >= 4) & (z < 34)
        opening |= ((x - middle) ** 2 + (z - 34) ** 2 < 16**2) & (z >= 34)
        blocks.clear(opening & behind)
    blocks.fill(((x - 34) ** 2 + (y - 84) ** 2 < 16 - (z - 4) / 6) & (z >= 4) & (z < 48), BARK)
    random = np.random.default_rng(7)
    for _ in range(46):
        way = random.normal(0.0, 1.0, 3) * (11.0, 11.0, 7.0)
        leaf = blocks.ball((34 + way[0], 84 + way[1], 58 + way[2]), random.uniform(3.0, 6.5))
        blocks.fill(leaf & (random.random(SIZE) < 0.6), BLOSSOM)
    blocks.fill(blocks.ball((112, 103, 14), 10.5), GOLD)
    for at, height in ((140, 12), (140, 40), (140, 68)):
        blocks.fill((np.abs(x - at) < 6) & (np.abs(y - height) < 6) & (z >= 4) & (z < 12), RED)
        bush = blocks.ball((at, height, 18), 8.5) & (z >= 12)
        blocks.fill(bush & (random.random(SIZE) < 0.8), GREEN)
    return voxel_dag.from_array(blocks.is_set, voxel_size_m=SIDE_M, colors=blocks.colors)


def shader(name: str, kind: str, **inputs: object) -> bpy.types.Material:
    """Of one node; spaces in names of inputs are underscores."""
    material = bpy.data.materials.new(name)
    if not material.use_nodes:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(kind)
    for socket, value in inputs.items():
        shader.inputs[socket.replace("_", " ")].default_value = value
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def add(name: str, data: bpy.types.ID) -> bpy.types.Object:
    """Put data into the scene as an object."""
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def show_courtyard(*, is_lit_by_others: bool) -> None:
    """Build the scene anew, with indirect light or without."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    path = Path(bpy.app.tempdir) / "courtyard.tdag"
    dag = courtyard()
    dag.save(path)
    court = add("Courtyard", bpy.data.meshes.new("Courtyard"))
    court.tyndall_voxels.path = str(path)
    court.data.materials.append(shader("Colours", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)))
    low, high = ((part.start * SIDE_M, part.stop * SIDE_M) for part in POND)
    corners = [(x, y, 3.4 * SIDE_M) for x, y in zip((low[0], low[1], low[1], low[0]), np.repeat(high, 2), strict=True)]
    water = bpy.data.meshes.new("Water")
    water.from_pydata(corners, [], [(0, 1, 2, 3)])
    water.materials.append(
        shader("Water", "ShaderNodeBsdfPrincipled", Base_Color=(0.01, 0.05, 0.06, 1), Roughness=0.0, IOR=1.33)
    )
    add("Water", water)
    ground = bpy.data.meshes.new("Ground")
    ground.from_pydata([(x, y, -0.01) for x, y in ((-60, -60), (60, -60), (60, 60), (-60, 60))], [], [(0, 1, 2, 3)])
    ground.materials.append(shader("Grass", "ShaderNodeBsdfDiffuse", Color=(0.16, 0.2, 0.07, 1)))
    add("Ground", ground)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.color, sun.angle = 5.5, (1.0, 0.86, 0.7), 0.01
    add("Sun", sun).rotation_euler = (math.radians(44), 0, math.radians(62))
    scene.world = bpy.data.worlds.new("Sky")
    if not scene.world.use_nodes:
        scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.32, 0.5, 0.85, 1)
    background.inputs["Strength"].default_value = 0.55
    lens = bpy.data.cameras.new("Camera")
    lens.lens = 28
    scene.camera = add("Camera", lens)
    scene.camera.location = (6.3, -3.3, 2.3)
    towards = Vector((3.5, 4.2, 1.2)) - scene.camera.location
    scene.camera.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 64, 0.01
    scene.view_settings.view_transform = "Filmic" if bpy.app.version < (4, 0, 0) else "AgX"
    indirect = scene.tyndall.indirect
    indirect.has_bounce = indirect.has_mirrors = indirect.has_ambient_occlusion = is_lit_by_others
    indirect.ambient_distance_m = 3.0


def show_ambient_pass() -> None:
    """Show how much of the sky each place of the courtyard sees within a metre, white for all."""
    show_courtyard(is_lit_by_others=False)
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    scene.tyndall.indirect.ambient_distance_m = 1.0
    bpy.context.view_layer.use_pass_ambient_occlusion = True
    (source, output), links = compositor(scene)
    links.new(source.outputs["Ambient Occlusion" if bpy.app.version >= (5, 0, 0) else "AO"], output.inputs[0])
