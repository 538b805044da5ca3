# SPDX-License-Identifier: GPL-3.0-or-later
"""A sea turtle over a reef, the sun above it: holes between its fins are filled, and functions lift its shadow.

After figure 5.16 of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/turtle.py``; writes turtle.blend beside itself.
"""

from __future__ import annotations

import sys
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
from nature_kit import bare_tree, blades, boulder, ground, hills, limb, spaced
from scene_kit import (
    Rgb,
    Shape,
    camera,
    clear_file,
    diffuse,
    edit_occluders,
    fog_box,
    instance,
    link,
    placed,
    save,
    set_up,
    shared_collection,
    sun,
    towards,
    world,
)

EYE = (0.0, -5.2, 1.1)
TURTLE = (-0.15, -2.3, 2.8)
SUN = (4.0, 38.0)  #: Right of straight ahead and up, in degrees.
FISH_COUNT = 70


def heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the sea floor: sand between rising reefs."""
    reef = np.clip((np.abs(x - 0.12 * y) - 2.6) / 7.0, 0.0, 1.0) ** 1.2
    ripples = 0.02 * np.sin(9.0 * y + 2.0 * np.sin(1.3 * x) + 3.0 * hills(x / 2, y / 2, 8, 2))
    return 2.6 * reef * (0.8 + 0.5 * hills(x / 4, y / 4, 12, 4)) + 0.06 * (y + 5.0) + ripples


def height_at(x: float, y: float) -> float:
    """Of the sea floor."""
    return float(heights(np.array(x), np.array(y)))


def flipper(shape: Shape, root: Vector, spine: list[Vector], widths: list[float], slot: int) -> None:
    """A flat fin along a line from its root; the wide side lies across the line, level with the body."""
    points = [root, *spine]
    rows = []
    for index, (at, wide) in enumerate(zip(points, widths, strict=True)):
        ahead = (points[min(index + 1, len(points) - 1)] - points[max(index - 1, 0)]).normalized()
        across = ahead.cross(Vector((0, 0, 1))).normalized()
        thick = Vector((0, 0, 0.035 * (1 - index / len(points)) + 0.006))
        rows += [at + across * wide, at + thick, at - across * wide, at - thick]
    faces = [
        (row * 4 + side, row * 4 + (side + 1) % 4, row * 4 + 4 + (side + 1) % 4, row * 4 + 4 + side)
        for row in range(len(points) - 1)
        for side in range(4)
    ]
    last = 4 * (len(points) - 1)
    shape.add(rows, [*faces, (0, 1, 2, 3), (last + 3, last + 2, last + 1, last)], slot)


def turtle() -> bpy.types.Object:
    """A green turtle, 1.3 m from nose to tail, that swims along +X."""
    shell, skin, belly = range(3)
    shape = Shape()
    sides, rings = 40, 12
    dome = []
    for ring in range(rings + 1):
        lift = (pi / 2) * ring / rings
        for side in range(sides):
            way = 2 * pi * side / sides
            narrow = 0.40 * (1.0 - 0.16 * cos(way)) * (1 + 0.02 * cos(11 * way))
            seam = 1.0 - 0.03 * (cos(10 * way) ** 12 + (ring in (4, 8)))
            dome.append(
                (0.55 * cos(way) * cos(lift) * seam, narrow * sin(way) * cos(lift) * seam, 0.24 * sin(lift) * seam)
            )
    faces = [
        (r * sides + s, r * sides + (s + 1) % sides, (r + 1) * sides + (s + 1) % sides, (r + 1) * sides + s)
        for r in range(rings)
        for s in range(sides)
    ]
    shape.add(dome, faces, shell)
    shape.ball((0.0, 0, 0.01), (0.53, 0.38, 0.11), belly, 24)
    limb(shape, [(0.45, 0, 0.03), (0.6, 0, 0.05), (0.7, 0.02, 0.07)], [0.13, 0.10, 0.09], 14, skin)
    shape.ball((0.76, 0.03, 0.08), (0.135, 0.095, 0.09), skin, 16)
    shape.ball((0.87, 0.04, 0.065), (0.05, 0.05, 0.045), skin, 12)
    limb(shape, [(-0.5, 0, 0.0), (-0.62, 0, -0.01), (-0.70, 0, -0.01)], [0.06, 0.035, 0.008], 8, skin)
    for hand in (-1, 1):
        lift = 0.16 if hand > 0 else -0.08
        flipper(
            shape,
            Vector((0.36, 0.22 * hand, 0.02)),
            [
                Vector(at)
                for at in (
                    (0.50, 0.42 * hand, 0.02 + 0.3 * lift),
                    (0.50, 0.66 * hand, 0.7 * lift),
                    (0.36, 0.86 * hand, lift),
                    (0.17, 1.0 * hand, 1.3 * lift),
                    (0.02, 1.06 * hand, 1.5 * lift),
                )
            ],
            [0.10, 0.125, 0.12, 0.10, 0.065, 0.015],
            skin,
        )
        flipper(
            shape,
            Vector((-0.38, 0.20 * hand, 0.0)),
            [
                Vector(at)
                for at in (
                    (-0.52, 0.28 * hand, -0.01),
                    (-0.68, 0.33 * hand, -0.03),
                    (-0.83, 0.31 * hand, -0.05),
                    (-0.92, 0.26 * hand, -0.06),
                )
            ],
            [0.07, 0.10, 0.13, 0.10, 0.02],
            skin,
        )
    made = shape.mesh(
        "Turtle",
        diffuse("Shell", (0.20, 0.14, 0.06)),
        diffuse("Skin", (0.30, 0.32, 0.22)),
        diffuse("Plastron", (0.55, 0.50, 0.32)),
        smooth=True,
    )
    return link("Turtle", made)


def fish(silver: bpy.types.Material) -> bpy.types.Mesh:
    """0.2 m, along +X."""
    shape = Shape().ball((0, 0, 0), (0.10, 0.022, 0.04), 0, 12)
    shape.add([(-0.08, 0, 0), (-0.15, 0, 0.05), (-0.13, 0, 0), (-0.15, 0, -0.05)], [(0, 1, 2), (0, 2, 3)])
    shape.add([(0.03, 0, 0.035), (-0.05, 0, 0.065), (-0.05, 0, 0.025)], [(0, 1, 2)])
    return shape.mesh("Fish", silver, smooth=True)


def fan(random: np.random.Generator) -> Shape:
    """A sea fan: a lattice of thin limbs in one plane."""
    shape = Shape()

    def grow(at: Vector, way: float, length: float, level: int) -> None:
        end = at + Vector((sin(way), 0.12 * random.normal() * length, cos(way))) * length
        limb(shape, [at, end], [0.016 - 0.0018 * level, 0.014 - 0.0018 * level], 4)
        if level < 6:
            for turn in (-0.42, 0.38):
                grow(end, way * 0.92 + turn * random.uniform(0.6, 1.2), length * random.uniform(0.74, 0.94), level + 1)

    grow(Vector((0, 0, -0.05)), 0.0, 0.24, 0)
    return shape


def sponge(random: np.random.Generator) -> Shape:
    """A family of open tubes."""
    shape = Shape()
    for _ in range(6):
        tall, wide = random.uniform(0.35, 0.9), random.uniform(0.05, 0.09)
        lean = placed(
            (random.normal() * 0.14, random.normal() * 0.14, 0), (random.normal() * 11, random.normal() * 11, 0)
        )
        shape.lathe(
            [
                (wide * 0.6, -0.05),
                (wide, tall * 0.4),
                (wide * 1.2, tall),
                (wide * 1.0, tall * 1.01),
                (wide * 0.8, tall * 0.5),
            ],
            12,
            0,
            lean,
        )
    return shape


def build_reef(random: np.random.Generator) -> None:
    """Boulders, antlers, fans, sponges and weed on the reefs on both sides; sand in the middle."""
    colours: dict[str, Rgb] = {
        "Rock": (0.20, 0.19, 0.18),
        "Antler": (0.55, 0.33, 0.18),
        "Fan": (0.50, 0.10, 0.25),
        "Sponge": (0.55, 0.42, 0.10),
        "Weed": (0.14, 0.25, 0.10),
    }
    makers = {
        "Rock": lambda: boulder(random), "Antler": lambda: bare_tree(random, 1.1, 0.05), "Fan": lambda: fan(random),
        "Sponge": lambda: sponge(random), "Weed": lambda: blades(random, 40, 0.12, 0.8, 0.5, 0.03),
    }  # fmt: skip
    kinds: dict[str, list[bpy.types.Collection]] = {}
    for name, make in makers.items():
        material = diffuse(name, colours[name])
        kinds[name] = []
        for index in range(2):
            collection = shared_collection(f"{name} {index}")
            link(
                f"{name} {index}",
                make().mesh(f"{name} {index}", material, smooth=name in ("Rock", "Sponge")),
                collection,
            )
            kinds[name].append(collection)
    names = list(kinds)
    for _ in range(420):
        y = -4.4 + 17.0 * random.random() ** 1.4
        x = random.uniform(-1, 1) * (2.6 + 0.75 * (y - EYE[1]))
        if abs(x - 0.12 * y) < 2.0 + 0.4 * random.random() or np.hypot(x - EYE[0], y - EYE[1]) < 1.5:
            continue
        name = names[int(random.choice(5, p=(0.26, 0.24, 0.16, 0.16, 0.18)))]
        size = random.uniform(0.5, 1.15) * (0.55 if name == "Rock" else 0.9)
        turn = (
            (0, 0, random.uniform(-60, 60))
            if name == "Fan"
            else (random.normal() * 9, random.normal() * 9, random.uniform(0, 360))
        )
        instance(kinds[name][int(random.integers(2))], placed((x, y, height_at(x, y) - 0.03), turn, (size,) * 3))


def lift_shadow(
    name: str, layers: tuple[tuple[str, dict[str, object], tuple[tuple[float, tuple[float, ...]], ...]], ...]
) -> None:
    """Make the next state: a function that multiplies the shafts, of gradients with these ramps."""
    scene = bpy.context.scene
    shafts = scene.tyndall.shafts
    bpy.ops.tyndall.transfer_state_add()
    bpy.ops.tyndall.transfer_function_new()
    tree = shafts.transfer_states[shafts.active_transfer_state].function
    tree.name, tree.tyndall.use = name, "MULTIPLY"
    for mode, settings, stops in layers:
        bpy.ops.tyndall.transfer_layer_add(kind="GRADIENT")
        layer = tree.tyndall.layers[-1]
        layer.blend_mode = mode
        for key, value in settings.items():
            setattr(layer, key, value)
        ramp = tree.nodes[layer.ramp_node].color_ramp
        while len(ramp.elements) < len(stops):
            ramp.elements.new(1.0)
        for element, (position, colour) in zip(ramp.elements, stops, strict=True):
            element.position, element.color = position, colour


def build() -> None:
    """Put the scene together."""
    clear_file()
    random = np.random.default_rng(3)
    x, y = spaced(-18.0, 18.0, 0.0, 0.08, 0.02), spaced(-6.5, 18.0, -4.0, 0.06, 0.02)
    ground("Sea Floor", x, y, heights(*np.meshgrid(x, y)), diffuse("Sand", (0.50, 0.46, 0.36)))
    build_reef(random)
    swimmer = turtle()
    swimmer.matrix_world = placed(TURTLE, (22, -10, 155), (1.25,) * 3)
    school = fish(diffuse("Silver", (0.45, 0.48, 0.50)))
    for _ in range(FISH_COUNT):
        at = Vector((2.6, 0.2, 3.0)) + Vector(random.normal(size=3) * (0.9, 1.0, 0.45))
        link(
            "Fish",
            school,
            place=placed(at, (0, random.normal() * 8, 200 + random.normal() * 12), (random.uniform(0.8, 1.3),) * 3),
        )
    star = sun("Sun", tuple(towards(*SUN)), 5.0, (0.30, 0.78, 1.0), 0.25)
    edit_occluders(star, "CLOSE", size_m=0.7, target="OBJECT", target_object=swimmer)
    fill = sun("Water", tuple(towards(170.0, 20.0)), 0.5, (0.30, 0.75, 1.0), 60.0)
    fill.data.tyndall.scatters_in_media = False
    world((0.01, 0.16, 0.36), 0.3)
    fog_box((-17.5, -6.4, -1.0), (17.5, 4.0, 6.5), 0.10, (0.80, 0.97, 1.0), 0.6)
    camera(EYE, (0.15, 0.0, 3.75), 20.0)
    lift = ("MIX", {}, ((0.0, (2.6, 2.4, 2.2, 1.0)), (0.7, (1.4, 1.35, 1.3, 1.0)), (1.0, (1.0, 1.0, 1.0, 1.0))))
    near = (
        "MULTIPLY",
        {"shape": "RADIAL", "start": (0.0, 0.0), "end": (0.45, 0.0)},
        ((0.0, (5.0, 4.6, 4.2, 1.0)), (1.0, (1.0, 1.0, 1.0, 1.0))),
    )
    lift_shadow("Lifted Shadow", (lift,))
    lift_shadow("Clear Body", (lift, near))
    scene = bpy.context.scene
    scene.tyndall.shafts.transfer_state = 1.0
    scene.tyndall.shafts.resolution = 4096
    set_up(view="Filmic", look="High Contrast", exposure=0.0)


if __name__ == "__main__":
    build()
    save(__file__)
