# SPDX-License-Identifier: GPL-3.0-or-later
"""A village at dawn: mist in its lanes, smoke of its chimneys, and calm light around the belfry are painted.

After figure 5.20 of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/village_dawn.py``; writes village_dawn.blend beside itself.
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
from nature_kit import bare_tree, ground, hills, limb, spaced
from scene_kit import (
    Shape,
    camera,
    clear_file,
    diffuse,
    emission,
    fog_box,
    link,
    paint_air,
    placed,
    save,
    set_up,
    sun,
    towards,
    world,
)

EYE, TARGET = (-3.5, -17.0, 7.6), (1.0, 20.0, 8.3)
CHURCH = (5.0, 30.0)
SUN = (10.3, 13.0)  #: Right of straight ahead and up, in degrees: behind the belfry.
SOFTNESS = 2.5  #: Of the air's texture where nothing is painted: smoke is painted finer.
WALL, ROOF, TIMBER, GLASS, GLOW, STONE = range(6)


def lane(y: float) -> float:
    """Where the lane through the village is, across it."""
    return 0.5 + 3.2 * sin(0.11 * y + 0.4)


def heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A valley that opens to the east, a mound for the church, mountains far away."""
    valley = 0.0075 * x**2 - 0.05 * np.clip(y, -20, 40) + 1.2 * hills(x / 23, y / 23, 5, 3)
    mound = 2.6 * np.exp(-((x - CHURCH[0]) ** 2 + (y - CHURCH[1]) ** 2) / 130)
    far = np.clip((np.hypot(x, y) - 60.0) / 160.0, 0.0, 1.0)
    ridge = np.clip(1.0 - np.abs(hills(x / 95 + 3.0, y / 95, 11, 5, 0.48)), 0.0, 1.0)
    return valley * (1 - far) + mound + 62.0 * far**1.3 * ridge**1.5 - 3.0 * far


def height_at(x: float, y: float) -> float:
    """Of the ground."""
    return float(heights(np.array(x), np.array(y)))


def house(shape: Shape, random: np.random.Generator, place: Matrix) -> Vector:
    """A gabled house, half-timbered; returns the mouth of its chimney, in the world."""
    w, d, t = random.uniform(2.1, 2.7), random.uniform(2.8, 3.8), random.uniform(2.6, 3.9)
    p = w * random.uniform(1.0, 1.3)
    gable = [(-w, -1.5), (w, -1.5), (w, t), (0, t + p), (-w, t)]
    points = [(x, y, z) for y in (-d, d) for x, z in gable]
    sides = [(i, i + 5, (i + 1) % 5 + 5, (i + 1) % 5) for i in range(5)]
    shape.add(points, [(0, 1, 2, 3, 4), (9, 8, 7, 6, 5), *sides], WALL, place)
    for side in (-1, 1):
        eave = (side * (w + 0.4), t - 0.4 * p / w)
        slab = [(0, t + p), eave, (eave[0], eave[1] + 0.16), (0, t + p + 0.22)]
        points = [(x, y, z) for y in (-d - 0.35, d + 0.35) for x, z in slab]
        rim = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
        shape.add(points, [(3, 2, 1, 0), (4, 5, 6, 7), *rim], ROOF, place)
        for x in np.linspace(-w, w, 5).tolist():
            shape.box((x - 0.07, side * d - 0.04, -0.2), (x + 0.07, side * d + 0.04, t), TIMBER, place)
        for z, half in ((0.55 * t, w), (t, w), (t + 0.5 * p, 0.5 * w)):
            shape.box((-half, side * d - 0.05, z - 0.08), (half, side * d + 0.05, z + 0.08), TIMBER, place)
        for x in (-0.5 * w, 0.5 * w, 0.0):
            low = t + 0.12 if x == 0.0 else 0.62 * t
            kind = GLOW if random.random() < 0.3 else GLASS
            shape.box((x - 0.3, side * d - 0.06, low), (x + 0.3, side * d + 0.06, low + 0.7), kind, place)
    x, y, top = 0.42 * w, random.choice([-0.4, 0.4]) * d, t + p + 0.75
    shape.box((x - 0.3, y - 0.3, t), (x + 0.3, y + 0.3, top), STONE, place)
    shape.box((x - 0.37, y - 0.37, top - 0.2), (x + 0.37, y + 0.37, top - 0.08), STONE, place)
    return place @ Vector((x, y, top))


