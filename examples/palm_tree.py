# SPDX-License-Identifier: GPL-3.0-or-later
"""Palms of an oasis before a low sun, a caravan on the dune behind them: filled holes calm the light in the crown.

After figure 5.13, left, of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/palm_tree.py``; writes palm_tree.blend beside itself.
"""

from __future__ import annotations

import sys
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
from nature_kit import animal, blades, boulder, ground, hills, limb, spaced
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

EYE = (0.6, -10.5, 1.2)
SUN = (-6.0, 23.0)  #: Right of straight ahead and up, in degrees.


def dunes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Heights of the sand: a flat oasis, a long crest behind it, ripples."""
    warp = 7.0 * hills(x / 60 + 4.2, y / 60 + 1.7, 3, 2)
    phase = (y + warp + 0.10 * x - 20.0) / 34.0
    share = phase - np.floor(phase)
    crest = np.where(share < 0.66, (share / 0.66) ** 1.6, ((1 - share) / 0.34) ** 1.1)
    behind = np.clip((y - 2.0 + 0.15 * np.abs(x)) / 26.0, 0.0, 1.0) ** 1.3
    ripples = 0.012 * np.sin(6.5 * y + 1.6 * np.sin(0.9 * x) + 3 * hills(x / 3, y / 3, 8, 2))
    return behind * (5.2 * crest + 1.2 * hills(x / 45, y / 45, 5, 3)) + 0.25 * hills(x / 9, y / 9, 6, 3) + ripples


def palm(
    seed: int, height: float, lean: float, bark: bpy.types.Material, leaf: bpy.types.Material
) -> bpy.types.Collection:
    """A date palm: a ringed trunk that leans along +X, and arching fronds of paired leaflets."""
    random = np.random.default_rng(seed)
    trunk = Shape()
    line, radii = [], []
    for index in range(61):
        t = index / 60
        line.append((lean * t**1.7, 0.15 * sin(3 * t + seed), height * t))
        ring = 0.16 if index % 2 else 0.0
        radii.append((0.24 - 0.09 * t + 0.16 * max(0.0, 0.08 - t) * 8) * (1 + ring))
    limb(trunk, line, radii, 12)
    top = Vector(line[-1])
    crown = Shape()
    for frond in range(34):
        heading = 2.399963 * frond + 0.3 * random.random()
        age = frond / 33
        rise = 1.35 - 1.75 * age + 0.2 * random.normal()  # of its root, in radians: the young stand, the old hang
        reach = random.uniform(2.7, 3.3) * (0.75 + 0.3 * min(1.0, 2 * age))
        out = Vector((cos(heading), sin(heading), 0))
        spine, at, pitch = [top.copy()], top.copy(), rise
        steps = 26
        for _ in range(steps):
            at = at + (out * cos(pitch) + Vector((0, 0, sin(pitch)))) * reach / steps
            pitch -= (0.055 + 0.035 * age) * (1.0 if pitch > -1.2 else 0.15)
            spine.append(at.copy())
        limb(crown, spine, [0.035 * (1 - i / (steps + 1)) + 0.004 for i in range(steps + 1)], 5)
        side = Vector((-out.y, out.x, 0))
        for index in range(3, steps):
            axis = (spine[index + 1] - spine[index]).normalized()
            share = index / steps
            length = 0.62 * sin(pi * (0.18 + 0.74 * share)) ** 0.7
            for half in (0.0, 0.5):
                root = spine[index].lerp(spine[index + 1], half)
                for hand in (-1, 1):
                    sideways = (side * hand + axis * 0.75 + axis.cross(side) * -0.25).normalized()
                    droop = Vector((0, 0, -1)) * (0.16 + 0.1 * random.random())
                    middle = root + (sideways + droop * 0.4) * length * 0.5
                    tip = root + (sideways + droop * 1.5) * length * random.uniform(0.9, 1.1)
                    wide = axis * 0.022
                    crown.add([root, middle + wide, tip, middle - wide], [(0, 1, 2, 3)])
    for _ in range(26):  # dates
        heading = 2 * pi * random.random()
        away = Vector((cos(heading), sin(heading), 0)) * random.uniform(0.2, 0.5)
        crown.ball(top + away + Vector((0, 0, -random.uniform(0.2, 0.7))), (0.05, 0.05, 0.08), 1, 6)
    collection = shared_collection(f"Palm {seed}")
    link(f"Trunk {seed}", trunk.mesh(f"Trunk {seed}", bark, smooth=True), collection)
    link(f"Crown {seed}", crown.mesh(f"Crown {seed}", leaf, bark), collection)
    return collection


def camel(material: bpy.types.Material, cloth: bpy.types.Material) -> bpy.types.Collection:
    """A dromedary with a load, 2.3 m high, that walks along +X."""
    joints: dict[str, tuple[float, ...]] = {
        "rump": (-0.62, 0, 1.35, 0.26), "loin": (-0.3, 0, 1.45, 0.32), "belly": (0.15, 0, 1.36, 0.36),
        "chest": (0.58, 0, 1.36, 0.30), "neck": (0.98, 0, 1.20, 0.16), "throat": (1.28, 0, 1.52, 0.11),
        "poll": (1.42, 0, 2.0, 0.10), "cheek": (1.58, 0, 2.03, 0.10), "nose": (1.86, 0, 1.93, 0.06),
        "hump": (-0.05, 0, 1.95, 0.10), "back": (-0.05, 0, 1.62, 0.30), "tail": (-0.9, 0, 1.2, 0.03),
        "tuft": (-0.95, 0, 0.8, 0.04),
    }  # fmt: skip
    chains = [["rump", "loin", "belly", "chest", "neck", "throat", "poll", "cheek", "nose"], ["back", "hump"]]
    chains.append(["rump", "tail", "tuft"])
    for side, y in (("left", 0.17), ("right", -0.17)):
        stride = 0.22 if side == "left" else -0.22
        for end, hip in (("fore", 0.55), ("hind", -0.6)):
            step = stride if end == "fore" else -stride
            leg = f"{end}_{side}"
            joints |= {
                f"{leg}_hip": (hip, y, 1.2, 0.17), f"{leg}_knee": (hip + step * 0.6, y, 0.68, 0.085),
                f"{leg}_hock": (hip + step * 0.9, y, 0.2, 0.05), f"{leg}_foot": (hip + step + 0.05, y, 0.04, 0.09),
            }  # fmt: skip
            chains.append([f"{leg}_{part}" for part in ("hip", "knee", "hock", "foot")])
    body = animal(joints, chains, 10)
    load = (
        Shape().ball((-0.05, 0.42, 1.5), (0.42, 0.2, 0.34), 0, 12).ball((-0.05, -0.42, 1.5), (0.42, 0.2, 0.34), 0, 12)
    )
    load.ball((-0.05, 0, 1.78), (0.5, 0.4, 0.16), 0, 12)
    collection = shared_collection("Camel")
    link("Camel", body.mesh("Camel", material, smooth=True), collection)
    link("Load", load.mesh("Load", cloth, smooth=True), collection)
    return collection


def leader(cloth: bpy.types.Material) -> bpy.types.Object:
    """A man in a long robe, 1.8 m."""
    robe = Shape().lathe([(0.34, 0.0), (0.26, 0.8), (0.24, 1.3), (0.15, 1.5), (0.06, 1.55)], 14)
    robe.ball((0, 0, 1.66), (0.13, 0.13, 0.15), 0, 12).lathe(
        [(0.17, 1.66), (0.19, 1.74), (0.1, 1.84), (0.01, 1.86)], 12
    )
    limb(robe, [(0.02, 0.2, 1.42), (0.2, 0.3, 1.15), (0.4, 0.26, 1.2)], [0.07, 0.06, 0.04], 8)
    limb(robe, [(0.42, 0.26, 0.0), (0.4, 0.26, 1.9)], [0.018, 0.018], 6)
    return link("Leader", robe.mesh("Leader", cloth, smooth=True))


def height_at(x: float, y: float) -> float:
    """Of the sand."""
    return float(dunes(np.array(x), np.array(y)))


def build() -> None:
    """Put the scene together."""
    clear_file()
    random = np.random.default_rng(5)
    sand = diffuse("Sand", (0.52, 0.36, 0.20))
    x, y = spaced(-110.0, 110.0, 0.0, 0.22, 0.02), spaced(-16.0, 130.0, -12.0, 0.10, 0.012)
    ground("Sand", x, y, dunes(*np.meshgrid(x, y)), sand)
    bark, leaf = diffuse("Bark", (0.20, 0.13, 0.08)), diffuse("Frond", (0.13, 0.19, 0.05))
    palms = [palm(1, 7.2, -1.3, bark, leaf), palm(2, 6.2, 1.0, bark, leaf), palm(3, 8.2, 0.6, bark, leaf)]
    for kind, px, py, turn, scale in (
        (0, 0.9, 0.6, 0, 0.86), (1, -2.6, 3.4, 170, 1.12), (2, 0.4, 5.6, 220, 1.0), (1, 5.6, 4.4, 20, 0.92),
        (2, -9.5, 9.0, 160, 0.95), (1, -11.5, 11.5, 250, 0.9),
        (0, 9.5, 13.0, 200, 1.0), (2, 12.0, 16.0, 60, 0.9), (1, 15.5, 14.0, 100, 1.0), (2, -19.0, 24.0, 0, 1.0),
        (0, 24.0, 30.0, 180, 1.0), (1, 21.0, 27.0, 40, 1.0),
    ):  # fmt: skip
        place = placed((px, py, height_at(px, py) - 0.15), (0, 0, turn), (scale,) * 3)
        instance(palms[kind], place)
    stones = [boulder(random) for _ in range(3)]
    stone_meshes = [
        stone.mesh(f"Stone {i}", diffuse(f"Stone {i}", (0.24, 0.19, 0.14)), smooth=True)
        for i, stone in enumerate(stones)
    ]
    for px, py, size in (
        (-3.2, -8.6, 0.55),
        (-4.2, -8.0, 0.8),
        (-2.5, -8.9, 0.22),
        (3.6, -9.6, 0.3),
        (4.4, -9.2, 0.5),
        (1.6, 0.3, 0.35),
        (-0.4, 1.4, 0.4),
        (-6.5, 6.0, 0.6),
    ):
        place = placed(
            (px, py, height_at(px, py) + 0.05 * size), random.uniform(-20, 360, 3), (size, size * 0.8, size * 0.6)
        )
        link("Stone", stone_meshes[int(random.integers(3))], place=place)
    tufts = []
    for index in range(3):
        collection = shared_collection(f"Tuft {index}")
        made = blades(random, 70, 0.13, 0.6, 0.8, 0.012)
        link(f"Tuft {index}", made.mesh(f"Tuft {index}", diffuse(f"Grass {index}", (0.30, 0.30, 0.10))), collection)
        tufts.append(collection)
    for _ in range(120):
        heading, away = random.uniform(0, 2 * pi), abs(random.normal()) * 3.2 + 0.5
        centre = ((1.5, 1.5), (-3.6, -8.2), (4.2, -9.2), (-9.0, 10.0), (12.0, 14.0))[int(random.integers(5))]
        px, py = centre[0] + away * cos(heading), centre[1] + 0.6 * away * sin(heading)
        if np.hypot(px - EYE[0], py - EYE[1]) > 2.0:
            instance(
                tufts[int(random.integers(3))],
                placed((px, py, height_at(px, py)), (0, 0, random.uniform(0, 360)), (random.uniform(0.6, 1.2),) * 3),
            )
    beast = camel(diffuse("Camel", (0.22, 0.13, 0.07)), diffuse("Load", (0.30, 0.06, 0.05)))
    way = [(px, 13.0 + 0.2 * px) for px in (2.6, 5.3, 8.3, 11.4)]
    for px, py in way:
        crest_y = max(np.linspace(py - 1, py + 5, 60), key=lambda at, px=px: height_at(px, at))
        instance(
            beast,
            placed((px, crest_y, height_at(px, crest_y) - 0.05), (0, 0, 180 + random.uniform(-6, 6)), (1.25,) * 3),
        )
    crest_y = max(np.linspace(11, 18, 60), key=lambda at: height_at(0.5, at))
    man = leader(diffuse("Robe", (0.25, 0.2, 0.3)))
    man.matrix_world = placed((0.5, crest_y, height_at(0.5, crest_y)), (0, 0, 180))
    star = sun("Sun", tuple(towards(*SUN)), 6.5, (1.0, 0.52, 0.20), 0.25)
    edit_occluders(star, "CLOSE", size_m=0.8)
    world((0.34, 0.42, 0.80), 0.10)
    fog_box((-30, -15.5, -6.0), (35, 7, 10.0), 0.042, (1.0, 0.97, 0.93), 0.72)
    camera(EYE, (0.6, 0.5, 3.5), 24.0)
    bpy.context.scene.tyndall.shafts.resolution = 4096
    set_up(view="Filmic", look="High Contrast", exposure=0.0)


if __name__ == "__main__":
    build()
    save(__file__)
