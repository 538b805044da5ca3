# SPDX-License-Identifier: GPL-3.0-or-later
"""A plane and a ball under a world of nodes, and the world behind them."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
from numpy.typing import NDArray

from .closure_scenes import ball
from .small_scenes import empty_scene, material, node, plane

FloatArray = NDArray[np.float64]
WorldTree = Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]

IS_5 = bpy.app.version >= (5, 0, 0)
MODELS = ["SINGLE_SCATTERING", "MULTIPLE_SCATTERING"] if IS_5 else ["NISHITA"]
BLOCK_PX = 4


def sky(model: str, elevation_deg: float, **properties: object) -> WorldTree:
    def build(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        created = tree.nodes.new("ShaderNodeTexSky")
        created.sky_type = model
        if model in MODELS:
            created.sun_elevation, created.sun_rotation = math.radians(elevation_deg), 0.7
        else:
            elevation, azimuth = math.radians(elevation_deg), 0.7
            created.sun_direction = (
                math.cos(elevation) * math.sin(azimuth),
                math.cos(elevation) * math.cos(azimuth),
                math.sin(elevation),
            )
        for name, value in properties.items():
            setattr(created, name, value)
        return created.outputs[0]

    return build


def under(build: WorldTree, strength: float = 1.0, size_px: int = 48, *, has_things: bool = True) -> bpy.types.Scene:
    """Seen from above the horizon, the sun's azimuth a little beside the middle."""
    scene = empty_scene(size_px)
    tree = scene.world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = strength
    tree.links.new(build(tree), background.inputs["Color"])
    if has_things:
        grey = material("Grey", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs[0])
        plane(-1.0, grey, half_side=3.0)
        ball(grey)
    camera = scene.camera
    camera.data.type, camera.data.angle = "PERSP", math.radians(75.0)
    camera.location, camera.rotation_euler = (-1.5, -4.0, 0.4), (math.radians(95.0), 0.0, -0.4)
    return scene


def errors(ours: FloatArray, cycles: FloatArray) -> tuple[float, float]:
    """Of the mean, and of the median block, of the channel that is worst."""
    height, width, _ = ours.shape

    def blocks(pixels: FloatArray) -> FloatArray:
        return pixels.reshape(height // BLOCK_PX, BLOCK_PX, width // BLOCK_PX, BLOCK_PX, 3).mean(axis=(1, 3))

    mean = np.abs(ours.mean(axis=(0, 1)) / cycles.mean(axis=(0, 1)) - 1.0).max()
    a, b = blocks(ours), blocks(cycles)
    lit = b.min(axis=2) > 1e-3 * b.max()
    return float(mean), float(np.median(np.abs(a[lit] / b[lit] - 1.0), axis=0).max())
