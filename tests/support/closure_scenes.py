# SPDX-License-Identifier: GPL-3.0-or-later
"""A faceted ball of one shader under one light, in ours and in Cycles: every angle of view and light at once.

Its facets are flat: neither engine bends normals or lifts rays there.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np

from .engine_pictures import cycles_pixels, tyndall_pixels
from .small_scenes import add, empty_scene, light, material, mesh, node, plane

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .small_scenes import Build

IS_OLD = bpy.app.version < (4, 0, 0)
BLOCK_PX = 4
RINGS, SEGMENTS = 20, 40


def ball(shader: bpy.types.Material, *, is_smooth: bool = False) -> bpy.types.Object:
    corners = [(0.0, 0.0, 1.0)]
    for ring in range(1, RINGS):
        polar = math.pi * ring / RINGS
        for segment in range(SEGMENTS):
            around = 2.0 * math.pi * segment / SEGMENTS
            corners.append((math.sin(polar) * math.cos(around), math.sin(polar) * math.sin(around), math.cos(polar)))
    corners.append((0.0, 0.0, -1.0))
    last = len(corners) - 1
    faces: list[tuple[int, ...]] = []
    for segment in range(SEGMENTS):
        after = (segment + 1) % SEGMENTS
        faces.append((0, 1 + segment, 1 + after))
        for ring in range(RINGS - 2):
            low, high = 1 + ring * SEGMENTS, 1 + (ring + 1) * SEGMENTS
            faces.append((low + segment, high + segment, high + after, low + after))
        faces.append((last, last - SEGMENTS + after, last - SEGMENTS + segment))
    data = mesh("Ball", corners, faces, shader)
    if is_smooth:
        data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
    thing = add("Ball", data)
    thing.rotation_euler = (0.31, 0.23, 0.17)  # no row of pixels lies along edges
    return thing


def scene_of(build: Build, light_it: Callable[[bpy.types.Scene], object], size_px: int = 48) -> bpy.types.Scene:
    scene = empty_scene(size_px)
    scene.camera.data.ortho_scale = 2.1
    ball(material("Shown", build))
    light_it(scene)
    return scene


def pane_scene(build: Build, light_it: Callable[[bpy.types.Scene], object], turn: float = 0.0) -> bpy.types.Scene:
    """A plane of one shader, seen straight; turned by pi, from behind."""
    scene = empty_scene(8)
    plane(0.0, material("Pane", build)).rotation_euler.x = turn
    scene.camera.location.x = 0.3  # not above the diagonal, where Cycles' rays leave through the other triangle
    light_it(scene)
    return scene


def sun(*angles: float, angle: float = 0.0, energy: float = 3.0) -> Callable[[bpy.types.Scene], object]:
    """Tilted from the camera, degrees."""

    def light_it(_scene: bpy.types.Scene) -> None:
        for tilt in angles:
            lamp = light("SUN", (0, 0, 5), energy=energy, angle=math.radians(angle))
            lamp.rotation_euler = (0.0, math.radians(tilt), math.radians(30.0))

    return light_it


def lamp(radius_m: float) -> Callable[[bpy.types.Scene], object]:
    return lambda _scene: light("POINT", (1.5, 1.0, 2.5), energy=300.0, shadow_soft_size=radius_m)


def world(strength: float = 1.0) -> Callable[[bpy.types.Scene], object]:
    def light_it(scene: bpy.types.Scene) -> None:
        background = scene.world.node_tree.nodes["Background"]
        background.inputs["Color"].default_value = (0.9, 0.7, 0.5, 1.0)
        background.inputs["Strength"].default_value = strength
        scene.render.film_transparent = True  # the ball alone

    return light_it


def shader(kind: str, **inputs: object) -> Build:
    """A shader node with these values; `node_` before a name sets a property of the node."""
    properties = {name[5:]: value for name, value in inputs.items() if name.startswith("node_")}
    values = {name: value for name, value in inputs.items() if not name.startswith("node_")}

    def build(new: Callable[[str], bpy.types.Node], _link: object) -> bpy.types.NodeSocket:
        created = node(new, kind, **values)
        for name, value in properties.items():
            setattr(created, name, value)
        return created.outputs[0]

    return build


def errors(ours: NDArray[np.float64], cycles: NDArray[np.float64]) -> tuple[float, float]:
    """Of the picture's mean, and of its median block, in the channel that is worst."""
    height, width, _ = ours.shape

    def blocks(pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        cut = pixels[: height // BLOCK_PX * BLOCK_PX, : width // BLOCK_PX * BLOCK_PX]
        return cut.reshape(height // BLOCK_PX, BLOCK_PX, width // BLOCK_PX, BLOCK_PX, 3).mean(axis=(1, 3))

    mean = np.abs(ours.mean(axis=(0, 1)) / cycles.mean(axis=(0, 1)) - 1.0).max()
    a, b = blocks(ours), blocks(cycles)
    lit = b.min(axis=2) > 0.01 * b.max()
    return float(mean), float(np.median(np.abs(a[lit] / b[lit] - 1.0), axis=0).max())


def assert_like_cycles(scene: bpy.types.Scene, bound: float, samples: int = 1, cycles_samples: int = 2) -> None:
    """``bound``: of the mean and of the median block, both relative."""
    ours, cycles = tyndall_pixels(scene, samples), cycles_pixels(scene, cycles_samples, seed=1)
    mean, median = errors(ours, cycles)
    print(f"mean {mean:.5f}, median block {median:.5f}")
    assert mean <= bound
    assert median <= bound