def village(random: np.random.Generator) -> list[Vector]:
    """Houses in rows along the slope, but none on the lane or around the church; returns their chimneys."""
    shape, chimneys = Shape(), []
    for row, y in enumerate((-3.5, 3.5, 10.0, 16.5, 23.0, 31.0, 39.0, 47.0)):
        for column in range(-6, 7):
            px, py = 6.9 * column + 3.4 * (row % 2) + random.normal() * 0.5, y + random.normal() * 0.9
            if abs(px - lane(py)) < 3.6 or np.hypot(px - CHURCH[0], py - CHURCH[1]) < 9.5 or random.random() < 0.08:
                continue
            if row == 0 and abs(px - EYE[0]) < 7.0:
                continue
            turn = (0.0 if random.random() < 0.55 else 90.0) + random.normal() * 7
            chimneys.append(house(shape, random, placed((px, py, height_at(px, py)), (0, 0, turn))))
    materials = (
        diffuse("Plaster", (0.46, 0.38, 0.29)),
        diffuse("Tiles", (0.20, 0.095, 0.065)),
        diffuse("Timber", (0.10, 0.065, 0.04)),
        diffuse("Glass", (0.03, 0.035, 0.05)),
        emission("Lamplight", (1.0, 0.52, 0.16), 2.2),
        diffuse("Masonry", (0.28, 0.24, 0.21)),
    )
    link("Houses", shape.mesh("Houses", *materials))
    return chimneys


def church() -> None:
    """Nave, and a tower whose belfry is open on all sides, with a bell in it and a spire on it."""
    shape, stone, slate, bronze = Shape(), 0, 1, 2
    nave = [(-3.6, -3), (3.6, -3), (3.6, 6.5), (0, 11.0), (-3.6, 6.5)]
    points = [(x, y, z) for y in (2.4, 17.0) for x, z in nave]
    shape.add(points, [(0, 1, 2, 3, 4), (9, 8, 7, 6, 5)], stone)
    shape.add(points, [(0, 5, 6, 1), (1, 6, 7, 2), (4, 9, 5, 0)], stone)
    for side in (-1, 1):
        slab = [(0, 11.1), (side * 4.2, 5.9), (side * 4.2, 6.1), (0, 11.4)]
        points = [(x, y, z) for y in (2.0, 17.4) for x, z in slab]
        shape.add(points, [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5)], slate)
    shape.box((-2.5, -2.5, -3), (2.5, 2.5, 12.2), stone)
    for z, out in ((6.0, 0.12), (11.9, 0.3), (17.0, 0.35)):
        shape.box((-2.5 - out, -2.5 - out, z), (2.5 + out, 2.5 + out, z + 0.35), stone)
    for x in (-2.05, 2.05):
        for y in (-2.05, 2.05):
            shape.box((x - 0.45, y - 0.45, 12.2), (x + 0.45, y + 0.45, 17.0), stone)
    arc = [(1.6 * cos(a), 14.9 + 1.6 * sin(a)) for a in np.linspace(0, pi, 13).tolist()]
    for turn in range(4):  # the arches between the belfry's piers
        place = Matrix.Rotation(turn * pi / 2, 4, "Z")
        for a, b in pairwise(arc):
            front = [(a[0], -2.4, a[1]), (b[0], -2.4, b[1]), (b[0], -2.4, 17.0), (a[0], -2.4, 17.0)]
            shape.add(front, [(0, 3, 2, 1)], stone, place)
            shape.add([(x, y + 0.7, z) for x, y, z in front], [(0, 1, 2, 3)], stone, place)
            under = [(*a, -2.4), (*b, -2.4), (*b, -1.7), (*a, -1.7)]
            shape.add([(x, y, z) for x, z, y in under], [(0, 1, 2, 3)], stone, place)
        shape.tube(place @ Vector((0.05, -2.05, 12.2)), place @ Vector((0.05, -2.05, 16.4)), 0.12, 8, stone)
    shape.lathe([(3.0, 17.35), (2.3, 18.6), (0.08, 27.5)], 8, slate, Matrix.Rotation(pi / 8, 4, "Z"))
    shape.tube((0, 0, 27.3), (0, 0, 29.4), 0.06, 6, bronze).tube((-0.5, 0, 28.6), (0.5, 0, 28.6), 0.06, 6, bronze)
    bell = [(0.78, 13.35), (0.74, 13.45), (0.5, 13.9), (0.42, 14.5), (0.25, 14.75), (0.06, 14.85)]
    shape.lathe(bell, 24, bronze).box((-2.2, -0.12, 14.85), (2.2, 0.12, 15.1), bronze)
    x, y = CHURCH
    made = shape.mesh(
        "Church",
        diffuse("Sandstone", (0.36, 0.29, 0.23)),
        diffuse("Slate", (0.10, 0.10, 0.12)),
        diffuse("Bronze", (0.08, 0.06, 0.04)),
    )
    link("Church", made, place=placed((x, y, height_at(x, y) - 0.2), (0, 0, -12)))


