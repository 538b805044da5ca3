# SPDX-License-Identifier: GPL-3.0-or-later
"""The street of the guide to voxels: at dusk, in thin fog, lit by its own voxels, those of lamps and windows."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from guide_voxels import add, shader
from mathutils import Vector

from tyndall import voxel_dag

SIZE, SIDE_M = 160, 0.1
ROAD, LINE, KERB, GRASS = (58, 58, 66), (220, 216, 196), (128, 124, 118), (74, 108, 58)
POST, PANE = (44, 46, 52), (38, 46, 62)
WALLS = ((176, 92, 74), (196, 178, 142), (112, 128, 150), (150, 70, 82), (206, 160, 104))
WARM, LAMP = (255, 186, 98), (255, 206, 140)
MIDDLE = SIZE // 2


class Street:
    """Voxels as arrays: whether they are there, their colours, and how brightly they glow."""

    def __init__(self) -> None:
        self.is_set = np.zeros((SIZE, SIZE, SIZE), bool)
        self.colors = np.zeros((SIZE, SIZE, SIZE, 3), np.uint8)
        self.emission = np.zeros((SIZE, SIZE, SIZE), np.uint8)
        self._random = np.random.default_rng(6)
        self._shades = self._random.normal(1.0, 0.03, (SIZE, SIZE, SIZE, 1))

    def fill(self, where: tuple[slice, slice, slice], color: tuple[int, int, int], emission: int = 0) -> None:
        """Set a box of voxels in shades of a colour."""
        self.is_set[where] = True
        shades = 1.0 if emission else self._shades[where]
        self.colors[where] = np.clip(np.array(color) * shades, 0, 255)
        self.emission[where] = emission

    def house(self, x: int, width: int, y: int, depth: int, height: int, color: tuple[int, int, int]) -> None:
        """A block with panes towards the street, of which a third is lit."""
        self.fill((slice(x, x + width), slice(y, y + depth), slice(1, height)), color)
        front = y + depth - 1 if y < MIDDLE else y
        for left in range(x + 3, x + width - 5, 8):
            for sill in range(6, height - 6, 10):
                is_lit = self._random.random() < 0.33
                pane = (slice(left, left + 4), slice(front, front + 1), slice(sill, sill + 6))
                self.fill(pane, WARM if is_lit else PANE, 26 if is_lit else 0)

    def lamp(self, x: int, y: int) -> None:
        """A post with an arm over the road."""
        way = 1 if y < MIDDLE else -1
        self.fill((slice(x, x + 1), slice(y, y + 1), slice(1, 26)), POST)
        ends = sorted((y, y + 8 * way))
        self.fill((slice(x, x + 1), slice(*ends), slice(26, 27)), POST)
        bulb = sorted((y + 5 * way, y + 8 * way))
        self.fill((slice(x - 1, x + 2), slice(*bulb), slice(25, 26)), LAMP, 255)


def street() -> voxel_dag.VoxelDag:
    """Houses on both sides of a road, and lamps in turns."""
    made = Street()
    everywhere = slice(0, SIZE)
    made.fill((everywhere, everywhere, slice(0, 1)), GRASS)
    made.fill((everywhere, slice(MIDDLE - 26, MIDDLE + 26), slice(0, 1)), KERB)
    made.fill((everywhere, slice(MIDDLE - 16, MIDDLE + 16), slice(0, 1)), ROAD)
    for x in range(0, SIZE, 16):
        made.fill((slice(x, x + 9), slice(MIDDLE - 1, MIDDLE + 1), slice(0, 1)), LINE)
    random = np.random.default_rng(3)
    for side, y in enumerate((MIDDLE - 62, MIDDLE + 30)):
        for number, x in enumerate(range(2, SIZE - 30, 32)):
            height = int(random.integers(36, 110))
            made.house(x, 30, y, 32, height, WALLS[(2 * number + side) % len(WALLS)])
    for number, x in enumerate(range(14, SIZE, 24)):
        made.lamp(x, MIDDLE - 20 if number % 2 == 0 else MIDDLE + 20)
    voxels = np.argwhere(made.is_set)
    there = tuple(voxels.T)
    resolution = 256
    config = voxel_dag.Config(
        resolution=resolution,
        bounds_m=((0, 0, 0), (resolution * SIDE_M,) * 3),
        colors=made.colors[there],
        channels={"emission": made.emission[there]},
    )
    return voxel_dag.from_coordinates(voxels, config)


def _glowing_colours() -> bpy.types.Material:
    """A material that reads what voxels carry."""
    material = shader("Street", "ShaderNodeBsdfDiffuse")
    tree = material.node_tree
    color, emission, watts, glow, both = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "Attribute", "Math", "Emission", "AddShader")
    )
    color.attribute_name, emission.attribute_name = "Color", "emission"
    watts.operation, watts.inputs[1].default_value = "MULTIPLY", 45.0
    matt = next(node for node in tree.nodes if node.type == "BSDF_DIFFUSE")
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(color.outputs["Color"], matt.inputs["Color"])
    tree.links.new(color.outputs["Color"], glow.inputs["Color"])
    tree.links.new(emission.outputs["Fac"], watts.inputs[0])
    tree.links.new(watts.outputs[0], glow.inputs["Strength"])
    tree.links.new(matt.outputs[0], both.inputs[0])
    tree.links.new(glow.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    return material


def _fog(size_m: float, height_m: float) -> None:
    box = bpy.data.meshes.new("Fog")
    corners = [(x, y, z) for z in (0.05, height_m) for y in (0.0, size_m) for x in (0.0, size_m)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    box.from_pydata(corners, [], faces)
    material = shader("Fog", "ShaderNodeVolumeScatter", Color=(1, 1, 1, 1), Density=0.035, Anisotropy=0.35)
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    link = output.inputs["Surface"].links[0]
    tree.links.new(link.from_socket, output.inputs["Volume"])
    tree.links.remove(link)
    box.materials.append(material)
    add("Fog", box)


def show_street() -> None:
    """Build the scene anew."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    path = Path(bpy.app.tempdir) / "street.tdag"
    street().save(path)
    voxels = add("Street", bpy.data.meshes.new("Street"))
    voxels.tyndall_voxels.path = str(path)
    voxels.data.materials.append(_glowing_colours())
    _fog(SIZE * SIDE_M, 6.0)
    scene.world = bpy.data.worlds.new("Dusk")
    if not scene.world.use_nodes:
        scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.035, 0.06, 0.14, 1)
    lens = bpy.data.cameras.new("Camera")
    lens.lens = 26
    scene.camera = add("Camera", lens)
    scene.camera.location = (0.5, 7.2, 1.6)
    towards = Vector((12.0, 8.6, 2.3)) - scene.camera.location
    scene.camera.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 64, 0.015
    scene.tyndall.indirect.has_bounce = True
    scene.view_settings.view_transform = "Filmic" if bpy.app.version < (4, 0, 0) else "AgX"
    scene.view_settings.exposure = 1.5
