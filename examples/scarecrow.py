# SPDX-License-Identifier: GPL-3.0-or-later
"""A scarecrow in the wheat before a setting sun, and its crows: silhouettes drawn out make its shadow reach for you.

After figure 5.13, middle, of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/scarecrow.py``; writes scarecrow.blend beside itself.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
from nature_kit import bare_tree, blades, ground, hills, limb, spaced
from scene_kit import (
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

EYE = (0.5, -5.2, 1.15)
FIGURE = (-0.35, 0.0)
SUN = (-7.3, 13.9)  #: Right of straight ahead and up, in degrees.


def heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the field, and of the hills that it ends in."""
    away = np.clip((y - 25.0) / 60.0, 0.0, 1.0)
    return 0.12 * hills(x / 6, y / 6, 2, 3) + 9.0 * away**1.5 * (0.45 + 0.5 * hills(x / 55, y / 55, 9, 3))


def height_at(x: float, y: float) -> float:
    """Of the field."""
    return float(heights(np.array(x), np.array(y)))


def tatters(shape: Shape, random: np.random.Generator, along: list[Vector], drop: float, slot: int) -> None:
    """Rags that hang from a line."""
    for a, b in pairwise(along):
        fall = drop * random.uniform(0.35, 1.25)
        sway = Vector((random.normal() * 0.05, random.normal() * 0.04, 0))
        tip = a.lerp(b, random.uniform(0.2, 0.8)) + Vector((0, 0, -fall)) + sway
        low_a, low_b = a.lerp(tip, 0.45) + (a - b) * 0.05, b.lerp(tip, 0.4)
        shape.add([a, b, low_b, low_a, tip], [(0, 1, 2, 3), (3, 2, 4)], slot)


def straw(shape: Shape, random: np.random.Generator, root: Vector, heading: Vector, count: int, slot: int) -> None:
    """A bundle that sticks out."""
    for _ in range(count):
        axis = (heading.normalized() + Vector(random.normal(size=3)) * 0.28).normalized()
        limb(shape, [root, root + axis * random.uniform(0.12, 0.3)], [0.006, 0.003], 4, slot)


def scarecrow(random: np.random.Generator) -> bpy.types.Object:
    """A coat and a hat on two poles, straw in them, 2.7 m high."""
    wood, coat, sack, hat, hay = range(5)
    shape = Shape()
    limb(shape, [(0, 0, -0.3), (0.02, 0, 1.2), (0, 0, 2.25)], [0.045, 0.042, 0.035], 8, wood)
    limb(shape, [(-1.12, 0.03, 1.80), (0, 0, 1.9), (1.08, -0.02, 1.93)], [0.032, 0.035, 0.03], 8, wood)
    sides = 28
    rings = (
        (1.98, 0.13, 0.10),
        (1.93, 0.25, 0.13),
        (1.72, 0.27, 0.16),
        (1.45, 0.25, 0.15),
        (1.15, 0.30, 0.19),
        (0.85, 0.37, 0.25),
    )
    points = [
        Vector((wide * cos(2 * pi * i / sides) * (1 + 0.06 * sin(5 * i)), deep * sin(2 * pi * i / sides), height))
        for height, wide, deep in rings
        for i in range(sides)
    ]
    faces = [
        (r * sides + i, r * sides + (i + 1) % sides, (r + 1) * sides + (i + 1) % sides, (r + 1) * sides + i)
        for r in range(len(rings) - 1)
        for i in range(sides)
    ]
    shape.add(points, faces, coat)
    hem = [*points[-sides:], points[-sides]]
    tatters(shape, random, hem, 0.42, coat)
    for hand in (-1, 1):
        tilt = 0.03 * hand
        shoulder, wrist = Vector((0.2 * hand, 0, 1.86)), Vector((0.92 * hand, 0, 1.84 + tilt))
        line = [shoulder.lerp(wrist, t) + Vector((0, 0, -0.04 * sin(pi * t))) for t in np.linspace(0, 1, 7)]
        limb(shape, line, [0.14, 0.13, 0.12, 0.115, 0.11, 0.115, 0.13], 14, coat)
        below = [point + Vector((0, 0.02, -0.09)) for point in line[1:]]
        fine = [below[0].lerp(below[-1], t) for t in np.linspace(0, 1, 12)]
        tatters(shape, random, fine, 0.38, coat)
        straw(shape, random, wrist + Vector((0.02 * hand, 0, 0)), Vector((hand, 0, -0.45)), 26, hay)
    shape.ball((0.02, -0.02, 2.16), (0.15, 0.15, 0.19), sack, 16)
    limb(shape, [(0.0, 0, 1.95), (0, 0, 2.02), (0.0, 0, 2.05)], [0.10, 0.07, 0.10], 12, sack)
    straw(shape, random, Vector((0, 0, 1.99)), Vector((0, 0, -0.2)), 26, hay)
    brim = Matrix.Translation((0.02, -0.02, 2.24)) @ Matrix.Rotation(0.16, 4, "Y") @ Matrix.Rotation(-0.1, 4, "X")
    shape.lathe(
        [(0.36, -0.02), (0.345, 0.0), (0.20, 0.03), (0.17, 0.16), (0.13, 0.32), (0.06, 0.42), (0.01, 0.44)],
        24,
        hat,
        brim,
    )
    straw(shape, random, Vector((0.0, 0, 2.2)), Vector((-0.6, 0, -0.3)), 10, hay)
    straw(shape, random, Vector((0.0, 0, 2.2)), Vector((0.6, 0, -0.3)), 10, hay)
    straw(shape, random, Vector((0.0, 0, 0.8)), Vector((0.0, 0, -1.0)), 30, hay)
    return link(
        "Scarecrow",
        shape.mesh(
            "Scarecrow", diffuse("Pole", (0.14, 0.10, 0.07)), diffuse("Coat", (0.10, 0.07, 0.06)),
            diffuse("Sack", (0.32, 0.24, 0.14)),
            diffuse("Hat", (0.09, 0.06, 0.05)), diffuse("Straw", (0.45, 0.33, 0.12)),
        ),
    )  # fmt: skip


