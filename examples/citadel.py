# SPDX-License-Identifier: GPL-3.0-or-later
"""A citadel against the evening sun, its shafts painted over three cameras: the sun's map is fitted to the strokes.

After figure 5.17 of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/citadel.py``; writes citadel.blend beside itself.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
from nature_kit import bare_tree, blades, boulder, ground, hills, limb, spaced
from scene_kit import (
    Point,
    Rgb,
    Shape,
    camera,
    clear_file,
    diffuse,
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

SUN = (3.0, 17.0)  #: Right of straight ahead and up, in degrees.
STROKES_PX = (480, 270)
CRIMSON, GOLD, TEAL = (1.0, 0.06, 0.10), (1.0, 0.72, 0.10), (0.05, 0.55, 1.0)


@dataclass(frozen=True)
class Stroke:
    """A line that is painted: from and to, as shares of the frame from its lower left corner, width, and colour."""

    start: tuple[float, float]
    end: tuple[float, float]
    width: float
    colour: Rgb


#: Three cameras, where they look, and what is painted over them.
VIEWS: tuple[tuple[str, Point, Point, tuple[Stroke, ...]], ...] = (
    (
        "From the Road",
        (-1.5, -31.0, 1.8),
        (0.5, 0.0, 8.2),
        (
            Stroke((0.10, 0.35), (0.26, 0.62), 0.07, CRIMSON),
            Stroke((0.46, 0.80), (0.52, 0.80), 0.12, GOLD),
            Stroke((0.88, 0.35), (0.74, 0.62), 0.07, TEAL),
        ),
    ),
    (
        "From the East",
        (15.0, -27.0, 2.2),
        (1.5, 0.0, 8.2),
        (Stroke((0.12, 0.36), (0.22, 0.60), 0.08, CRIMSON), Stroke((0.90, 0.36), (0.80, 0.60), 0.08, TEAL)),
    ),
    (
        "From the West",
        (-17.0, -27.0, 2.2),
        (-1.5, 0.0, 8.2),
        (Stroke((0.14, 0.30), (0.24, 0.55), 0.07, CRIMSON), Stroke((0.86, 0.30), (0.76, 0.55), 0.07, TEAL)),
    ),
)


def heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the hill: it climbs to the wall, and falls behind the town."""
    climb = np.clip((y + 26.0) / 26.0, 0.0, 1.0)
    aside = np.clip((np.abs(x) - 26.0) / 40.0, 0.0, 1.0)
    road = np.exp(-(((x - 1.2 * np.sin(y / 6.0)) / 2.6) ** 2)) * np.clip(-y / 6.0, 0.0, 1.0)
    return (
        1.7 * climb**1.6
        - 14.0 * aside**1.5
        + (0.35 * hills(x / 5, y / 5, 6, 4) - 0.1) * (1 - road) * np.clip(-y / 3, 0, 1)
        - 0.12 * road
    )


def height_at(x: float, y: float) -> float:
    """Of the hill."""
    return float(heights(np.array(x), np.array(y)))


def crenels(shape: Shape, start: Vector, end: Vector, thick: float, slot: int = 0) -> None:
    """Merlons along a wall's edge."""
    count = max(2, int((end - start).length / 1.5))
    way = (end - start) / count
    place = Matrix.Translation(start) @ way.to_track_quat("X", "Z").to_matrix().to_4x4()
    for index in range(count):
        low = (index * way.length + 0.15, -thick / 2, 0.0)
        shape.box(low, (low[0] + 0.85, thick / 2, 0.95), slot, place)


def wall(shape: Shape, start: tuple[float, float], end: tuple[float, float], top: float) -> None:
    """A curtain wall, wider at its foot, with a walk and merlons."""
    a, b = Vector((*start, 0.0)), Vector((*end, 0.0))
    long = (b - a).length
    place = Matrix.Translation(a) @ (b - a).to_track_quat("X", "Z").to_matrix().to_4x4()
    shape.box((0, -0.9, -6.0), (long, 0.9, top), 0, place)
    shape.box((0, -1.2, -6.0), (long, 1.2, 2.0), 0, place)
    shape.box((0, -1.1, top - 0.5), (long, 1.1, top - 0.2), 0, place)
    crenels(shape, a + Vector((0, -0.8, top)), b + Vector((0, -0.8, top)), 0.45)


