# SPDX-License-Identifier: GPL-3.0-or-later
"""What grows, lies and rolls in the gallery's scenes: limbs, grounds, boulders, blades, crowns of leaves."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix, Vector
from scene_kit import Shape, link

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

FloatArray = NDArray[np.float64] if TYPE_CHECKING else object


def limb(
    shape: Shape, points: Sequence[Sequence[float]], radii: Sequence[float], sides: int = 8, slot: int = 0
) -> Shape:
    """Add a capped tube along a line, with a radius at each of its points."""
    line = [Vector(point) for point in points]
    ahead = [(line[min(i + 1, len(line) - 1)] - line[max(i - 1, 0)]).normalized() for i in range(len(line))]
    across = ahead[0].orthogonal().normalized()
    rings: list[Vector] = []
    for centre, axis, radius in zip(line, ahead, radii, strict=True):
        across = (across - axis * across.dot(axis)).normalized()  # turns with the line, and not around it
        up = axis.cross(across)
        rings += [
            centre + radius * (across * cos(2 * pi * side / sides) + up * sin(2 * pi * side / sides))
            for side in range(sides)
        ]
    faces: list[tuple[int, ...]] = [
        (ring * sides + side, ring * sides + turn, (ring + 1) * sides + turn, (ring + 1) * sides + side)
        for ring in range(len(line) - 1)
        for side in range(sides)
        for turn in ((side + 1) % sides,)
    ]
    faces.append(tuple(reversed(range(sides))))
    faces.append(tuple((len(line) - 1) * sides + side for side in range(sides)))
    return shape.add(rings, faces, slot)


def hills(x: FloatArray, y: FloatArray, seed: int, octaves: int = 4, persistence: float = 0.5) -> FloatArray:
    """Noise of wavelength 1 and its halves, smooth, about -1 to 1; of any shape of coordinates."""
    random = np.random.default_rng(seed)
    total = np.zeros(np.broadcast(x, y).shape)
    for octave in range(octaves):
        values = random.uniform(-1.0, 1.0, (64, 64))
        u, v = x * 2**octave + 17.3 * octave, y * 2**octave + 9.1 * octave
        column, row = np.floor(u).astype(int), np.floor(v).astype(int)
        s, t = u - column, v - row
        s, t = s * s * s * (s * (s * 6 - 15) + 10), t * t * t * (t * (t * 6 - 15) + 10)
        near = values[row % 64, column % 64] * (1 - s) + values[row % 64, (column + 1) % 64] * s
        far = values[(row + 1) % 64, column % 64] * (1 - s) + values[(row + 1) % 64, (column + 1) % 64] * s
        total += persistence**octave * (near * (1 - t) + far * t)
    return total


def ground(
    name: str, x: FloatArray, y: FloatArray, heights: FloatArray, material: bpy.types.Material
) -> bpy.types.Object:
    """A smooth surface over the lines x (columns) and y (rows), of heights (rows, columns)."""
    rows, columns = heights.shape
    grid_x, grid_y = np.meshgrid(x, y)
    points = np.stack((grid_x, grid_y, heights), axis=-1).reshape(-1, 3)
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1)
    faces = np.stack((corner, corner + 1, corner + columns + 1, corner + columns), axis=1)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.append(material)
    mesh.update()
    return link(name, mesh)


def spaced(low: float, high: float, middle: float, finest: float, growth: float = 0.05) -> FloatArray:
    """Coordinates from low to high whose spacing is the finest around the middle and grows with distance from it."""
    right, left = [middle], [middle]
    while right[-1] < high:
        right.append(right[-1] + finest + growth * (right[-1] - middle))
    while left[-1] > low:
        left.append(left[-1] - finest - growth * (middle - left[-1]))
    return np.clip(np.array(left[:0:-1] + right), low, high)


def boulder(random: np.random.Generator, sides: int = 20) -> Shape:
    """A worn stone of radius 1."""
    seed = int(random.integers(1 << 30))
    shape = Shape().ball((0, 0, 0), (1, 1, 1), 0, sides)
    for index, point in enumerate(shape.points):
        at = np.array(point)
        bump = 0.35 * hills(at[0] * 0.9 + 5 + at[2], at[1] * 0.9 + 3 - at[2] * 0.7, seed, 4)
        shape.points[index] = point * float(1.0 + bump)
    return shape


def blades(
    random: np.random.Generator, count: int, spread: float, height: float, bend: float, width: float, slot: int = 0
) -> Shape:
    """A tuft of bent blades, each two quads' length and a tip."""
    shape = Shape()
    for _ in range(count):
        root = Vector((random.normal() * spread, random.normal() * spread, -0.03))
        heading, tall = 2 * pi * random.random(), height * random.uniform(0.55, 1.1)
        out = Vector((cos(heading), sin(heading), 0))
        lean = bend * random.uniform(0.3, 1.3) * tall
        wide = Vector((-out.y, out.x, 0)) * width / 2
        low = root + out * lean * 0.12 + Vector((0, 0, tall * 0.4))
        high = root + out * lean * 0.45 + Vector((0, 0, tall * 0.75))
        tip = root + out * lean + Vector((0, 0, tall * (1.0 - 0.25 * bend)))
        points = [root - wide, root + wide, low + wide, low - wide, high + wide * 0.7, high - wide * 0.7, tip]
        shape.add(points, [(0, 1, 2, 3), (3, 2, 4, 5), (5, 4, 6)], slot)
    return shape


def animal(joints: dict[str, Sequence[float]], chains: Sequence[Sequence[str]], sides: int = 12) -> Shape:
    """A body of skinned tubes: joints are places and radii, chains lead from joint to joint."""
    shape = Shape()
    for chain in chains:
        for (*a, ra), (*b, rb) in pairwise([joints[name] for name in chain]):
            axis = Vector(b) - Vector(a)
            place = Matrix.Translation(a) @ axis.to_track_quat("Z", "Y").to_matrix().to_4x4()
            shape.lathe([(ra, 0.0), (rb, axis.length)], sides, 0, place)
            shape.ball(a, (ra, ra, ra), 0, sides)
            shape.ball(b, (rb, rb, rb), 0, sides)
    return shape


def bare_tree(random: np.random.Generator, height: float, radius: float) -> Shape:
    """A dead tree: limbs that fork and twist, without a leaf."""
    shape = Shape()

    def grow(root: Vector, heading: Vector, length: float, thick: float, level: int) -> None:
        steps = 5
        line, radii, at, axis = [root.copy()], [thick], root.copy(), heading.normalized()
        for step in range(1, steps + 1):
            axis = (axis + Vector(random.normal(size=3)) * 0.17 + Vector((0, 0, 0.05))).normalized()
            at = at + axis * length / steps
            line.append(at.copy())
            radii.append(thick * (1 - 0.55 * step / steps))
        limb(shape, line, radii, max(3, 9 - 2 * level))
        if level == 5:
            return
        for fork in range(3 if level < 4 else 2):
            index = int(random.integers(2, steps + 1)) if fork else steps
            aside = Vector(random.normal(size=3))
            turned = (axis + 0.85 * (aside - axis * aside.dot(axis)).normalized()).normalized()
            grow(line[index], turned, length * random.uniform(0.58, 0.78), radii[index] * 0.8, level + 1)

    grow(Vector((0, 0, -0.3)), Vector((0.08, 0, 1)), height * 0.36, radius, 0)
    return shape
