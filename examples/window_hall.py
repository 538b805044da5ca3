# SPDX-License-Identifier: GPL-3.0-or-later
"""A stone hall in the late afternoon: sun through a row of tall windows, dust in the air, a long table, two lanterns.

Run as ``blender -b --factory-startup --python examples/window_hall.py``; writes window_hall.blend beside itself.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from scene_kit import (
    Shape,
    camera,
    clear_file,
    diffuse,
    emission,
    finish,
    fog_box,
    instance,
    link,
    packed_image,
    placed,
    point_light,
    shared_collection,
    sun,
    world,
)

LENGTH, WIDTH, HEIGHT = 36.0, 11.0, 10.0  #: Along Y, across X, up to the beams, metres.
BAY = 4.5  #: From column to column.
BAYS = round(LENGTH / BAY)
SILL, SPRING, HALF_OPENING = (
    2.0,
    6.6,
    0.85,
)  #: A window: sill, where its arch begins, half its width.
WALL = 0.7  #: Thickness.


def slabs(size_px: int = 512, tiles: int = 8) -> np.ndarray:
    """Stone slabs with joints, each of its own shade, float32 (size, size, 4) in sRGB."""
    random = np.random.default_rng(3)
    y, x = np.mgrid[0:size_px, 0:size_px] / size_px * tiles
    x = x + 0.5 * (y.astype(int) % 2)
    shade = 0.52 + 0.13 * random.random((tiles, tiles))[y.astype(int) % tiles, x.astype(int) % tiles]
    grain = random.normal(size=(size_px, size_px))
    for _ in range(4):
        grain = (grain + np.roll(grain, 1, 0) + np.roll(grain, 1, 1) + np.roll(grain, (1, 1), (0, 1))) / 4
    joint = (np.minimum(np.abs(x - np.round(x)), np.abs(y - np.round(y))) < 0.018).astype(float)
    grey = (shade + 0.10 * grain) * (1 - 0.45 * joint)
    return np.stack([grey, grey * 0.93, grey * 0.83, np.ones_like(grey)], axis=-1).astype(np.float32)


def arch_outline(half: float, sill: float, spring: float, steps: int = 16) -> list[tuple[float, float]]:
    """Pointed arch, counter-clockwise from the left of the sill: (along, up)."""
    radius = 2 * half  # each side is an arc around the other side's spring
    right = [(half - radius + radius * cos(a), spring + radius * sin(a)) for a in np.linspace(0, pi / 3, steps)]
    left = [(-along, up) for along, up in reversed(right[:-1])]
    return [(-half, sill), (half, sill), *right, *left]


def window_bay() -> Shape:
    """One bay of the window wall in the plane X = 0 (inside) to -WALL, centred on Y = 0, with mullions."""
    shape, steps = Shape(), 16
    outline = arch_outline(HALF_OPENING, SILL, SPRING, steps)
    for depth, order in ((0.0, 1), (-WALL, -1)):
        # Below, beside and above the opening; above it, strips from the arch up to the wall's top.
        flat = [
            [(-BAY / 2, 0), (BAY / 2, 0), (BAY / 2, SILL), (-BAY / 2, SILL)],
            [
                (-BAY / 2, SILL),
                (-HALF_OPENING, SILL),
                (-HALF_OPENING, HEIGHT),
                (-BAY / 2, HEIGHT),
            ],
            [
                (HALF_OPENING, SILL),
                (BAY / 2, SILL),
                (BAY / 2, HEIGHT),
                (HALF_OPENING, HEIGHT),
            ],
        ]
        arch = outline[2:]
        flat += [[a, (a[0], HEIGHT), (b[0], HEIGHT), b] for a, b in pairwise(arch)]
        for polygon in flat:
            shape.add(
                [(depth, along, up) for along, up in polygon],
                [tuple(range(4))[::order]],
            )
    # The reveal: splayed, as stone windows are, so that it catches the sun.
    for a, b in zip(outline, outline[1:] + outline[:1], strict=True):
        shape.add([(0, *a), (0, *b), (-WALL, *b), (-WALL, *a)], [(0, 1, 2, 3)])
    x = -WALL * 0.55
    apex = SPRING + 2 * HALF_OPENING * sin(pi / 3)
    for along in (-HALF_OPENING / 3, HALF_OPENING / 3):
        shape.box((x - 0.06, along - 0.045, SILL), (x + 0.06, along + 0.045, SPRING + 1.35), 1)
    for up in np.arange(SILL + 0.85, SPRING, 0.85):
        shape.box(
            (x - 0.03, -HALF_OPENING, up - 0.022),
            (x + 0.03, HALF_OPENING, up + 0.022),
            1,
        )
    shape.box(
        (x - 0.06, -HALF_OPENING, SPRING - 0.06),
        (x + 0.06, HALF_OPENING, SPRING + 0.06),
        1,
    )
    centre, ring, turns = (
        (SPRING + apex) / 2 - 0.05,
        0.5,
        28,
    )  # tracery: a ring under the point
    for turn in range(turns):
        a, b = 2 * pi * turn / turns, 2 * pi * (turn + 1) / turns
        shape.tube(
            (x, ring * cos(a), centre + ring * sin(a)),
            (x, ring * cos(b), centre + ring * sin(b)),
            0.05,
            6,
            1,
        )
    return shape.box((-WALL, -HALF_OPENING - 0.1, SILL - 0.12), (0.16, HALF_OPENING + 0.1, SILL), 1)


def column() -> Shape:
    """A round column with base and capital."""
    profile = [
        (0.52, 0.0), (0.52, 0.22), (0.44, 0.30), (0.46, 0.40), (0.36, 0.48), (0.33, 0.55),
        (0.30, HEIGHT - 2.2), (0.36, HEIGHT - 2.12), (0.31, HEIGHT - 2.0), (0.40, HEIGHT - 1.75), (0.55, HEIGHT - 1.5),
    ]  # fmt: skip
    shape = Shape().lathe(profile, 32)
    return shape.box((-0.58, -0.58, HEIGHT - 1.5), (0.58, 0.58, HEIGHT - 1.25))


def roof_frame() -> Shape:
    """A timber truss across the hall at Y = 0."""
    half, shape = WIDTH / 2, Shape()
    shape.box((-half, -0.16, HEIGHT - 0.2), (half, 0.16, HEIGHT + 0.2))
    shape.box((-0.14, -0.14, HEIGHT + 0.2), (0.14, 0.14, HEIGHT + 3.1))
    for side in (-1, 1):
        shape.tube((side * half, 0, HEIGHT), (0, 0, HEIGHT + 3.2), 0.17, 4)
        shape.tube((side * 2.6, 0, HEIGHT), (side * 0.1, 0, HEIGHT + 2.0), 0.11, 4)
        shape.tube(
            (side * (half - 0.15), 0, HEIGHT - 1.7),
            (side * (half - 1.9), 0, HEIGHT - 0.1),
            0.12,
            4,
        )
    return shape


def table(length: float) -> Shape:
    """A long table along Y, on trestles."""
    shape = Shape().box((-0.55, -length / 2, 0.74), (0.55, length / 2, 0.82))
    for along in np.arange(-length / 2 + 0.7, length / 2, (length - 1.4) / 3):
        shape.box((-0.42, along - 0.06, 0.0), (0.42, along + 0.06, 0.08))
        shape.box((-0.07, along - 0.07, 0.08), (0.07, along + 0.07, 0.74))
    return shape


def chair() -> Shape:
    """A high-backed chair that looks along +X."""
    shape = Shape().box((-0.22, -0.23, 0.44), (0.22, 0.23, 0.49))
    for x, y, top in (
        (-0.2, -0.2, 1.28),
        (-0.2, 0.2, 1.28),
        (0.2, -0.2, 0.44),
        (0.2, 0.2, 0.44),
    ):
        shape.box((x - 0.025, y - 0.025, 0.0), (x + 0.025, y + 0.025, top))
    for along in (-0.1, 0.0, 0.1):
        shape.box((-0.21, along - 0.018, 0.6), (-0.19, along + 0.018, 1.2))
    return shape.box((-0.22, -0.2, 1.18), (-0.18, 0.2, 1.26)).box((-0.22, -0.2, 0.6), (-0.18, 0.2, 0.66))


def lantern() -> Shape:
    """A wrought lantern around the origin, on a chain: cage (slot 0) and flame (slot 1)."""
    shape = Shape().tube((0, 0, 0.34), (0, 0, 4.0), 0.012, 6)
    corners = [(0.16 * cos(a), 0.16 * sin(a)) for a in np.arange(6) * pi / 3]
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        shape.tube((x0, y0, -0.2), (x0, y0, 0.2), 0.012, 5).tube((x0, y0, 0.2), (0, 0, 0.36), 0.012, 5)
        for height in (-0.2, 0.2):
            shape.tube((x0, y0, height), (x1, y1, height), 0.014, 5)
    return shape.ball((0, 0, 0.10), (0.022, 0.022, 0.05), 1, 10)


def floor(material: bpy.types.Material) -> None:
    """The floor, with UVs that repeat the slabs every 4 m."""
    half, end = WIDTH / 2 + WALL, LENGTH / 2
    corners = [(-half, -end, 0), (half, -end, 0), (half, end, 0), (-half, end, 0)]
    mesh = Shape().add(corners, [(0, 1, 2, 3)]).mesh("Floor", material)
    uv = mesh.uv_layers.new(name="UVMap")
    for loop in mesh.loops:
        x, y, _ = mesh.vertices[loop.vertex_index].co
        uv.data[loop.index].uv = (x / 4.0, y / 4.0)
    link("Floor", mesh)


def shell(stone: bpy.types.Material, timber: bpy.types.Material) -> None:
    """Walls and roof: window bays on the sunny side, a plain wall opposite, both ends closed."""
    half, end = WIDTH / 2, LENGTH / 2
    bay = shared_collection("Window Bay")
    link("Window Bay", window_bay().mesh("Window Bay", stone, stone), bay)
    pillar = shared_collection("Column")
    link("Column", column().mesh("Column", stone), pillar)
    frame = shared_collection("Roof Frame")
    link("Roof Frame", roof_frame().mesh("Roof Frame", timber), frame)
    for index in range(BAYS):
        along = -end + BAY * (index + 0.5)
        instance(bay, placed((-half, along, 0)))
        if index:
            edge = -end + BAY * index
            instance(frame, placed((0, edge, 0)))
            for x in (-half + 1.35, half - 1.35):
                instance(pillar, placed((x, edge, 0)))
    walls = Shape().box((half, -end, 0), (half + WALL, end, HEIGHT))
    for low in (-end - WALL, end):
        walls.box((-half - WALL, low, 0), (half + WALL, low + WALL, HEIGHT + 4))
    for x in (-half + 1.35, half - 1.35):  # the beam that the columns carry
        walls.box((x - 0.35, -end, HEIGHT - 1.25), (x + 0.35, end, HEIGHT - 0.55))
    link("Walls", walls.mesh("Walls", stone))
    roof = Shape()
    for side in (-1, 1):
        eave, ridge = side * (half + 1.2), HEIGHT + 3.4
        roof.add(
            [
                (eave, -end - 1, HEIGHT - 0.5),
                (eave, end + 1, HEIGHT - 0.5),
                (0, end + 1, ridge),
                (0, -end - 1, ridge),
            ],
            [(0, 1, 2, 3)],
        )
    link("Roof", roof.mesh("Roof", timber))


def furniture(timber: bpy.types.Material, iron: bpy.types.Material) -> None:
    """The long table, its chairs, and the lanterns above it."""
    link("Table", table(17.0).mesh("Table", timber), place=placed((-0.4, 2.0, 0)))
    seat = shared_collection("Chair")
    link("Chair", chair().mesh("Chair", timber), seat)
    random = np.random.default_rng(5)
    for side, turn in ((-1, 0), (1, 180)):
        for along in np.arange(-5.6, 10.0, 1.2):
            pulled = 0.18 * random.random()
            instance(
                seat,
                placed(
                    (-0.4 + side * (0.86 + pulled), along, 0),
                    (0, 0, turn + 9 * random.normal()),
                ),
            )
    flame = emission("Flame", (1.0, 0.55, 0.18), 60.0)
    cage = lantern().mesh("Lantern", iron, flame)
    for along in (-3.5, 2.0, 7.5):
        hung = link("Lantern", cage, place=placed((-0.4, along, 4.3)))
        hung.visible_volume_scatter = False  # a lamp lights the air for it
        point_light("Lantern Light", (-0.4, along, 4.3), 130, (1.0, 0.52, 0.20), 0.04)


def build() -> None:
    """Put the scene together."""
    clear_file()
    stone = diffuse("Sandstone", (0.60, 0.53, 0.44))
    timber = diffuse("Oak", (0.20, 0.12, 0.07))
    iron = diffuse("Iron", (0.05, 0.05, 0.05))
    floor(diffuse("Slabs", (0.5, 0.46, 0.4), packed_image("Slabs", slabs())))
    shell(stone, timber)
    furniture(timber, iron)
    sun("Sun", (-1.0, 0.55, 0.95), 34.0, (1.0, 0.80, 0.55), 0.4)
    # Direct light only: what the sunlit floor would send back into the hall is painted by hand.
    for along in (-9.0, 0.0, 9.0):
        point_light("Floor Bounce", (2.2, along, 0.9), 150, (1.0, 0.74, 0.50), 0.3)
    world((0.42, 0.58, 1.0), 0.9)
    half, end = WIDTH / 2, LENGTH / 2
    fog_box(
        (-half - 0.35, -end + 0.01, 0.01),
        (half - 0.01, end - 0.01, HEIGHT + 2.2),
        0.022,
        (1.0, 0.98, 0.95),
        0.35,
    )
    camera((2.5, -13.6, 1.65), (-2.2, 0.0, 3.75), 23.0)
    finish(__file__, view="Filmic", look="Medium High Contrast", exposure=0.5)


build()