def round_tower(shape: Shape, x: float, y: float, radius: float, top: float, roof: float) -> None:
    """With a battered foot, a corbelled head, and a cone or merlons."""
    place = Matrix.Translation((x, y, 0))
    shape.lathe(
        [
            (radius * 1.25, -8.0),
            (radius * 1.02, 3.0),
            (radius, top - 2.2),
            (radius * 1.18, top - 1.5),
            (radius * 1.18, top),
        ],
        28,
        0,
        place,
    )
    if roof:
        shape.lathe(
            [
                (radius * 1.36, top - 0.1),
                (radius * 0.72, top + roof * 0.42),
                (radius * 0.06, top + roof),
                (0.01, top + roof + 0.1),
            ],
            28,
            1,
            place,
        )
        limb(shape, [(x, y, top + roof - 0.2), (x, y, top + roof + 1.9)], [0.07, 0.05], 6, 1)
        flag = [
            (x, y, top + roof + 1.8),
            (x + 1.3, y - 0.2, top + roof + 1.65),
            (x + 1.1, y - 0.1, top + roof + 1.25),
            (x, y, top + roof + 1.1),
        ]
        shape.add(flag, [(0, 1, 2, 3)], 2)
        return
    for index in range(12):
        way = 2 * pi * index / 12
        turn = place @ Matrix.Rotation(way, 4, "Z")
        shape.box((radius * 0.95, -0.28 * radius / 2, top), (radius * 1.2, 0.28 * radius / 2, top + 0.95), 0, turn)


def gate(shape: Shape) -> None:
    """A gatehouse with a round arch that one sees through, between two towers."""
    half, spring, top = 2.2, 3.4, 8.6
    for hand in (-1, 1):
        shape.box((min(hand * half, hand * 5.0), -1.8, -4.0), (max(hand * half, hand * 5.0), 1.8, top))
    arch = [(half * cos(pi * i / 16), spring + half * sin(pi * i / 16)) for i in range(17)]
    points = [(x, y, z) for y in (-1.8, 1.8) for x, z in arch] + [(x, y, top) for y in (-1.8, 1.8) for x, _ in arch]
    faces = []
    for i in range(16):
        faces += [
            (i, i + 1, 35 + i, 34 + i),
            (17 + i + 1, 17 + i, 51 + i, 51 + i + 1),
            (i + 1, i, 17 + i, 17 + i + 1),
            (34 + i, 35 + i, 52 + i, 51 + i),
        ]
    shape.add(points, faces)
    shape.box((-5.2, -2.1, top - 0.6), (5.2, 2.1, top - 0.2))
    crenels(shape, Vector((-5.0, -1.7, top)), Vector((5.0, -1.7, top)), 0.45)
    for index in range(9):  # the raised portcullis
        x = -half + 0.25 + index * 0.49
        shape.tube((x, 0.2, spring + 0.5), (x, 0.2, spring + 2.0), 0.05, 5, 1)


def house(shape: Shape, random: np.random.Generator, x: float, y: float, foot: float, turn: float) -> None:
    """A gabled house with a chimney."""
    wide, deep, tall = random.uniform(2.4, 3.4), random.uniform(3.2, 5.0), random.uniform(3.0, 5.6)
    place = placed((x, y, foot), (0, 0, turn))
    shape.box((-wide / 2, -deep / 2, -4), (wide / 2, deep / 2, tall), 0, place)
    ridge = tall + wide * 0.75
    out = 0.3
    points = [(-wide / 2 - out, s * (deep / 2 + out), tall - 0.3) for s in (-1, 1)] + [
        (wide / 2 + out, s * (deep / 2 + out), tall - 0.3) for s in (-1, 1)
    ]
    points += [(0, s * (deep / 2 + out), ridge) for s in (-1, 1)]
    shape.add(points, [(0, 1, 5, 4), (3, 2, 4, 5), (0, 4, 2), (1, 3, 5), (0, 2, 3, 1)], 1, place)
    shape.box((wide * 0.15, -0.3, tall), (wide * 0.15 + 0.5, 0.25, ridge + 0.7), 0, place)