def crow(black: bpy.types.Material, lift: float | None) -> bpy.types.Mesh:
    """Sits (no lift) or flies with wings so far up, in radians; looks along +X, 0.5 m long."""
    shape = Shape().ball((0, 0, 0), (0.19, 0.085, 0.085), 0, 12).ball((0.18, 0, 0.06), (0.07, 0.055, 0.055), 0, 10)
    limb(shape, [(0.22, 0, 0.06), (0.32, 0, 0.04)], [0.028, 0.004], 6)
    shape.add([(-0.13, -0.04, 0.02), (-0.13, 0.04, 0.02), (-0.36, 0.07, -0.03), (-0.36, -0.07, -0.03)], [(0, 1, 2, 3)])
    for hand in (-1, 1):
        if lift is None:
            limb(shape, [(0.0, 0.04 * hand, -0.05), (0.02, 0.05 * hand, -0.17)], [0.012, 0.008], 5)
            shape.ball((-0.07, 0.06 * hand, 0.01), (0.2, 0.03, 0.07), 0, 8)
            continue
        up = Vector((0, hand * cos(lift), sin(lift)))
        outer = Vector((0, hand * cos(lift - 0.5), sin(lift - 0.5)))
        root, elbow = Vector((0.02, 0.05 * hand, 0.04)), Vector((0.06, 0, 0.04)) + up * 0.24
        tip = elbow + outer * 0.26 + Vector((-0.12, 0, 0))
        shape.add(
            [
                root + Vector((0.08, 0, 0)),
                elbow + Vector((0.05, 0, 0)),
                elbow + Vector((-0.17, 0, 0)),
                root + Vector((-0.13, 0, 0)),
            ],
            [(0, 1, 2, 3)],
        )
        for feather in range(5):
            share = feather / 4
            end = tip.lerp(elbow + outer * 0.12 + Vector((-0.24, 0, 0)), share)
            base = elbow + Vector((0.05 - 0.2 * share, 0, 0))
            shape.add([base, base + Vector((-0.05, 0, 0)), end + Vector((-0.03, 0, 0)), end], [(0, 1, 2, 3)])
    return shape.mesh("Crow" if lift is None else f"Crow {lift:.1f}", black)


def wheat(random: np.random.Generator, name: str, stalk: bpy.types.Material) -> bpy.types.Collection:
    """A tuft of ripe stalks with bent ears and awns."""
    shape = blades(random, 14, 0.11, 0.55, 0.5, 0.012)
    for _ in range(16):
        root = Vector((random.normal() * 0.11, random.normal() * 0.11, -0.02))
        heading, tall = 2 * pi * random.random(), random.uniform(0.6, 0.95)
        out = Vector((cos(heading), sin(heading), 0))
        neck = root + out * 0.08 + Vector((0, 0, tall))
        limb(shape, [root, root.lerp(neck, 0.6) - out * 0.015, neck], [0.004, 0.0035, 0.003], 3)
        axis = (out * random.uniform(0.4, 1.0) + Vector((0, 0, random.uniform(0.1, 0.8)))).normalized()
        limb(shape, [neck, neck + axis * 0.03, neck + axis * 0.08, neck + axis * 0.11], [0.004, 0.011, 0.009, 0.002], 4)
        wide = axis.cross(Vector((0, 0, 1))).normalized()
        for awn in range(5):
            base = neck + axis * (0.03 + 0.015 * awn)
            end = base + (axis + wide * (0.25 * (awn - 2))).normalized() * 0.09
            shape.add([base - wide * 0.0012, base + wide * 0.0012, end], [(0, 1, 2)])
    collection = shared_collection(name)
    link(name, shape.mesh(name, stalk), collection)
    return collection


