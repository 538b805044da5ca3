# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog under many lamps, and under an image of the sky: time and noise of default settings, ours and Cycles'.

scripts/python benchmarks/costly_fog_bench.py --context FILE --output FILE. Both engines take the samples that ours has
by default. Times are the process's CPU time of a whole render, what is read and prepared included. Noise: of two
renders that differ in their seed, per pixel, relative to the picture's mean; as the root of its mean square, and as the
median.
Variance times time is one figure of both.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy
import numpy as np
from noise_and_time import both_engines
from numpy.typing import NDArray

from report import Row, run_scenes

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.small_scenes import cube, empty_scene, light, material, node, plane

SIZE_PX = 240, 160
SAMPLES = 16


def _even_fog(new: object, _link: object) -> bpy.types.NodeSocket:
    return node(new, "ShaderNodeVolumeScatter", Density=0.02, Anisotropy=0.2).outputs[0]


def _varying_fog(new: object, link: object) -> bpy.types.NodeSocket:
    """By a noise, with waves of 1.4 m and less."""
    fog = node(new, "ShaderNodeVolumeScatter", Anisotropy=0.2)
    density = node(new, "ShaderNodeMath")
    density.operation = "MULTIPLY"
    density.inputs[1].default_value = 0.04
    noise = node(new, "ShaderNodeTexNoise", Scale=0.7)
    link(node(new, "ShaderNodeTexCoord").outputs["Object"], noise.inputs["Vector"])
    link(noise.outputs[0], density.inputs[0])
    link(density.outputs[0], fog.inputs["Density"])
    return fog.outputs[0]


@dataclass(frozen=True)
class Surroundings:
    """Of 30 posts on a floor."""

    lamps: int = 0  #: 0: a sky.
    fills_world: bool = False  #: Or else a box.
    divisions: int = 0  #: Of the posts' faces, so often.
    fog: Callable[[object, object], bpy.types.NodeSocket] = _even_fog


SCENES = {
    "30 lamps in the world's fog": Surroundings(30, fills_world=True),
    "100 lamps in the world's fog": Surroundings(100, fills_world=True),
    "300 lamps in the world's fog": Surroundings(300, fills_world=True),
    "100 lamps, 370,000 triangles": Surroundings(100, fills_world=True, divisions=5),
    "100 lamps in fog that a noise varies": Surroundings(100, fog=_varying_fog),
    "sky over a box of fog": Surroundings(),
    "sky over a box of fog, 5.9 million triangles": Surroundings(divisions=7),
}


def _posts(random: np.random.Generator, divisions: int) -> None:
    plane(0.0).scale = (40.0, 40.0, 1.0)
    for number in range(30):
        x, y, height = random.uniform((-12.0, -8.0, 0.5), (12.0, 14.0, 3.0))
        post = cube(f"Post {number}")
        post.location, post.scale = (x, y, height), (*random.uniform(0.3, 1.0, 2), height)
        if divisions:
            modifier = post.modifiers.new("Divided", "SUBSURF")
            modifier.levels = modifier.render_levels = divisions
            modifier.subdivision_type = "SIMPLE"


def _lamps(random: np.random.Generator, count: int) -> None:
    for number in range(count):
        x, y, z = random.uniform((-14.0, -9.0, 0.5), (14.0, 16.0, 5.0))
        kind = ("POINT", "SPOT", "AREA")[number % 3]
        light(kind, (x, y, z), energy=float(random.uniform(5.0, 40.0)))


def sky(width: int = 1024) -> NDArray[np.float32]:
    """Bright at the zenith, with a glow and a sun: (height, width, 4), rows from the nadir."""
    up = ((np.arange(width // 2) + 0.5) / (width // 2) - 0.5) * np.pi
    around = (np.arange(width) + 0.5) / width * 2.0 * np.pi
    towards = np.stack(
        np.broadcast_arrays(
            np.cos(up)[:, np.newaxis] * np.cos(around),
            np.cos(up)[:, np.newaxis] * np.sin(around),
            np.sin(up)[:, np.newaxis],
        ),
        axis=-1,
    )
    cosine = towards @ (np.array([0.5, -0.3, 0.5]) / np.linalg.norm([0.5, -0.3, 0.5]))
    level = 0.1 + 0.9 * np.clip(towards[..., 2], 0.0, 1.0) + 20.0 * np.exp(200.0 * (cosine - 1.0))
    level += 3000.0 * (cosine > np.cos(0.012))
    return np.stack([level, 0.95 * level, 0.85 * level, np.ones_like(level)], axis=-1).astype(np.float32)


def build(of: Surroundings) -> bpy.types.Scene:
    """A camera over a floor with posts."""
    scene = empty_scene(SIZE_PX[0])
    scene.render.resolution_x, scene.render.resolution_y = SIZE_PX
    scene.camera.data.type = "PERSP"
    scene.camera.location, scene.camera.rotation_euler = (0.0, -18.0, 4.0), (1.45, 0.0, 0.0)
    random = np.random.default_rng(1)
    _posts(random, of.divisions)
    _lamps(random, of.lamps)
    world = scene.world or bpy.data.worlds.new("World")
    scene.world, world.use_nodes = world, True
    tree = world.node_tree
    output = next(one for one in tree.nodes if one.type == "OUTPUT_WORLD")
    background = next((one for one in tree.nodes if one.type == "BACKGROUND"), None)
    background = background or tree.nodes.new("ShaderNodeBackground")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Strength"].default_value = 0.0 if of.lamps else 1.0
    if not of.lamps:
        pixels = sky()
        image = bpy.data.images.new("Sky", pixels.shape[1], pixels.shape[0], float_buffer=True)
        image.pixels.foreach_set(pixels.ravel())
        image.pack()
        environment = tree.nodes.new("ShaderNodeTexEnvironment")
        environment.image = image
        tree.links.new(environment.outputs[0], background.inputs["Color"])
    if of.fills_world:
        tree.links.new(of.fog(tree.nodes.new, tree.links.new), output.inputs["Volume"])
    else:
        box = cube("Fog", material("Fog", volume=of.fog))
        box.location, box.scale = (0.0, 0.0, 5.0), (40.0, 40.0, 6.0)
    return scene


def run(names: list[str]) -> list[Row]:
    """Measure both engines in all scenes."""
    return both_engines({name: partial(build, SCENES[name]) for name in names or SCENES}, SAMPLES)


if __name__ == "__main__":
    run_scenes(run, __doc__)
