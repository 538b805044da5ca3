# SPDX-License-Identifier: GPL-3.0-or-later
"""A flower bed under a beech: holes that drift through its closed crown let the sun in, onto one bloom after the other.

After figure 5.13, right, of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/flower_bed.py``; writes flower_bed.blend beside itself.
"""

from __future__ import annotations

import sys
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
from nature_kit import blades, boulder, ground, hills, limb, spaced
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

EYE = (0.7, -5.3, 1.35)
SUN = (-26.0, 40.0)  #: Right of straight ahead and up, in degrees.
FRAMES = 24
BLOOMS = (
    (0.75, 0.10, 0.14),
    (0.85, 0.55, 0.06),
    (0.80, 0.78, 0.72),
    (0.38, 0.14, 0.62),
    (0.85, 0.28, 0.45),
    (0.12, 0.22, 0.75),
)


def heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the lawn, and of the bed that is heaped up on it."""
    bed = np.clip(1.0 - ((x / 5.4) ** 2 + ((y + 1.2) / 2.6) ** 2), 0.0, 1.0)
    rise = np.clip((y - 3.0) / 14.0, 0.0, 1.0)
    return 0.32 * np.sqrt(bed) + 1.3 * rise + 0.05 * hills(x / 2.2, y / 2.2, 4, 4)


def height_at(x: float, y: float) -> float:
    """Of the ground."""
    return float(heights(np.array(x), np.array(y)))


def flower(
    random: np.random.Generator,
    name: str,
    kind: int,
    stalk: bpy.types.Material,
    bloom: bpy.types.Material,
    heart: bpy.types.Material,
) -> bpy.types.Collection:
    """One plant: daisies, tulips or bells on bent stalks over a rosette of leaves."""
    shape = blades(random, 16, 0.06, 0.30, 1.1, 0.045)
    for _ in range((5, 4, 3)[kind]):
        heading, tall = 2 * pi * random.random(), random.uniform(0.34, 0.62)
        out = Vector((cos(heading), sin(heading), 0))
        root = Vector((random.normal() * 0.05, random.normal() * 0.05, 0))
        top = root + out * random.uniform(0.05, 0.17) + Vector((0, 0, tall))
        limb(shape, [root, root.lerp(top, 0.5) + Vector((0, 0, 0.03)), top], [0.008, 0.007, 0.006], 5)
        face = (out * 0.5 + Vector((0, 0, 1)) + Vector(random.normal(size=3)) * 0.25).normalized()
        turn = Matrix.Translation(top) @ face.to_track_quat("Z", "Y").to_matrix().to_4x4()
        if kind == 2:
            for bell in range(7):
                at = top + Vector((0, 0, 0.045 * bell - 0.18)) + out * 0.01
                way = 2.4 * bell
                aside = Vector((cos(way), sin(way), -0.45)).normalized()
                place = Matrix.Translation(at) @ aside.to_track_quat("Z", "Y").to_matrix().to_4x4()
                shape.lathe(
                    [(0.008, 0.0), (0.026, 0.02), (0.03, 0.05), (0.042, 0.07)],
                    8,
                    1,
                    place @ Matrix.Scale(1.1 - 0.09 * bell, 4),
                )
            continue
        petals, long, wide, cup = ((17, 0.075, 0.019, 0.15), (7, 0.075, 0.036, 1.1))[kind]
        for petal in range(petals):
            spin = Matrix.Rotation(2 * pi * petal / petals + 0.1 * random.random(), 4, "Z")
            lift = cup + 0.1 * random.random()
            ridge = [
                (0.0, 0.0),
                (0.5 * long, 0.5 * long * sin(lift)),
                (long * (1 - 0.35 * cup / 1.15), long * sin(lift) * 1.05),
            ]
            points = [(ridge[0][0], 0, ridge[0][1])]
            points += [(ridge[1][0], hand * wide, ridge[1][1] + 0.008) for hand in (-1, 1)]
            points += [(ridge[2][0], 0, ridge[2][1]), (ridge[1][0], 0, ridge[1][1])]
            shape.add(points, [(0, 1, 3, 4), (0, 4, 3, 2)], 1, turn @ spin)
        shape.ball(turn @ Vector((0, 0, 0.008)), (0.026, 0.026, 0.018), 2, 8)
    collection = shared_collection(name)
    link(name, shape.mesh(name, stalk, bloom, heart), collection)
    return collection


def beech(
    random: np.random.Generator, bark: bpy.types.Material, *greens: bpy.types.Material
) -> tuple[bpy.types.Mesh, bpy.types.Mesh]:
    """A broad old tree whose leaves close the crown: wood, and clouds of leaves around its boughs."""
    wood, ends = Shape(), []

    def grow(root: Vector, axis: Vector, length: float, thick: float, level: int) -> None:
        line, radii, at = [root.copy()], [thick], root.copy()
        for step in range(1, 5):
            axis = (axis + Vector(random.normal(size=3)) * 0.13 + Vector((0, 0, 0.04 if level else 0.0))).normalized()
            at = at + axis * length / 4
            line.append(at.copy())
            radii.append(thick * (1 - 0.14 * step))
        limb(wood, line, radii, (16, 10, 8, 6)[level])
        if level >= 2:
            ends.append(at.copy())
        if level == 3:
            return
        forks = (6, 4, 3)[level]
        for fork in range(forks):
            way = 2 * pi * (fork + 0.4 * random.random()) / forks
            side = axis.orthogonal().normalized()
            side = (side * cos(way) + axis.cross(side) * sin(way)).normalized()
            index = 4 if fork < 2 else int(random.integers(2, 5))
            grow(
                line[index],
                (axis + side * (1.2, 0.9, 0.9)[level]).normalized(),
                length * random.uniform(0.66, 0.84),
                radii[index] * 0.62,
                level + 1,
            )

    grow(Vector((0, 0, -0.3)), Vector((0.05, 0, 1)), 3.3, 0.42, 0)
    leaves = Shape()
    for at in ends:
        radii = np.array((1.0, 1.0, 0.6)) * random.uniform(0.85, 1.2)
        leaves.ball(at, radii * 0.72, 0, 10)
        for _ in range(85):
            out = Vector(random.normal(size=3)).normalized()
            root = at + Vector(radii * np.array(out)) * random.uniform(0.62, 1.05)
            tip = (out + Vector(random.normal(size=3)) * 0.6 + Vector((0, 0, -0.5))).normalized() * random.uniform(
                0.2, 0.32
            )
            wide = tip.cross(Vector(random.normal(size=3))).normalized() * random.uniform(0.07, 0.1)
            leaves.add(
                [root, root + tip * 0.45 + wide, root + tip, root + tip * 0.45 - wide],
                [(0, 1, 2, 3)],
                int(random.integers(len(greens))),
            )
    return wood.mesh("Beech", bark, smooth=True), leaves.mesh("Leaves", *greens)


def picket_fence(random: np.random.Generator, white: bpy.types.Material) -> bpy.types.Object:
    """Behind the bed."""
    shape = Shape()
    for index in range(110):
        x, y = -11.0 + 0.2 * index, 4.6 + 0.25 * sin(0.05 * index)
        foot = height_at(x, y)
        top = foot + 0.95 + 0.02 * random.normal()
        points = [
            (x - 0.055, y, foot),
            (x + 0.055, y, foot),
            (x + 0.055, y, top),
            (x, y, top + 0.09),
            (x - 0.055, y, top),
        ]
        points += [(a, b + 0.02, c) for a, b, c in points]
        faces = [(0, 1, 2, 3, 4), (9, 8, 7, 6, 5)] + [(i, i + 5, (i + 1) % 5 + 5, (i + 1) % 5) for i in range(5)]
        shape.add(points, faces)
        if index % 10 == 0:
            shape.box((x - 0.07, y + 0.03, foot - 0.1), (x + 0.07, y + 0.15, top + 0.05))
    for rail in (0.28, 0.75):
        for index in range(22):
            a, b = -11.0 + index, -10.0 + index
            limb(shape, [(a, 4.65, height_at(a, 4.6) + rail), (b, 4.65, height_at(b, 4.6) + rail)], [0.035, 0.035], 4)
    return link("Fence", shape.mesh("Fence", white))


def watering_can(tin: bpy.types.Material) -> bpy.types.Mesh:
    """Of zinc, 0.4 m high."""
    shape = Shape().lathe([(0.15, 0.0), (0.16, 0.02), (0.15, 0.3), (0.11, 0.34), (0.105, 0.345)], 24)
    limb(shape, [(0.13, 0, 0.07), (0.3, 0, 0.2), (0.44, 0, 0.4)], [0.035, 0.028, 0.02], 10)
    shape.lathe(
        [(0.02, 0.0), (0.065, 0.05), (0.068, 0.06)],
        14,
        0,
        Matrix.Translation((0.44, 0, 0.4)) @ Matrix.Rotation(0.7, 4, "Y"),
    )
    arc = [(-0.15 - 0.12 * sin(pi * t), 0, 0.06 + 0.28 * t) for t in np.linspace(0, 1, 10)]
    limb(shape, arc, [0.012] * 10, 8)
    limb(shape, [(0.11 * cos(pi * t), 0, 0.34 + 0.16 * sin(pi * t)) for t in np.linspace(0, 1, 12)], [0.011] * 12, 8)
    return shape.mesh("Watering Can", tin, smooth=True)


def plant(random: np.random.Generator, green: bpy.types.Material) -> None:
    """Flowers in drifts over the bed, grass around it."""
    heart = diffuse("Heart", (0.55, 0.36, 0.05))
    plants = [
        [flower(random, f"Flower {i} {j}", i % 3, green, diffuse(f"Bloom {i} {j}", colour), heart) for j in range(2)]
        for i, colour in enumerate(BLOOMS)
    ]
    drift = random.uniform((-5.2, -3.6), (5.2, 1.2), (46, 2))
    kinds = random.integers(0, len(BLOOMS), 46)
    for _ in range(1700):
        x, y = random.uniform(-5.4, 5.4), random.uniform(-3.8, 1.4)
        if (x / 5.3) ** 2 + ((y + 1.2) / 2.5) ** 2 > 1.0:
            continue
        kind = kinds[
            np.argmin(np.hypot(drift[:, 0] - x + random.normal() * 0.3, drift[:, 1] - y + random.normal() * 0.2))
        ]
        place = placed((x, y, height_at(x, y)), (random.normal() * 6, random.normal() * 6, random.uniform(0, 360)))
        instance(plants[int(kind)][int(random.integers(2))], place @ Matrix.Scale(random.uniform(0.75, 1.2), 4))
    tufts = []
    for index in range(3):
        collection = shared_collection(f"Grass {index}")
        tuft = blades(random, 46, 0.12, 0.15, 0.8, 0.009)
        link(
            f"Grass {index}",
            tuft.mesh(f"Grass {index}", diffuse(f"Grass {index}", (0.13, 0.24 + 0.04 * index, 0.05))),
            collection,
        )
        tufts.append(collection)
    for _ in range(2600):
        y = -6.6 + 14.0 * random.random() ** 1.5
        x = random.uniform(-1, 1) * (3.0 + 0.62 * (y - EYE[1]))
        if (x / 5.5) ** 2 + ((y + 1.2) / 2.7) ** 2 < 1.0:
            continue
        instance(
            tufts[int(random.integers(3))],
            placed((x, y, height_at(x, y)), (0, 0, random.uniform(0, 360)), (random.uniform(0.7, 1.3),) * 3),
        )


def build() -> None:
    """Put the scene together."""
    clear_file()
    random = np.random.default_rng(31)
    x, y = spaced(-22.0, 22.0, 0.0, 0.12, 0.02), spaced(-8.5, 20.0, -5.0, 0.08, 0.02)
    ground("Ground", x, y, heights(*np.meshgrid(x, y)), diffuse("Soil", (0.14, 0.13, 0.06)))
    plant(random, diffuse("Green", (0.12, 0.26, 0.06)))
    stone = boulder(random).mesh("Edging", diffuse("Edging", (0.32, 0.29, 0.25)), smooth=True)
    for index in range(64):
        way = 2 * pi * index / 64
        px, py = 5.45 * cos(way), -1.2 + 2.65 * sin(way)
        place = placed((px, py, height_at(px, py) + 0.02), random.uniform(0, 360, 3), random.uniform(0.14, 0.24, 3))
        link("Edging", stone, place=place)
    crowns = bpy.data.collections.new("Crowns")
    bpy.context.scene.collection.children.link(crowns)
    greens = [
        diffuse(f"Beech Leaf {i}", colour)
        for i, colour in enumerate(((0.07, 0.15, 0.03), (0.10, 0.20, 0.04), (0.14, 0.26, 0.05)))
    ]
    wood, leaves = beech(random, diffuse("Bark", (0.17, 0.14, 0.11)), *greens)
    for px, py, turn, scale in (
        (-3.2, 3.6, 0, 1.0),
        (3.6, 6.6, 110, 1.05),
        (-9.5, 5.5, 230, 1.1),
        (-5.0, 10.5, 60, 1.15),
        (9.5, 11.5, 300, 1.1),
        (-13.5, 11.0, 170, 1.2),
    ):
        place = placed((px, py, height_at(px, py)), (0, 0, turn), (scale,) * 3)
        link("Beech", wood, place=place)
        link("Leaves", leaves, crowns, place=place)
    hedge = Shape().box((-19, 9.0, -0.5), (19, 10.2, 3.8))
    for _ in range(14000):
        at = Vector((random.uniform(-19, 19), random.uniform(8.8, 9.2), 4.1 * random.random() ** 0.8))
        out = Vector(random.normal(size=3)).normalized() * 0.22
        wide = out.cross(Vector(random.normal(size=3))).normalized() * 0.09
        hedge.add([at, at + out * 0.5 + wide, at + out, at + out * 0.5 - wide], [(0, 1, 2, 3)])
    link("Hedge", hedge.mesh("Hedge", diffuse("Hornbeam", (0.05, 0.11, 0.03))))
    picket_fence(random, diffuse("White Paint", (0.62, 0.60, 0.55)))
    link(
        "Watering Can",
        watering_can(diffuse("Zinc", (0.34, 0.37, 0.38))),
        place=placed((2.6, -4.6, height_at(2.6, -4.6)), (0, 0, 145)),
    )
    star = sun("Sun", tuple(towards(*SUN)), 26.0, (1.0, 0.80, 0.50), 0.4)
    edit = edit_occluders(
        star,
        "HOLES",
        scale_m=1.6,
        octaves=3,
        persistence=0.4,
        probability=0.3,
        sway=0.5,
        affects_surfaces=True,
        target="COLLECTION",
        target_collection=crowns,
    )
    for frame, turn in ((1, 0.0), (FRAMES + 1, 2 * pi)):
        edit.noise.turn_rad = turn
        edit.noise.keyframe_insert("turn_rad", frame=frame)
    for curve in star.data.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    fill = sun("Open Sky", tuple(towards(150.0, 28.0)), 1.6, (0.75, 0.87, 1.0), 40.0)
    fill.data.tyndall.scatters_in_media = False
    world((0.50, 0.72, 1.0), 0.16)
    fog_box((-20, -8.4, -1.0), (20, 12, 12.0), 0.015, (0.97, 1.0, 0.95), 0.55)
    camera(EYE, (-0.3, 0.0, 1.55), 22.0)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.tyndall.shafts.resolution = 4096
    set_up(view="Filmic", look="High Contrast", exposure=0.0)


if __name__ == "__main__":
    build()
    save(__file__)
