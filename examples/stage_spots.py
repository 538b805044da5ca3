# SPDX-License-Identifier: GPL-3.0-or-later
"""A small stage just before the concert: a drum kit in the haze, spot lights on two trusses, the first rows waiting.

Run as ``blender -b --factory-startup --python examples/stage_spots.py``; writes stage_spots.blend beside itself.
"""

from __future__ import annotations

import sys
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).resolve().parent))
from scene_kit import (
    Rgb,
    Shape,
    camera,
    clear_file,
    diffuse,
    emission,
    finish,
    fog_box,
    instance,
    link,
    placed,
    point_light,
    shared_collection,
    spot_light,
    world,
)

AMBER: Rgb = (1.0, 0.56, 0.20)
TEAL: Rgb = (0.10, 0.75, 0.95)
BLUE: Rgb = (0.13, 0.27, 1.0)
MAGENTA: Rgb = (1.0, 0.12, 0.55)
WHITE: Rgb = (1.0, 0.90, 0.76)

STAGE_TOP = 1.1
REAR_TRUSS = (4.6, 6.4)  #: Distance behind the stage's front edge, and height.
FRONT_TRUSS = (0.6, 6.6)
SPOTS = (
    # name, truss, across, aims at, W, colour, cone in degrees
    ("Back 1", REAR_TRUSS, -4.6, (-6.2, -3.0, 0.6), 6000, TEAL, 10),
    ("Back 2", REAR_TRUSS, -2.9, (-3.4, -3.2, 0.6), 6500, BLUE, 11),
    ("Back 3", REAR_TRUSS, -1.2, (-0.5, 1.6, 1.2), 4200, AMBER, 16),
    ("Back 4", REAR_TRUSS, 1.2, (0.5, 1.6, 1.2), 4200, AMBER, 16),
    ("Back 5", REAR_TRUSS, 2.9, (3.4, -3.2, 0.6), 6500, BLUE, 11),
    ("Back 6", REAR_TRUSS, 4.6, (6.2, -3.0, 0.6), 6000, TEAL, 10),
    ("Key", FRONT_TRUSS, -3.6, (0.1, 2.8, 2.0), 4200, WHITE, 16),
    ("Side", FRONT_TRUSS, 3.9, (-3.0, 3.6, 1.4), 5200, MAGENTA, 17),
)


