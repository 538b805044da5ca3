# SPDX-License-Identifier: GPL-3.0-or-later
"""A tyrannosaur in a museum's hall: the air has a texture, and paint makes it even where it hides the skeleton.

After figure 5.18 of Kol, dissertation, TU Delft 2018. Needs the add-on: run as
``scripts/blender -b --python examples/skeleton_hall.py``; writes skeleton_hall.blend beside itself.
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
from nature_kit import limb
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
    point_light,
    save,
    set_up,
    shared_collection,
    sun,
    towards,
    world,
)
from skeleton_kit import tyrannosaur

EYE, TARGET = (-5.2, -10.0, 1.6), (0.75, 3.0, 4.15)
SUN = (62.0, 34.0)  #: Right of straight ahead and up, in degrees.
HALF, LENGTH, BAY = 8.0, 54.0, 6.0  #: Half the width across X, from Y = -18 on, from pier to pier, metres.
BEGIN = -18.0
FIRST_LIT = 0.0  #: Blinds are drawn before the right windows on this side of it: the air before the camera is dark.
GALLERY, CORNICE = 5.4, 12.0  #: Heights.


def arched_wall(
    shape: Shape, half: float, low: float, high: float, opening: tuple[float, float, float], depth: float, slot: int = 0
) -> None:
    """A wall in the plane X = 0 to depth, along Y, with an opening (half its width, sill, spring of its round arch)."""
    wide, sill, spring = opening
    arch = [(wide * cos(a), spring + wide * sin(a)) for a in np.linspace(0, pi, 17)]
    for x, order in ((0.0, 1), (depth, -1)):
        flat = [
            [(-half, low), (-wide, low), (-wide, high), (-half, high)],
            [(wide, low), (half, low), (half, high), (wide, high)],
            *([a, (a[0], high), (b[0], high), b] for a, b in pairwise(arch)),
        ]
        if sill > low:
            flat.append([(-wide, low), (wide, low), (wide, sill), (-wide, sill)])
        for polygon in flat:
            shape.add([(x, along, up) for along, up in polygon], [tuple(range(4))[::order]], slot)
    rim = [(wide, sill), *arch, (-wide, sill)]
    for a, b in pairwise([*rim, rim[0]]):
        shape.add([(0, *a), (0, *b), (depth, *b), (depth, *a)], [(0, 1, 2, 3)], slot)


def bay(stone: bpy.types.Material, trim: bpy.types.Material, iron: bpy.types.Material) -> bpy.types.Mesh:
    """One bay of the hall's right wall, whose inside is X = 0 and whose outside is +X."""
    shape, half = Shape(), BAY / 2
    arched_wall(shape, half, 0.0, GALLERY, (1.75, 0.0, 2.9), 1.6)
    shape.add([(1.6, -half, 0), (1.6, half, 0), (1.6, half, GALLERY), (1.6, -half, GALLERY)], [(0, 1, 2, 3)])
    arched_wall(shape, half, GALLERY, CORNICE, (1.75, 6.5, 9.3), 0.9)
    for along in (-half, half):  # piers, and the shafts that the vault's ribs stand on
        shape.box((-0.45, along - 0.55, 0), (0.0, along + 0.55, 0.5), 1)
        shape.box((-0.35, along - 0.45, 0.5), (0.0, along + 0.45, GALLERY - 0.3), 0)
        place = Matrix.Translation((-0.35, along, 0))
        shape.lathe([(0.26, GALLERY), (0.2, GALLERY + 0.4), (0.18, CORNICE - 0.9), (0.36, CORNICE - 0.2)], 14, 1, place)
    shape.box((-1.5, -half, GALLERY - 0.35), (0.0, half, GALLERY), 1)
    for low, high in ((GALLERY, GALLERY + 0.12), (GALLERY + 0.95, GALLERY + 1.08)):
        shape.box((-1.5, -half, low), (-1.36, half, high), 1)
    for along in np.arange(-half + 0.15, half, 0.3):
        profile = [(0.045, 0.12), (0.075, 0.35), (0.04, 0.6), (0.05, 0.95)]
        shape.lathe(profile, 8, 1, Matrix.Translation((-1.43, along, GALLERY)))
    for along in (-half + 0.02, half - 0.62):
        points = [(-1.35, 0, GALLERY - 0.35), (0, 0, GALLERY - 0.35), (0, 0, GALLERY - 1.5), (-0.4, 0, GALLERY - 0.9)]
        for side in (0.0, 0.6):
            shape.add([(x, along + side, z) for x, _, z in points], [(0, 1, 2, 3)], 1)
        shape.add([(x, along + side, z) for side in (0.0, 0.6) for x, _, z in points], [(2, 3, 7, 6), (3, 0, 4, 7)], 1)
    shape.box((-0.4, -half, CORNICE - 0.2), (0.9, half, CORNICE + 0.3), 1)
    for along in (-0.6, 0.6):
        shape.box((0.4, along - 0.06, 6.5), (0.5, along + 0.06, 10.9), 2)
    for up in (7.4, 8.35, 9.3):
        shape.box((0.42, -1.75, up - 0.04), (0.48, 1.75, up + 0.04), 2)
    for a, b in pairwise([(0.45, 1.0 * cos(t), 9.3 + 1.0 * sin(t)) for t in np.linspace(0, pi, 13)]):
        shape.tube(a, b, 0.05, 5, 2)
    return shape.mesh("Bay", stone, trim, iron)


