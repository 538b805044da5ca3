# SPDX-License-Identifier: GPL-3.0-or-later
"""A walk below wisteria, the sun in its leaves: where the glare hides blossoms and a swing, it is painted down.

After figure 5.19 of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/arbor.py``; writes arbor.blend beside itself.
"""

from __future__ import annotations

import sys
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
from nature_kit import blades, ground, hills, limb, spaced
from scene_kit import (
    Shape,
    camera,
    clear_file,
    diffuse,
    fog_box,
    instance,
    link,
    paint_air,
    placed,
    save,
    set_up,
    shared_collection,
    sun,
    towards,
    world,
)

EYE, TARGET = (0.75, -6.6, 1.45), (-0.35, 4.0, 2.0)
SUN = (-33.0, 38.0)  #: Right of straight ahead and up, in degrees.
HALF, BEAM, STEP = 1.9, 3.0, 2.8  #: From the middle to the columns, up to the beams, from column to column, metres.
BEGIN, END = -8.0, 17.2
SWING, SWING_DEGREES = Vector((0.0, -1.75, BEAM + 0.31)), 17.0  #: The place of its pivot, and how far it has swung.


def heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the garden; the walk is level."""
    aside = np.clip((np.hypot(np.abs(x), np.maximum(y - 17.0, 0.0)) - 2.6) / 6.0, 0.0, 1.0)
    return aside * (0.35 * hills(x / 7, y / 7, 3, 3) + 0.25)


def height_at(x: float, y: float) -> float:
    """Of the ground."""
    return float(heights(np.array(x), np.array(y)))


def column(stone: bpy.types.Material) -> bpy.types.Mesh:
    """Turned of stone, on a square foot."""
    profile = [(0.17, 0.22), (0.19, 0.28), (0.15, 0.34), (0.155, 1.2)]
    profile += [(0.125, BEAM - 0.3), (0.17, BEAM - 0.22), (0.2, BEAM - 0.12)]
    shape = Shape().lathe(profile, 20).box((-0.22, -0.22, -0.05), (0.22, 0.22, 0.22))
    return shape.box((-0.21, -0.21, BEAM - 0.12), (0.21, 0.21, BEAM)).mesh("Column", stone)


def timber(wood: bpy.types.Material) -> None:
    """Beams along the walk, rafters across it."""
    shape = Shape()
    for side in (-1, 1):
        shape.box((side * HALF - 0.09, BEGIN - 0.8, BEAM), (side * HALF + 0.09, END + 0.8, BEAM + 0.2))
    for along in np.arange(BEGIN - 0.5, END + 0.6, 0.7):
        y = float(along)
        tail = [(-2.75, BEAM + 0.3), (-2.7, BEAM + 0.2), (-2.4, BEAM + 0.14)]
        tail += [(-x, z) for x, z in reversed(tail)]
        count = len(tail)
        points = [(x, y + side, z) for side in (-0.035, 0.035) for x, z in tail]
        sides = [(i, (i + 1) % count, count + (i + 1) % count, count + i) for i in range(count)]
        shape.add(points, [tuple(range(count)), tuple(reversed(range(count, 2 * count))), *sides])
    for across in (-1.1, 0.0, 1.1):
        shape.box((across - 0.03, BEGIN - 0.6, BEAM + 0.3), (across + 0.03, END + 0.6, BEAM + 0.35))
    link("Timber", shape.mesh("Timber", wood))


def leaf_clump(random: np.random.Generator, name: str, *greens: bpy.types.Material) -> bpy.types.Collection:
    """Feathered leaves around a place, half a metre wide."""
    shape = Shape()
    for _ in range(22):
        root = Vector(random.normal(size=3) * (0.17, 0.17, 0.1))
        heading = 2 * pi * random.random()
        out = Vector((cos(heading), sin(heading), random.uniform(-0.7, 0.35))).normalized()
        aside = out.cross(Vector((0, 0, 1))).normalized()
        slot = int(random.integers(len(greens)))
        long = random.uniform(0.2, 0.34)
        for pair in range(5):
            at = root + out * long * (0.15 + 0.19 * pair) + Vector((0, 0, -0.05 * (pair / 4) ** 2))
            for hand in (-1, 1):
                tip = (aside * hand + out * 0.55 + Vector((0, 0, -0.25))) * 0.085
                wide = out * 0.021
                shape.add([at, at + tip * 0.45 - wide, at + tip, at + tip * 0.45 + wide], [(0, 1, 2, 3)], slot)
    collection = shared_collection(name)
    link(name, shape.mesh(name, *greens), collection)
    return collection


def raceme(random: np.random.Generator, name: str, *blossoms: bpy.types.Material) -> bpy.types.Collection:
    """A hanging spray of blossoms, pale above, half a metre long."""
    shape, long = Shape(), random.uniform(0.42, 0.62)
    limb(shape, [(0, 0, 0), (0.01, 0, -0.5 * long), (0.0, 0.01, -long)], [0.006, 0.005, 0.003], 4, len(blossoms))
    for index in range(64):
        t = index / 63
        way, radius = 2.4 * index, (0.085 * (1 - t) ** 0.8 + 0.012)
        at = Vector((radius * cos(way), radius * sin(way), -0.04 - long * 0.95 * t))
        out = Vector((cos(way), sin(way), random.uniform(-0.5, 0.1)))
        size = 0.034 * (1 - 0.5 * t)
        side, up = Vector((-sin(way), cos(way), 0)) * size, Vector((out.x * 0.4, out.y * 0.4, 1.0)) * size
        slot = min(int((t + 0.12 * random.random()) * len(blossoms)), len(blossoms) - 1)
        shape.add([at - side, at + up * 0.9, at + side, at - up], [(0, 1, 2, 3)], slot)
        low = at + out * size * 0.8 - up * 0.5
        shape.add([at - side * 0.6, at + side * 0.6, low + side * 0.4, low - side * 0.4], [(0, 1, 2, 3)], slot)
    collection = shared_collection(name)
    link(name, shape.mesh(name, *blossoms, diffuse("Stalk", (0.18, 0.24, 0.06))), collection)
    return collection


def is_covered(x: float, y: float) -> bool:
    """Whether leaves lie there on the roof: they leave gaps, larger ones on the sunny side."""
    return float(hills(np.array(x / 1.35 + 4.0), np.array(y / 1.35), 21, 2, 0.4)) > 0.02 - 0.1 * (x > 0)


def wisteria(random: np.random.Generator) -> None:
    """Trunks that wind up the columns, leaves over the roof, blossoms below it."""
    bark = diffuse("Bark", (0.20, 0.16, 0.12))
    wood = Shape()
    for side in (-1, 1):
        for along in np.arange(BEGIN, END + 0.1, STEP).tolist():
            turns, phase = random.uniform(1.3, 2.2) * (1 if random.random() > 0.5 else -1), 2 * pi * random.random()
            line, radii = [], []
            for t in np.linspace(0.0, 1.0, 22).tolist():
                radius = 0.3 * (1 - t) ** 2 + 0.2
                way = phase + 2 * pi * turns * t
                line.append((side * HALF + radius * cos(way), along + radius * sin(way), -0.08 + (BEAM + 0.25) * t))
                radii.append(0.075 - 0.04 * t)
            limb(wood, line, radii, 7)
            for _ in range(3):
                at, heading = Vector(line[-1]), random.uniform(0, 2 * pi)
                vine, thick = [at.copy()], [0.035]
                for step in range(9):
                    heading += random.normal() * 0.5
                    at = at + Vector((cos(heading), sin(heading), 0)) * 0.28
                    at.z = BEAM + 0.3 + 0.12 * random.random()
                    vine.append(at.copy())
                    thick.append(0.033 - 0.0025 * step)
                limb(wood, vine, thick, 5)
    link("Vines", wood.mesh("Vines", bark, smooth=True))
    greens = [
        diffuse(f"Leaf {i}", colour)
        for i, colour in enumerate(((0.10, 0.19, 0.03), (0.16, 0.27, 0.05), (0.24, 0.34, 0.07)))
    ]
    blossoms = [
        diffuse(f"Blossom {i}", colour)
        for i, colour in enumerate(((0.78, 0.72, 0.82), (0.62, 0.48, 0.80), (0.50, 0.30, 0.72), (0.36, 0.18, 0.62)))
    ]
    clumps = [leaf_clump(random, f"Leaves {i}", *greens) for i in range(5)]
    sprays = [raceme(random, f"Wisteria {i}", *blossoms) for i in range(4)]
    for _ in range(2300):
        x, y = random.uniform(-2.7, 2.7), random.uniform(BEGIN - 0.6, END + 0.6)
        is_eave = abs(x) > 1.75
        if not (is_covered(x, y) or (is_eave and random.random() < 0.35)):
            continue
        place = placed(
            (x, y, BEAM + random.uniform(0.3, 0.55) - 0.25 * is_eave * random.random()),
            (random.normal() * 12, random.normal() * 12, random.uniform(0, 360)),
            (random.uniform(0.8, 1.35),) * 3,
        )
        instance(clumps[int(random.integers(5))], place)
    for _ in range(900):
        x, y = random.normal() * 0.6 + (-1.25, 1.25)[int(random.integers(2))], random.uniform(BEGIN - 0.6, END + 0.6)
        if abs(x) > 2.6 or not is_covered(x, y):
            continue
        place = placed(
            (x, y, BEAM + random.uniform(0.05, 0.3)),
            (random.normal() * 4, random.normal() * 4, random.uniform(0, 360)),
            (random.uniform(0.75, 1.35),) * 3,
        )
        instance(sprays[int(random.integers(4))], place)


def swing(wood: bpy.types.Material) -> None:
    """A girl on a swing that flies towards the sun, along -X: seen from the side, told from its pivot."""
    rope, plank, dress, skin, straw, hair, ribbon = range(7)
    shape = Shape().box((-0.13, -0.31, -2.53), (0.13, 0.31, -2.49), plank)
    skirt = [(-0.06, 0, -2.38), (0.12, 0, -2.36), (0.40, 0, -2.40), (0.56, 0, -2.52)]
    limb(shape, skirt, [0.13, 0.18, 0.19, 0.25], 16, dress)
    back = [(-0.05, 0, -2.40), (-0.10, 0, -2.16), (-0.14, 0, -1.93), (-0.14, 0, -1.86)]
    limb(shape, back, [0.13, 0.10, 0.12, 0.05], 14, dress)
    limb(shape, [(-0.14, 0, -1.88), (-0.13, 0, -1.76)], [0.045, 0.042], 8, skin)
    shape.ball((-0.11, 0, -1.68), (0.095, 0.08, 0.115), skin, 16)
    braid = [(-0.15, 0, -1.64), (-0.25, 0, -1.74), (-0.40, 0, -1.84), (-0.56, 0, -1.86)]
    limb(shape, braid, [0.085, 0.08, 0.06, 0.01], 10, hair)
    hat = placed((-0.14, 0, -1.625), (0, -24, 0))
    shape.lathe([(0.24, -0.01), (0.25, 0.0), (0.1, 0.022), (0.096, 0.09), (0.06, 0.12), (0.01, 0.125)], 28, straw, hat)
    shape.lathe([(0.103, 0.02), (0.101, 0.05)], 28, ribbon, hat)
    for side in (-1, 1):
        limb(shape, [(0, side * 0.26, -2.5), (0, side * 0.26, 0.0)], [0.013, 0.013], 6, rope)
        arm = [(-0.14, side * 0.12, -1.93), (-0.04, side * 0.25, -2.0), (0.0, side * 0.26, -1.80)]
        limb(shape, arm, [0.042, 0.034, 0.028], 8, skin)
        shape.ball(arm[-1], (0.036, 0.036, 0.045), skin, 8)
        foot = Vector((0.96, side * 0.07, -2.60))
        limb(shape, [(0.46, side * 0.08, -2.46), (0.7, side * 0.075, -2.52), foot], [0.06, 0.052, 0.033], 8, skin)
        shape.ball(foot + Vector((0.05, 0, 0.02)), (0.085, 0.036, 0.042), ribbon, 10)
    colours = (
        ("Hemp", (0.42, 0.34, 0.22)),
        ("Dress", (0.72, 0.68, 0.62)),
        ("Skin", (0.50, 0.32, 0.24)),
        ("Straw", (0.66, 0.50, 0.22)),
        ("Hair", (0.16, 0.08, 0.04)),
        ("Ribbon", (0.58, 0.05, 0.07)),
    )
    materials = [diffuse(name, colour) for name, colour in colours]
    materials.insert(1, wood)
    link("Swing", shape.mesh("Swing", *materials, smooth=True), place=placed(SWING, (0, -SWING_DEGREES, 180)))


def urn(stone: bpy.types.Material) -> bpy.types.Mesh:
    """On a pedestal, 2 m high."""
    profile = [(0.36, 0.9), (0.2, 0.96), (0.12, 1.06), (0.16, 1.12), (0.33, 1.35), (0.42, 1.62)]
    profile += [(0.36, 1.76), (0.48, 1.86), (0.46, 1.9), (0.3, 1.88)]
    shape = Shape().lathe(profile, 28).box((-0.4, -0.4, 0.1), (0.4, 0.4, 0.82))
    shape.box((-0.5, -0.5, -0.1), (0.5, 0.5, 0.12)).box((-0.46, -0.46, 0.8), (0.46, 0.46, 0.9))
    return shape.mesh("Urn", stone)


def walk(random: np.random.Generator) -> None:
    """Slabs, laid in rows, with grass in their joints."""
    shape, y = Shape(), BEGIN - 2.0
    while y < END + 3.0:
        deep, x = random.uniform(0.45, 0.75), -1.25
        while x < 1.2:
            wide = min(random.uniform(0.5, 0.95), 1.27 - x)
            top = 0.03 + 0.012 * random.random()
            shape.box((x + 0.02, y + 0.02, -0.1), (x + wide - 0.02, y + deep - 0.02, top), int(random.integers(3)))
            x += wide
        y += deep
    shades = [
        diffuse(f"Slab {i}", (0.42 * shade, 0.38 * shade, 0.33 * shade)) for i, shade in enumerate((0.8, 1.0, 1.15))
    ]
    link("Walk", shape.mesh("Walk", *shades))


def garden(random: np.random.Generator, stone: bpy.types.Material) -> None:
    """Lawn, borders along the walk, a hedge around, trees behind it, and an urn at the end of the walk."""
    x, y = spaced(-30.0, 30.0, 0.0, 0.3, 0.03), spaced(-12.0, 45.0, 0.0, 0.3, 0.02)
    ground("Lawn", x, y, heights(*np.meshgrid(x, y)), diffuse("Lawn", (0.06, 0.10, 0.025)))
    tufts = []
    kinds = (((0.14, 0.24, 0.05), 0.22), ((0.18, 0.30, 0.07), 0.3), ((0.12, 0.20, 0.08), 0.45))
    for index, (colour, tall) in enumerate(kinds):
        name = f"Tuft {index}"
        tuft = shared_collection(name)
        link(name, blades(random, 40, 0.1, tall, 0.8, 0.014).mesh(name, diffuse(name, colour)), tuft)
        tufts.append(tuft)
    for _ in range(1100):
        side = (-1, 1)[int(random.integers(2))]
        px, py = side * (1.38 + abs(random.normal()) * 0.9), random.uniform(BEGIN, END + 2)
        kind = 2 if abs(px) < 1.9 and random.random() < 0.5 else int(random.integers(2))
        scale = random.uniform(0.7, 1.3)
        instance(tufts[kind], placed((px, py, height_at(px, py)), (0, 0, random.uniform(0, 360)), (scale,) * 3))
    lavender = shared_collection("Lavender")
    shape = blades(random, 30, 0.09, 0.34, 0.5, 0.012)
    for _ in range(26):
        heading, lean, tall = 2 * pi * random.random(), random.uniform(0.05, 0.22), random.uniform(0.34, 0.5)
        tip = Vector((cos(heading) * lean, sin(heading) * lean, tall))
        limb(shape, [tip * 0.1, tip], [0.004, 0.003], 4)
        limb(shape, [tip * 0.9, tip, tip * 1.18], [0.012, 0.016, 0.005], 6, 1)
    sage, violet = diffuse("Sage", (0.20, 0.26, 0.14)), diffuse("Lavender", (0.34, 0.20, 0.58))
    link("Lavender", shape.mesh("Lavender", sage, violet), lavender)
    for side in (-1, 1):
        for along in np.arange(BEGIN, END, 0.42):
            px, py = side * (1.52 + 0.1 * random.normal()), float(along) + 0.1 * random.normal()
            instance(lavender, placed((px, py, 0.0), (0, 0, random.uniform(0, 360)), (random.uniform(0.8, 1.2),) * 3))
    hedge = Shape().box((-24, 27.0, -0.5), (24, 28.4, 2.6))
    for side in (-1, 1):
        hedge.box((side * 11.0 - 0.7, -9, -0.5), (side * 11.0 + 0.7, 27.5, 2.2))
    link("Hedge", hedge.mesh("Hedge", diffuse("Yew", (0.07, 0.13, 0.04))))
    crown = Shape().tube((0, 0, -2.6), (0, 0, 0), 0.16, 8, 1)
    for _ in range(9):
        middle, radii = Vector(random.normal(size=3)) * 0.55, np.array((1.0, 1.0, 0.85)) * random.uniform(0.5, 0.8)
        crown.ball(middle, radii * 0.85, 0, 12)
        for _ in range(170):
            out = Vector(random.normal(size=3)).normalized()
            at = middle + Vector(radii * np.array(out)) * random.uniform(0.8, 1.05)
            tip = (out + Vector(random.normal(size=3)) * 0.7).normalized() * 0.2
            wide = tip.cross(Vector(random.normal(size=3))).normalized() * 0.07
            leaf = [at, at + tip * 0.5 + wide, at + tip, at + tip * 0.5 - wide]
            crown.add(leaf, [(0, 1, 2, 3)], 2 * int(random.integers(2)))
    bark = diffuse("Trunk", (0.14, 0.11, 0.08))
    tree = crown.mesh("Tree", diffuse("Lime", (0.08, 0.15, 0.03)), bark, diffuse("Pale Lime", (0.13, 0.22, 0.05)))
    for px, py, scale in (
        (-9, 31, 2.6),
        (-3.5, 34, 3.2),
        (4.0, 33, 2.7),
        (9.5, 31, 3.0),
        (16, 27, 2.8),
        (-16, 29, 3.2),
        (15, 15, 2.4),
        (-14.5, 17, 2.2),
    ):
        link("Tree", tree, place=placed((px, py, 2.4 * scale), (0, 0, random.uniform(0, 360)), (scale,) * 3))
    link("Urn", urn(stone), place=placed((0, END + 2.4, 0)))


def paint() -> None:
    """Tone the glare down: before the blossoms above, around the girl, and over the lawn."""
    bpy.ops.tyndall.add_painted_box(voxels=144)
    bpy.context.scene.tyndall.heterogeneity.amount = 0.0  # the air stays even; its intensity alone is painted
    view = (Vector(EYE) - Vector(TARGET)).normalized()
    lawn = [(-4.4, 0.0, 1.2), (-4.2, 9.0, 2.4), (-2.4, 16.0, 2.4)]
    paint_air(lawn, "INTENSITY", 0.15, 2.6, normal=view, depth=4.0, hardness=0.6)
    paint_air([(-2.6, -3.5, 2.7), (-1.2, 1.0, 3.2)], "INTENSITY", 0.04, 1.6, normal=view, depth=5.0, hardness=0.5)
    paint_air([(-1.7, -1.75, 0.8), (-0.4, -1.75, 1.6)], "INTENSITY", 0.08, 1.0, normal=view, depth=14.0, hardness=0.5)


def build() -> None:
    """Put the scene together."""
    clear_file()
    random = np.random.default_rng(12)
    stone, wood = diffuse("Limestone", (0.52, 0.47, 0.39)), diffuse("Oak", (0.24, 0.17, 0.11))
    pillar = column(stone)
    for side in (-1, 1):
        for along in np.arange(BEGIN, END + 0.1, STEP).tolist():
            link("Column", pillar, place=placed((side * HALF, float(along), 0)))
    timber(wood)
    wisteria(random)
    walk(random)
    garden(random, stone)
    swing(wood)
    sun("Sun", tuple(towards(*SUN)), 27.0, (1.0, 0.84, 0.58), 0.1)
    fill = sun("Open Sky", tuple(towards(165.0, 9.0)), 2.6, (0.86, 0.90, 1.0), 40.0)
    fill.data.tyndall.scatters_in_media = False
    world((0.50, 0.72, 1.0), 0.6)
    fog_box((-5.0, -8.0, -0.5), (5.0, 21.0, 4.2), 0.046, (1.0, 0.99, 0.95), 0.65)
    camera(EYE, TARGET, 22.0)
    paint()
    bpy.context.scene.tyndall.shafts.resolution = 4096
    set_up(view="Filmic", look="Medium High Contrast", exposure=0.0)


if __name__ == "__main__":
    build()
    save(__file__)