def truss(length: float, width: float = 0.32) -> Shape:
    """A box truss along X, centred: four chords and zigzag braces on each side."""
    shape = Shape()
    corners = [(y * width / 2, z * width / 2) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    bays = round(length / (width * 1.2))
    xs = np.linspace(-length / 2, length / 2, bays + 1)
    for (y0, z0), (y1, z1) in zip(corners, corners[1:] + corners[:1], strict=True):
        shape.tube((-length / 2, y0, z0), (length / 2, y0, z0), 0.025)
        for bay in range(bays):
            a, b = ((y0, z0), (y1, z1)) if bay % 2 else ((y1, z1), (y0, z0))
            shape.tube((xs[bay], *a), (xs[bay + 1], *b), 0.011, 6)
    return shape


def lamp_housing() -> Shape:
    """A PAR can that shines along -Z from its origin: an open can around the light, and its yoke."""
    sides, shape = 20, Shape()
    rings = [(0.13, -0.16), (0.13, 0.12), (0.07, 0.24), (0.02, 0.26)]
    points = [
        (r * cos(2 * pi * side / sides), r * sin(2 * pi * side / sides), z) for r, z in rings for side in range(sides)
    ]
    faces = [
        (
            ring * sides + side,
            ring * sides + (side + 1) % sides,
            (ring + 1) * sides + (side + 1) % sides,
            (ring + 1) * sides + side,
        )
        for ring in range(len(rings) - 1)
        for side in range(sides)
    ]
    shape.add(points, faces)
    for x in (-0.155, 0.155):
        shape.box((x - 0.008, -0.02, -0.02), (x + 0.008, 0.02, 0.36))
    return shape.box((-0.163, -0.02, 0.345), (0.163, 0.02, 0.361))


def drum(radius: float, depth: float) -> Shape:
    """A drum along Z from 0 to depth: shell (slot 0), hoops (slot 1), heads (slot 2)."""
    shape = Shape().lathe([(radius, 0.0), (radius, depth)], 40)
    for height in (0.0, depth):
        shape.lathe(
            [
                (radius * 1.02, height - 0.018),
                (radius * 1.035, height),
                (radius * 1.02, height + 0.018),
            ],
            40,
            1,
        )
    return shape.lathe([(radius * 0.985, -0.002), (radius * 0.985, depth + 0.020)], 40, 2)


def cymbal(radius: float) -> Shape:
    """A thin bell-shaped plate around Z."""
    return Shape().lathe(
        [
            (radius, 0.0),
            (radius * 0.5, radius * 0.07),
            (radius * 0.18, radius * 0.10),
            (radius * 0.13, radius * 0.2),
            (0.01, radius * 0.22),
        ],
        40,
    )


def stand(x: float, y: float, height: float) -> Shape:
    """A tripod with a pole."""
    shape = Shape().tube((x, y, 0.05), (x, y, height), 0.014)
    for leg in range(3):
        angle = 2 * pi * leg / 3 + 0.4
        shape.tube((x, y, 0.32), (x + 0.26 * cos(angle), y + 0.26 * sin(angle), 0.0), 0.011)
    return shape


def drum_kit(
    red: bpy.types.Material, chrome: bpy.types.Material, skin: bpy.types.Material, brass: bpy.types.Material
) -> None:
    """Kick, snare, toms and cymbals on a riser behind the stage's middle."""
    base = Matrix.Translation((0.0, 2.9, STAGE_TOP + 0.36))
    pieces = (
        (
            "Kick",
            drum(0.30, 0.44),
            placed((0.0, -0.55, 0.30), (90, 0, 0)) @ Matrix.Translation((0, 0, -0.2)),
        ),
        ("Snare", drum(0.18, 0.15), placed((-0.42, 0.10, 0.62), (8, 0, 0))),
        ("Tom 1", drum(0.15, 0.22), placed((-0.20, -0.38, 0.78), (16, 4, 0))),
        ("Tom 2", drum(0.17, 0.24), placed((0.22, -0.38, 0.78), (16, -4, 0))),
        ("Floor Tom", drum(0.22, 0.40), placed((0.62, 0.12, 0.26))),
    )
    for name, shape, place in pieces:
        link(name, shape.mesh(name, red, chrome, skin), place=base @ place)
    for name, radius, at, tilt in (
        ("Hi-Hat", 0.18, (-0.86, -0.05, 0.92), (0, 0, 0)),
        ("Crash", 0.23, (-0.66, -0.52, 1.42), (14, 12, 0)),
        ("Ride", 0.27, (0.74, -0.45, 1.30), (16, -14, 0)),
        ("Splash", 0.15, (0.05, -0.62, 1.34), (12, 0, 0)),
    ):
        link(
            name,
            cymbal(radius).mesh(name, brass, smooth=True),
            place=base @ placed(at, tilt),
        )
        link(
            f"{name} Stand",
            stand(at[0], at[1], at[2]).mesh(f"{name} Stand", chrome),
            place=base,
        )
    throne = Shape().lathe([(0.17, 0.48), (0.18, 0.52), (0.16, 0.58)], 24).tube((0, 0, 0), (0, 0, 0.5), 0.02)
    link(
        "Throne",
        throne.mesh("Throne", chrome),
        place=base @ Matrix.Translation((0.05, 0.55, 0)),
    )


def listener(seed: int, *, raised_arm: bool) -> Shape:
    """Someone in the first rows, seen from behind: head, shoulders, perhaps an arm in the air."""
    random = np.random.default_rng(seed)
    height = 1.62 + 0.16 * random.random()
    shape = Shape().ball((0, 0, height), (0.095, 0.11, 0.135))
    shape.lathe([(0.06, height - 0.26), (0.055, height - 0.1)], 12)
    shoulders = Matrix.Diagonal((1.0, 0.62, 1.0, 1.0))
    shape.lathe(
        [
            (0.17, 0.0),
            (0.19, 0.9),
            (0.24, height - 0.45),
            (0.22, height - 0.29),
            (0.08, height - 0.2),
        ],
        20,
        0,
        shoulders,
    )
    if raised_arm:
        side = 1 if random.random() < 0.5 else -1
        elbow = (side * 0.33, -0.02, height - 0.02)
        hand = (side * 0.24, 0.04, height + 0.33)
        shape.tube((side * 0.22, 0, height - 0.33), elbow, 0.052).tube(elbow, hand, 0.04).ball(
            hand, (0.05, 0.04, 0.075)
        )
    else:
        for side in (-1, 1):
            shape.tube((side * 0.24, 0, height - 0.33), (side * 0.29, 0, height - 0.8), 0.055)
    return shape


def curtain(material: bpy.types.Material) -> None:
    """The back cloth, in folds."""
    xs = np.linspace(-14.0, 14.0, 561)
    ys = 6.2 + 0.16 * np.sin(xs * 7.0) + 0.06 * np.sin(xs * 17.0 + 1.0)
    points = [(x, y, z) for z in (0.0, 11.0) for x, y in zip(xs, ys, strict=True)]
    faces = [(i, i + 1, i + 1 + len(xs), i + len(xs)) for i in range(len(xs) - 1)]
    link("Curtain", Shape().add(points, faces).mesh("Curtain", material, smooth=True))


def stage(boards: bpy.types.Material, black: bpy.types.Material, steel: bpy.types.Material) -> None:
    """Floor, stage and trusses."""
    link("Stage", Shape().box((-6.5, 0.0, 0.0), (6.5, 6.5, STAGE_TOP)).mesh("Stage", boards))
    link("Riser", Shape().box((-1.5, 1.9, STAGE_TOP), (1.5, 4.1, STAGE_TOP + 0.36)).mesh("Riser", black))
    link("Floor", Shape().box((-15, -14, -0.2), (15, 7, 0.0)).mesh("Floor", black))
    for name, (y, z) in (("Rear Truss", REAR_TRUSS), ("Front Truss", FRONT_TRUSS)):
        link(name, truss(11.2).mesh(name, steel), place=Matrix.Translation((0, y, z + 0.62)))
    for x in (-5.5, 5.5):
        upright = placed((x, REAR_TRUSS[0], 3.9), (0, 90, 0))
        link("Upright", truss(6.4).mesh("Upright", steel), place=upright)


def backline(black: bpy.types.Material, chrome: bpy.types.Material) -> None:
    """Loudspeakers, guitar amplifiers, microphones."""
    for x in (-4.9, 4.9):
        stack = Shape()
        for level in range(3):
            low = STAGE_TOP + 0.66 * level
            stack.box((x - 0.45, 1.0, low), (x + 0.45, 1.7, low + 0.62))
        link("Loudspeaker", stack.mesh("Loudspeaker", black))
    for x, y in ((-2.6, 3.4), (2.7, 3.5)):
        amplifier = Shape().box((x - 0.38, y, STAGE_TOP), (x + 0.38, y + 0.36, STAGE_TOP + 0.78))
        amplifier.box((x - 0.36, y + 0.04, STAGE_TOP + 0.8), (x + 0.36, y + 0.3, STAGE_TOP + 1.05))
        link("Amplifier", amplifier.mesh("Amplifier", black))
    for x, y, lean in ((-1.75, 0.9, 0.1), (1.7, 1.0, -0.1)):
        microphone = stand(x, y, 1.5).tube((x, y, 1.5), (x + lean, y - 0.25, 1.62), 0.012)
        microphone.ball((x + lean, y - 0.27, 1.63), (0.035, 0.05, 0.035))
        link("Microphone", microphone.mesh("Microphone", chrome), place=Matrix.Translation((0, 0, STAGE_TOP)))


def lights(black: bpy.types.Material) -> None:
    """The spots in their housings, and what keeps the room readable where no spot goes."""
    can = lamp_housing().mesh("Lamp", black)
    lens = {}
    for name, (y, z), x, target, watt, colour, cone in SPOTS:
        light = spot_light(name, (x, y, z), target, watt, colour, cone)
        link(f"{name} Lamp", can, place=light.matrix_world)
        if colour not in lens:
            disc = Shape().lathe([(0.115, 0.0), (0.115, 0.004)], 24)
            lens[colour] = disc.mesh("Lens", emission("Lens", colour, 6.0))
        shown = link(f"{name} Lens", lens[colour], place=light.matrix_world @ Matrix.Translation((0, 0, 0.06)))
        shown.visible_volume_scatter = False
    for x, colour in ((-4.2, BLUE), (0.0, MAGENTA), (4.2, BLUE)):
        point_light("Uplight", (x, 5.5, STAGE_TOP + 0.25), 90, colour, 0.06)
    for x in (-3.4, 0.0, 3.4):  # inside the rear truss, so that it shows
        point_light("Truss Glow", (x, REAR_TRUSS[0] - 0.02, REAR_TRUSS[1] + 0.62), 22, TEAL, 0.05)


def audience(people: bpy.types.Material) -> None:
    """Four rows, of seven kinds of listeners."""
    crowd = []
    for seed in range(7):
        crowd.append(shared_collection(f"Listener {seed}"))
        mesh = listener(seed, raised_arm=seed in (2, 5)).mesh("Listener", people, smooth=True)
        link(f"Listener {seed}", mesh, crowd[-1])
    random = np.random.default_rng(11)
    for row in range(4):
        for seat in range(-8, 9):
            x = (seat + 0.5 * (row % 2)) * 0.78 + 0.2 * (random.random() - 0.5)
            y = -1.9 - 0.85 * row + 0.25 * (random.random() - 0.5)
            if row == 3 and abs(x) < 1.0:
                continue  # keeps the camera's view of the drums open
            place = placed((x, y, -0.05 * random.random()), (0, 0, random.normal() * 14))
            instance(crowd[random.integers(len(crowd))], place)


def build() -> None:
    """Put the scene together."""
    clear_file()
    black = diffuse("Black Metal", (0.035, 0.036, 0.04))
    chrome = diffuse("Chrome", (0.55, 0.56, 0.58))
    stage(diffuse("Stage Boards", (0.16, 0.13, 0.11)), black, diffuse("Truss Steel", (0.42, 0.43, 0.45)))
    curtain(diffuse("Curtain", (0.16, 0.03, 0.05)))
    red, brass = diffuse("Red Shell", (0.62, 0.035, 0.03)), diffuse("Brass", (0.80, 0.55, 0.20))
    drum_kit(red, chrome, diffuse("Drum Head", (0.82, 0.80, 0.76)), brass)
    backline(black, chrome)
    lights(black)
    audience(diffuse("People", (0.22, 0.20, 0.22)))
    world((0.10, 0.13, 0.25), 0.12)
    fog_box((-8.5, -8.5, 0.02), (8.5, 5.9, 8.2), 0.05, (0.98, 0.98, 1.0), 0.3)
    camera((0.9, -7.2, 2.15), (0.05, 2.6, 3.15), 28.0)
    finish(__file__, view="Filmic", look="Medium High Contrast", exposure=1.0)


build()