def end_wall(stone: bpy.types.Material, iron: bpy.types.Material) -> bpy.types.Mesh:
    """With one great window; turned so that it looks along the hall."""
    shape = Shape()
    arched_wall(shape, HALF, 0.0, CORNICE + HALF, (4.2, 5.4, 10.5), 0.9)
    for along in (-2.1, 0.0, 2.1):
        shape.box((0.4, along - 0.11, 5.4), (0.6, along + 0.11, 14.4), 1)
    for up in (7.0, 8.75, 10.5):
        shape.box((0.42, -4.2, up - 0.06), (0.55, 4.2, up + 0.06), 1)
    for radius in (1.5, 2.9):
        for a, b in pairwise([(0.5, radius * cos(t), 10.5 + radius * sin(t)) for t in np.linspace(0, pi, 17)]):
            shape.tube(a, b, 0.08, 6, 1)
    shape.box((-1.5, -HALF, 4.9), (0.0, HALF, 5.4), 0)
    return shape.mesh("End", stone, iron)


def vault(plaster: bpy.types.Material, trim: bpy.types.Material) -> None:
    """A barrel, with a rib over each pier."""
    shape = Shape()
    arc = [(HALF * cos(a), CORNICE + 0.3 + 0.62 * HALF * sin(a)) for a in np.linspace(0, pi, 25)]
    end = BEGIN + LENGTH
    for (xa, za), (xb, zb) in pairwise(arc):
        shape.add([(xa, BEGIN, za), (xb, BEGIN, zb), (xb, end, zb), (xa, end, za)], [(0, 1, 2, 3)])
    for along in np.arange(BEGIN, end + 1, BAY):
        rib_line = [(x * 0.97, along, z - 0.12) for x, z in arc]
        limb(shape, rib_line, [0.26] * len(rib_line), 6, 1)
    link("Vault", shape.mesh("Vault", plaster, trim))