def citadel(random: np.random.Generator) -> bpy.types.Object:
    """Walls, towers, a keep, a church, and houses that climb to them."""
    shape = Shape()
    for a, b in (((-24, 2), (-13, 0)), ((-13, 0), (-5, 0)), ((5, 0), (13, 0)), ((18.5, 1.0), (24, 2))):
        wall(shape, a, b, 6.6)
    wall(shape, (13, 0), (15.2, 0.4), 5.4)  # the breach: what stands of both its sides
    wall(shape, (15.2, 0.4), (16.3, 0.6), 2.6)
    gate(shape)
    for x, y, radius, top, roof in (
        (-24, 2, 2.6, 9.6, 0), (-13, 0, 2.3, 9.2, 5.6), (-5.4, -0.6, 1.9, 11.2, 4.6), (5.4, -0.6, 1.9, 11.2, 4.6),
        (13, 0, 2.3, 8.6, 0), (24, 2, 2.6, 9.8, 5.8),
    ):  # fmt: skip
        round_tower(shape, x, y, radius, top, roof)
    shape.box((-4.2, 15, -4), (4.2, 23, 17.5))
    shape.box((-4.6, 14.6, 16.6), (4.6, 23.4, 17.5))
    crenels(shape, Vector((-4.5, 14.8, 17.5)), Vector((4.5, 14.8, 17.5)), 0.5)
    for x in (-4.2, 4.2):
        round_tower(shape, x, 15, 1.2, 20.5, 3.8)
    round_tower(shape, 1.6, 21, 1.3, 23.5, 4.6)
    shape.box((-12.5, 12, -4), (-9.5, 15, 13.0))  # the church and its spire
    shape.lathe(
        [(2.3, 13.0), (0.05, 21.5), (0.01, 21.6)],
        4,
        1,
        Matrix.Translation((-11, 13.5, 0)) @ Matrix.Rotation(pi / 4, 4, "Z"),
    )
    shape.box((-13.2, 14.5, -4), (-8.8, 24, 7.0))
    shape.add(
        [
            (-13.5, 14.2, 6.8),
            (-8.5, 14.2, 6.8),
            (-11, 14.2, 10.8),
            (-13.5, 24.3, 6.8),
            (-8.5, 24.3, 6.8),
            (-11, 24.3, 10.8),
        ],
        [(0, 1, 2), (4, 3, 5), (0, 2, 5, 3), (2, 1, 4, 5)],
        1,
    )
    round_tower(shape, 10.5, 14.5, 1.9, 14.5, 5.4)
    for index in range(26):
        x, y = random.uniform(-22, 22), random.uniform(4.5, 20)
        if (abs(x) < 6.5 and y > 10) or abs(x) < 2.5 or (-15 < x < -7 and y > 9) or (8 < x < 13 and y > 11):
            continue
        house(shape, random, x, y, 1.7 + 0.12 * y, 90.0 * (index % 2) + random.uniform(-12, 12))
    return link(
        "Citadel",
        shape.mesh(
            "Citadel",
            diffuse("Stone", (0.26, 0.22, 0.18)),
            diffuse("Roof", (0.18, 0.09, 0.06)),
            diffuse("Flag", (0.45, 0.05, 0.05)),
        ),
    )


def wayfarers(cloth: bpy.types.Material) -> None:
    """Three who walk up the road."""
    robe = Shape().lathe([(0.36, 0.0), (0.27, 0.8), (0.24, 1.3), (0.15, 1.5), (0.07, 1.56)], 14)
    robe.ball((0, 0, 1.66), (0.13, 0.13, 0.16), 0, 12).lathe([(0.16, 1.55), (0.17, 1.72), (0.02, 1.88)], 12)
    limb(robe, [(0.4, 0.1, 0.0), (0.36, 0.1, 2.0)], [0.02, 0.02], 6)
    mesh = robe.mesh("Wayfarer", cloth, smooth=True)
    for x, y in ((-0.4, -17.0), (0.5, -16.2), (-0.9, -14.6)):
        link("Wayfarer", mesh, place=placed((x, y, height_at(x, y)), (0, 0, 60 * x)))