def surroundings(random: np.random.Generator) -> None:
    """Meadows and mountains, the lane, walls along it, bare trees, and crows around the spire."""
    x, y = spaced(-230.0, 230.0, 0.0, 0.8, 0.03), spaced(-24.0, 290.0, 0.0, 0.8, 0.025)
    ground("Meadows", x, y, heights(*np.meshgrid(x, y)), diffuse("Meadow", (0.16, 0.15, 0.07)))
    path, wall = Shape(), Shape()
    for a, b in pairwise(np.arange(-22.0, 50.0, 0.8).tolist()):
        rim = [(lane(at) + side * 1.3, at) for at in (a, b) for side in (-1, 1)]
        corners = [(px, py, height_at(px, py) + 0.05) for px, py in rim]
        path.add(corners, [(0, 1, 3, 2)])
        for side in (-1, 1):
            line = [(lane(at) + side * 1.75, at) for at in (a, b)]
            limb(wall, [(px, py, height_at(px, py) + 0.25) for px, py in line], [0.42, 0.42], 6)
    link("Lane", path.mesh("Lane", diffuse("Cobbles", (0.27, 0.24, 0.21))))
    link("Walls", wall.mesh("Walls", diffuse("Fieldstone", (0.24, 0.22, 0.20))))
    bark = diffuse("Bark", (0.10, 0.08, 0.06))
    trees = [bare_tree(random, tall, 0.3).mesh("Tree", bark) for tall in (11.0, 9.0)]
    for px, py, scale in (
        (-11.5, -7.5, 1.0),
        (9.8, -4.0, 0.8),
        (14.5, 24.0, 1.0),
        (-5.5, 33.0, 1.0),
        (-20.0, 20.0, 1.1),
        (22.0, 9.0, 1.0),
    ):
        place = placed((px, py, height_at(px, py)), (0, 0, random.uniform(0, 360)), (scale,) * 3)
        link("Tree", trees[int(random.integers(2))], place=place)
    crow = Shape()
    for side in (-1, 1):
        crow.add([(0.16, 0, 0), (-0.16, 0, 0), (-0.1, side * 0.42, 0.16), (0.08, side * 0.4, 0.17)], [(0, 1, 2, 3)])
        crow.add([(0.08, side * 0.4, 0.17), (-0.1, side * 0.42, 0.16), (-0.14, side * 0.8, 0.05)], [(0, 1, 2)])
    crow.ball((0, 0, -0.02), (0.3, 0.08, 0.08), 0, 8)
    made = crow.mesh("Crow", diffuse("Feathers", (0.02, 0.02, 0.025)))
    for _ in range(11):
        at = Vector((CHURCH[0], CHURCH[1] - 6, 22.0)) + Vector(random.normal(size=3)) * 3.4
        link("Crow", made, place=placed(at, (random.normal() * 25, random.normal() * 15, random.uniform(0, 360))))