def visitor(
    height: float, cloth: bpy.types.Material, skin: bpy.types.Material, *, points: bool = False
) -> bpy.types.Mesh:
    """Someone in a coat, who looks up, along +Y."""
    shape, h = Shape(), height
    for hand in (-1, 1):
        limb(shape, [(hand * 0.055 * h, 0, 0.0), (hand * 0.05 * h, 0, 0.28 * h), (hand * 0.05 * h, 0, 0.5 * h)],
             [0.035 * h, 0.04 * h, 0.055 * h])  # fmt: skip
        shape.ball((hand * 0.055 * h, 0.03 * h, 0.02 * h), (0.03 * h, 0.07 * h, 0.02 * h), 0, 10)
        is_raised = points and hand > 0
        hand_at = (0.2 * h, 0.22 * h, 0.98 * h) if is_raised else (hand * 0.15 * h, 0.03 * h, 0.44 * h)
        elbow = (hand * 0.14 * h, 0.02 * h, (0.86 if is_raised else 0.62) * h)
        limb(shape, [(hand * 0.1 * h, 0, 0.79 * h), elbow, hand_at], [0.045 * h, 0.036 * h, 0.025 * h])
        shape.ball(hand_at, (0.026 * h,) * 3, 1, 8)
    shape.lathe([(0.13, 0.3), (0.115, 0.42), (0.1, 0.55), (0.115, 0.7), (0.11, 0.78), (0.045, 0.83)], 16, 0,
                Matrix.Diagonal((h, 0.72 * h, h, 1.0)))  # fmt: skip
    limb(shape, [(0, 0, 0.8 * h), (0, 0.0, 0.88 * h)], [0.04 * h, 0.035 * h], 8, 1)
    shape.ball((0, 0.012 * h, 0.93 * h), (0.052 * h, 0.062 * h, 0.07 * h), 1, 14)
    shape.ball((0, -0.012 * h, 0.945 * h), (0.057 * h, 0.06 * h, 0.066 * h), 0, 14)
    return shape.mesh("Visitor", cloth, skin, smooth=True)


def floor(light: bpy.types.Material, dark: bpy.types.Material) -> None:
    """Slabs of two kinds."""
    shape = Shape()
    for row in range(int(LENGTH)):
        for column in range(int(2 * HALF)):
            x, y = column - HALF, BEGIN + row
            is_dark = (row + column) % 2 == 0 and 2 <= column < 2 * HALF - 2
            shape.add([(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)], [(0, 1, 2, 3)], int(is_dark))
    shape.box((-HALF - 2, BEGIN, -0.3), (HALF + 2, BEGIN + LENGTH, -0.02))
    link("Floor", shape.mesh("Floor", light, dark))


def hall() -> None:
    """Two walls of bays, ends, vault and floor."""
    stone, trim = diffuse("Stone", (0.47, 0.39, 0.31)), diffuse("Trim", (0.56, 0.49, 0.40))
    iron = diffuse("Iron", (0.04, 0.04, 0.045))
    one = shared_collection("Bay")
    link("Bay", bay(stone, trim, iron), one)
    blinds = Shape()
    for index in range(round(LENGTH / BAY)):
        along = BEGIN + BAY * (index + 0.5)
        instance(one, placed((HALF, along, 0)))
        instance(one, placed((-HALF, along, 0), (0, 0, 180)))
        if along < FIRST_LIT:
            blinds.box((HALF + 0.3, along - 1.9, 6.3), (HALF + 0.36, along + 1.9, 11.3))
    link("Blinds", blinds.mesh("Blinds", diffuse("Linen", (0.30, 0.24, 0.16))))
    end = end_wall(stone, iron)
    link("End", end, place=placed((0, BEGIN + LENGTH, 0), (0, 0, 90)))
    link("Entrance", Shape().box((-HALF, BEGIN - 0.9, 0), (HALF, BEGIN, 20)).mesh("Entrance", stone))
    vault(diffuse("Plaster", (0.50, 0.45, 0.38)), trim)
    floor(diffuse("Pale Slab", (0.50, 0.44, 0.36)), diffuse("Dark Slab", (0.20, 0.17, 0.15)))