def sow(random: np.random.Generator, tufts: list[bpy.types.Collection]) -> None:
    """Wheat where the camera looks, denser close by; a trodden way before the figure."""
    count = 0
    while count < 3000:
        away = 1.4 + 45.0 * random.random() ** 1.7
        aside = random.uniform(-0.85, 0.85) * (away + 1.0)
        x, y = EYE[0] + aside, EYE[1] + away
        along = (y - EYE[1]) / (FIGURE[1] - EYE[1])
        if along < 1.05 and abs(x - (EYE[0] + (FIGURE[0] - EYE[0]) * along)) < 0.28 + 0.1 * sin(5 * along):
            continue
        count += 1
        place = placed((x, y, height_at(x, y)), (random.normal() * 6, random.normal() * 6, random.uniform(0, 360)))
        instance(tufts[int(random.integers(len(tufts)))], place @ Matrix.Scale(random.uniform(0.75, 1.15), 4))


def build() -> None:
    """Put the scene together."""
    clear_file()
    random = np.random.default_rng(13)
    x, y = spaced(-90.0, 90.0, 0.0, 0.25, 0.03), spaced(-8.0, 100.0, -4.0, 0.2, 0.03)
    ground("Field", x, y, heights(*np.meshgrid(x, y)), diffuse("Soil", (0.20, 0.14, 0.08)))
    stalks = [
        diffuse(f"Wheat {i}", colour)
        for i, colour in enumerate(((0.50, 0.36, 0.13), (0.42, 0.29, 0.10), (0.55, 0.42, 0.18)))
    ]
    sow(random, [wheat(random, f"Wheat {i}", stalk) for i, stalk in enumerate(stalks)])
    group = bpy.data.collections.new("Scarecrow and Crows")
    bpy.context.scene.collection.children.link(group)
    figure = scarecrow(random)
    figure.matrix_world = placed((*FIGURE, height_at(*FIGURE)), (0, 3, 8))
    black = diffuse("Crow", (0.02, 0.02, 0.025))
    sitting = crow(black, None)
    made = [figure]
    made.append(link("Crow", sitting, place=placed((FIGURE[0] + 0.72, 0.06, 2.19), (0, -14, 205))))
    made.append(link("Crow", sitting, place=placed((FIGURE[0] - 1.08, -0.12, 2.06), (0, -10, 20))))
    for index, (px, py, pz, turn, lift) in enumerate(
        ((1.7, 1.5, 3.1, 150, 0.5), (2.7, 4.0, 3.4, 170, -0.2), (-2.9, 3.0, 3.7, 30, 0.8), (1.0, 7.0, 4.9, 200, 0.3))
    ):
        made.append(
            link(f"Crow in Flight {index}", crow(black, lift), place=placed((px, py, pz), (12 - 8 * index, -10, turn)))
        )
    for thing in made:
        bpy.context.scene.collection.objects.unlink(thing)
        group.objects.link(thing)
    bark = diffuse("Dead Wood", (0.10, 0.08, 0.07))
    tree = bare_tree(np.random.default_rng(6), 7.5, 0.28).mesh("Dead Tree", bark, smooth=True)
    link("Dead Tree", tree, place=placed((6.4, 9.0, height_at(6.4, 9.0))))
    link("Dead Tree", tree, place=placed((-13.0, 21.0, height_at(-13.0, 21.0)), (0, 0, 130)))
    fence = Shape()
    for index in range(26):
        px, py = -22.0 + 1.9 * index, 13.0 + 0.12 * index
        foot = height_at(px, py)
        lean = random.normal(size=2) * 0.07
        limb(fence, [(px, py, foot - 0.2), (px + lean[0], py + lean[1], foot + 1.35)], [0.07, 0.055], 7)
        for rail in (0.55, 1.05):
            if random.random() < 0.85:
                far = height_at(px + 1.9, py + 0.12)
                limb(
                    fence,
                    [(px - 0.1, py - 0.05, foot + rail), (px + 2.0, py + 0.1, far + rail + random.normal() * 0.05)],
                    [0.035, 0.035],
                    6,
                )
    link("Fence", fence.mesh("Fence", bark))
    star = sun("Sun", tuple(towards(*SUN)), 4.2, (1.0, 0.38, 0.12), 0.3)
    edit_occluders(star, "SILHOUETTE", size_m=0.16, target="COLLECTION", target_collection=group)
    world((0.85, 0.28, 0.20), 0.2)
    fog_box((-25, -7.0, -3.0), (25, 1.6, 7.0), 0.065, (1.0, 0.97, 0.93), 0.65)
    camera(EYE, (0.15, 0.0, 1.98), 26.0)
    bpy.context.scene.tyndall.shafts.resolution = 4096
    set_up(view="Filmic", look="High Contrast", exposure=0.0)


if __name__ == "__main__":
    build()
    save(__file__)