def smoke(random: np.random.Generator, mouth: Vector) -> None:
    """Paint what rises from a chimney: dense where it leaves, then wider and thinner; of fine grain all along."""
    drift, at = Vector((0.35, -0.05, 1.0)).normalized(), mouth + Vector((0, 0, 0.2))
    way = [at]
    for step in range(4):
        at = at + drift * (1.3 + 0.4 * step)
        way.append(at)
        drift = (drift + Vector((0.3 + 0.1 * random.normal(), 0.06 * random.normal(), 0.05))).normalized()
        paint_air(way[-2:], "INTENSITY", 110.0 * 0.52**step, 0.55 + 0.4 * step, depth=1.0, hardness=0.1)
    paint_air(way, "AMOUNT", 1.0, 2.4, depth=1.0, hardness=0.6)
    paint_air(way, "LEVEL", -SOFTNESS, 2.4, depth=1.0, hardness=0.6)


def paint(random: np.random.Generator, chimneys: list[Vector]) -> None:
    """Mist in the lanes, even and brighter air around the belfry, smoke above the nearer chimneys."""
    air = bpy.context.scene.tyndall.heterogeneity
    air.scale_m, air.octaves, air.persistence, air.contrast = 9.0, 6, 0.6, 4.0
    air.amount, air.level, air.step_count = 0.35, SOFTNESS, 128
    bpy.ops.tyndall.add_painted_box(voxels=192)
    for low in (-1.0, 6.5, 13.5, 20.0, 27.0, 35.0):
        row = [(x, low, height_at(x, low) + 1.5) for x in np.linspace(-32.0, 32.0, 9).tolist()]
        paint_air(row, "INTENSITY", 7.0, 3.6, depth=0.8, hardness=0.2)
        paint_air(row, "AMOUNT", 0.65, 4.0, depth=1.0, hardness=0.5)
    way = [(lane(y), y, height_at(lane(y), y) + 1.5) for y in np.arange(-6.0, 26.0, 4.0).tolist()]
    paint_air(way, "INTENSITY", 8.0, 2.6, depth=1.0, hardness=0.2)
    view = (Vector(EYE) - Vector(TARGET)).normalized()
    x, y = CHURCH
    belfry, square = Vector((x, y, height_at(x, y) + 15.0)), Vector((lane(4.0), 4.0, 5.0))
    shafts = [belfry, belfry.lerp(square, 0.5), square]
    paint_air(shafts, "AMOUNT", -1.0, 5.5, normal=view, depth=5.0, hardness=0.5)
    paint_air(shafts, "INTENSITY", 2.2, 4.5, normal=view, depth=2.0, hardness=0.2)
    for chimney in chimneys:
        if chimney.y < 26.0 and abs(chimney.x) < 0.75 * (chimney.y - EYE[1]) and random.random() < 0.75:
            smoke(random, chimney)


def build() -> None:
    """Put the scene together."""
    clear_file()
    random = np.random.default_rng(8)
    chimneys = village(random)
    church()
    surroundings(random)
    sun("Sun", tuple(towards(*SUN)), 14.0, (1.0, 0.60, 0.30), 0.1)
    fill = sun("Sky Light", tuple(towards(190.0, 45.0)), 0.5, (0.62, 0.74, 1.0), 60.0)
    fill.data.tyndall.scatters_in_media = False
    world((0.50, 0.56, 0.78), 0.4)
    fog_box((-42.0, -18.0, -6.0), (42.0, 58.0, 26.0), 0.003, (1.0, 0.97, 0.94), 0.72)
    camera(EYE, TARGET, 22.0)
    paint(random, chimneys)
    bpy.context.scene.tyndall.shafts.resolution = 4096
    set_up(view="Filmic", look="Medium High Contrast", exposure=-0.15)


if __name__ == "__main__":
    build()
    save(__file__)