def exhibits() -> None:
    """The skeleton on its plinth, a rope around it, and who came to see it."""
    marble, brass = diffuse("Marble", (0.26, 0.22, 0.19)), diffuse("Brass", (0.42, 0.28, 0.10))
    place = placed((-0.2, 0.8, 0.62), (0, 0, -18), (1.22,) * 3)
    link("Tyrannosaur", tyrannosaur(), place=place)
    plinth = Shape().box((-4.2, -2.0, 0.0), (4.8, 2.2, 0.55)).box((-4.35, -2.15, 0.0), (4.95, 2.35, 0.14))
    for x, y, z in ((-0.1, 0.0, 3.85), (2.3, 0.0, 4.2), (-4.6, 0.97, 3.6)):
        plinth.tube((x, y, 0.5), (x, y, z), 0.035, 8, 1)
    turn = placed((-0.2, 0.8, 0.0), (0, 0, -18), (1.22,) * 3)
    link("Plinth", plinth.mesh("Plinth", marble, diffuse("Steel", (0.06, 0.06, 0.06))), place=turn)
    rope = Shape()
    posts = [turn @ Vector((x, -3.1, 0)) for x in np.linspace(-4.6, 5.2, 6)]
    for post in posts:
        rope.lathe([(0.16, 0.0), (0.15, 0.03), (0.03, 0.06), (0.03, 0.92), (0.06, 0.97), (0.02, 1.04)], 12, 0,
                   Matrix.Translation((post.x, post.y, 0)))  # fmt: skip
    for a, b in pairwise(posts):
        sag = [a.lerp(b, t) + Vector((0, 0, 0.88 - 0.9 * t * (1 - t))) for t in np.linspace(0, 1, 9)]
        limb(rope, sag, [0.028] * 9, 6, 1)
    link("Rope", rope.mesh("Rope", brass, diffuse("Velvet", (0.22, 0.02, 0.03))))
    skin = diffuse("Skin", (0.45, 0.28, 0.20))
    for x, y, turn_degrees, height, colour in (
        (-4.3, -3.6, -38, 1.78, (0.025, 0.03, 0.045)),
        (-3.65, -3.9, -30, 1.16, (0.45, 0.08, 0.05)),
        (5.6, 14.0, 30, 1.7, (0.10, 0.10, 0.12)),
        (-5.4, 17.0, -60, 1.75, (0.16, 0.11, 0.08)),
    ):
        made = visitor(height, diffuse("Coat", colour), skin, points=height < 1.5)
        link("Visitor", made, place=placed((x, y, 0), (0, 0, turn_degrees)))


def lights() -> None:
    """The sun through the right windows; what stone would send back into the hall is lit by hand."""
    sun("Sun", tuple(towards(*SUN)), 42.0, (1.0, 0.80, 0.54), 0.4)
    for place, watt in (
        ((-5.0, -6.0, 1.5), 420),
        ((-5.5, 6.0, 2.0), 420),
        ((-4.0, 20.0, 3.0), 500),
        ((0.0, 30.0, 8.0), 400),
    ):
        bounce = point_light("Bounce", place, watt, (1.0, 0.78, 0.56), 1.0)
        bounce.data.tyndall.scatters_in_media = False
    world((0.42, 0.60, 1.0), 1.1)


def paint() -> None:
    """Wisps everywhere; then, through the camera, even air around the skeleton, and more light on its head."""
    air = bpy.context.scene.tyndall.heterogeneity
    air.is_enabled, air.scale_m, air.octaves, air.persistence, air.contrast = True, 5.0, 6, 0.55, 4.0
    bpy.ops.tyndall.add_painted_box(voxels=160)
    view = (Vector(EYE) - Vector(TARGET)).normalized()
    body = [(-6.5, 3.0, 4.2), (-3.0, 1.6, 4.3), (0.0, 0.7, 4.6), (2.5, 0.0, 5.0), (4.2, -0.5, 6.4)]
    paint_air(body, "AMOUNT", -1.0, 2.3, normal=view, depth=5.0, hardness=0.5)
    paint_air(body[2:], "INTENSITY", 1.5, 2.6, normal=view, depth=3.0, hardness=0.2)


def build() -> None:
    """Put the scene together."""
    clear_file()
    hall()
    exhibits()
    lights()
    low, high = (-HALF + 0.01, BEGIN + 0.01, 0.01), (HALF + 0.88, BEGIN + LENGTH - 0.01, CORNICE + 6.0)
    fog_box(low, high, 0.016, (1.0, 0.97, 0.92), 0.45)
    camera(EYE, TARGET, 22.0)
    paint()
    bpy.context.scene.tyndall.shafts.resolution = 4096
    set_up(view="Filmic", look="Medium High Contrast", exposure=0.7)


if __name__ == "__main__":
    build()
    save(__file__)