def surroundings(random: np.random.Generator) -> None:
    """Stones, grass and dead trees before the wall."""
    rock = diffuse("Rock", (0.17, 0.15, 0.13))
    stones = [boulder(random).mesh(f"Rock {i}", rock, smooth=True) for i in range(3)]
    tufts = []
    for index in range(3):
        collection = shared_collection(f"Grass {index}")
        link(
            f"Grass {index}",
            blades(random, 50, 0.16, 0.45, 0.8, 0.012).mesh(
                f"Grass {index}", diffuse(f"Grass {index}", (0.20, 0.19, 0.08))
            ),
            collection,
        )
        tufts.append(collection)
    for _ in range(1500):
        y = -30.0 + 29.0 * random.random()
        x = random.uniform(-30, 30)
        if abs(x - 1.2 * sin(y / 6.0)) < 1.9:
            continue
        at = (x, y, height_at(x, y))
        if random.random() < 0.08:
            size = random.uniform(0.2, 0.8)
            link(
                "Rock",
                stones[int(random.integers(3))],
                place=placed(at, random.uniform(0, 360, 3), (size, size, size * 0.7)),
            )
        else:
            instance(
                tufts[int(random.integers(3))],
                placed(at, (0, 0, random.uniform(0, 360)), (random.uniform(0.7, 1.3),) * 3),
            )
    bark = diffuse("Dead Wood", (0.09, 0.07, 0.06))
    for seed, x, y, tall in ((5, -11.5, -17.0, 7.0), (8, 12.5, -15.0, 6.0), (12, 22.0, -10.0, 7.0)):
        tree = bare_tree(np.random.default_rng(seed), tall, 0.26)
        link("Dead Tree", tree.mesh(f"Dead Tree {seed}", bark, smooth=True), place=placed((x, y, height_at(x, y))))


def painted(strokes: tuple[Stroke, ...]) -> np.ndarray:
    """Strokes as float32 (height, width, 4), transparent elsewhere."""
    width, height = STROKES_PX
    pixels = np.zeros((height, width, 4), np.float32)
    places = np.stack(np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height), axis=-1)
    square = np.array((1.0, height / width))  # distances in shares of the width
    for stroke in strokes:
        start, way = np.array(stroke.start), np.array(stroke.end) - np.array(stroke.start)
        along = np.clip((((places - start) * square) @ (way * square)) / ((way * square) @ (way * square)), 0.0, 1.0)
        away = np.linalg.norm((places - start - along[..., None] * way) * square, axis=-1)
        pixels[away < stroke.width / 2] = (*stroke.colour, 1.0)
    return pixels


def paint(star: bpy.types.Object) -> None:
    """Paint over each camera, and fit the sun's map."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y = STROKES_PX
    bpy.context.view_layer.objects.active = star
    fit = star.data.tyndall.light_map_fit
    fit.resolution, fit.steps = 256, 32
    for index, (name, eye, target, strokes) in enumerate(VIEWS):
        made = camera(eye, target, 26.0)
        made.name = made.data.name = name
        if index:
            bpy.ops.tyndall.fit_view_add()
        bpy.ops.tyndall.paint_strokes()
        image = fit.views[index].strokes
        image.pixels.foreach_set(painted(strokes).ravel())
        image.update()
        image.pack()
    bpy.ops.tyndall.fit_light_map()
    scene.camera = bpy.data.objects[VIEWS[0][0]]


def build() -> None:
    """Put the scene together."""
    clear_file()
    random = np.random.default_rng(17)
    x, y = spaced(-90.0, 90.0, 0.0, 0.3, 0.03), spaced(-34.0, 60.0, -26.0, 0.25, 0.025)
    ground("Hill", x, y, heights(*np.meshgrid(x, y)), diffuse("Earth", (0.20, 0.16, 0.11)))
    citadel(random)
    surroundings(random)
    wayfarers(diffuse("Robe", (0.12, 0.08, 0.07)))
    star = sun("Sun", tuple(towards(*SUN)), 6.5, (1.0, 0.86, 0.70), 0.0)
    fill = sun("Open Sky", tuple(towards(165.0, 30.0)), 0.8, (0.70, 0.82, 1.0), 40.0)
    fill.data.tyndall.scatters_in_media = False
    world((0.35, 0.42, 0.70), 0.14)
    fog_box((-34, -33.5, -6.0), (34, 26, 24.0), 0.022, (1.0, 0.98, 0.96), 0.55)
    bpy.context.scene.tyndall.shafts.resolution = 4096
    paint(star)
    set_up(view="Filmic", look="High Contrast", exposure=0.0)


if __name__ == "__main__":
    build()
    save(__file__)
