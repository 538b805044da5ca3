# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones, and a skeleton that stands in the gallery's museum."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np
from mathutils import Matrix, Vector
from nature_kit import limb
from scene_kit import Shape, diffuse

if TYPE_CHECKING:
    from collections.abc import Sequence

    import bpy


def curve(points: Sequence[Sequence[float]], count: int) -> list[Vector]:
    """Places along a smooth line through all points, evenly over its length."""
    line = [Vector(point) for point in points]
    line = [2 * line[0] - line[1], *line, 2 * line[-1] - line[-2]]
    fine = []
    for a, b, c, d in zip(line, line[1:], line[2:], line[3:], strict=False):
        bend, twist = 2 * a - 5 * b + 4 * c - d, 3 * b - a - 3 * c + d
        fine += [0.5 * (2 * b + (c - a) * t + bend * t**2 + twist * t**3) for t in (np.arange(16) / 16).tolist()]
    fine.append(line[-2])
    way = np.concatenate(([0.0], np.cumsum([(b - a).length for a, b in pairwise(fine)])))
    spaced = np.linspace(0.0, way[-1], count)
    return [Vector([float(np.interp(at, way, [point[k] for point in fine])) for k in range(3)]) for at in spaced]


def bone(shape: Shape, start: Vector, end: Vector, radius: float, knob: float = 1.8) -> None:
    """A long bone with thick ends."""
    points = [start.lerp(end, t) for t in (0.0, 0.05, 0.16, 0.5, 0.84, 0.95, 1.0)]
    scales = (0.7 * knob, knob, 1.15, 1.0, 1.15, knob, 0.7 * knob)
    limb(shape, points, [radius * scale for scale in scales], 10)


def vertebra(shape: Shape, at: Vector, ahead: Vector, radius: float, length: float, spine: float, wing: float) -> None:
    """A spool, with a spine above, and a process on each hand."""
    turn = Matrix.Translation(at) @ ahead.to_track_quat("Z", "Y").to_matrix().to_4x4()
    profile = [(radius, -0.5), (radius, -0.38), (0.68 * radius, 0.0), (radius, 0.38), (radius, 0.5)]
    shape.lathe([(r, h * length) for r, h in profile], 12, 0, turn)
    left = Vector((0, 0, 1)).cross(ahead).normalized()
    up = ahead.cross(left).normalized()
    back = -ahead * 0.35
    top = at + up * (radius + spine) + back * spine
    limb(shape, [at, at + up * radius + back * 0.3 * spine, top], [0.5 * radius, 0.34 * radius, 0.26 * radius], 6)
    for hand in (-1, 1):
        tip = at + left * hand * (radius + wing) + up * 0.6 * radius + back * wing
        limb(shape, [at + up * 0.4 * radius, tip], [0.4 * radius, 0.22 * radius], 6)


def spine_and_ribs(shape: Shape) -> None:
    """From the tip of the tail to the head, that looks along +X."""
    line = curve(
        [
            (-7.2, 2.3, 3.5), (-5.2, 1.25, 3.15), (-3.2, 0.45, 3.2), (-1.2, 0.05, 3.4), (0.0, 0.0, 3.5),
            (1.3, 0.0, 3.62), (2.5, 0.0, 3.85), (3.1, -0.05, 4.3), (3.35, -0.1, 4.85), (3.7, -0.15, 5.18),
        ],
        62,
    )  # fmt: skip
    for index, at in enumerate(line):
        ahead = (line[min(index + 1, 61)] - line[max(index - 1, 0)]).normalized()
        gap = (line[1] - line[0]).length
        tail = min(index / 30.0, 1.0)  # 1 from the hip on
        radius = 0.025 + 0.125 * tail if index < 48 else 0.15 - 0.003 * (index - 48)
        height = 0.05 + 0.36 * tail**1.5 if index < 46 else 0.40 - 0.014 * (index - 46)
        vertebra(shape, at, ahead, radius, gap * 0.92, height, 0.04 + 0.2 * tail)
        if 4 < index < 28:  # chevrons below the tail
            drop = at + Vector((-0.35, 0, -1)).normalized() * (0.12 + 0.5 * tail)
            limb(shape, [at, drop], [0.03 + 0.02 * tail, 0.018], 6)
        if 35 <= index < 51:
            t = (index - 35) / 15
            rib(shape, at, (0.42 + 0.45 * sin(pi * (0.25 + 0.65 * t))), 1.05 + 0.75 * sin(pi * (0.1 + 0.75 * t)))


def rib(shape: Shape, at: Vector, width: float, depth: float) -> None:
    """A pair that hangs from a vertebra, and reaches back."""
    for hand in (-1, 1):
        points = []
        for t in np.linspace(0.0, 1.0, 9):
            angle = 0.12 * pi + 0.78 * pi * t
            out = width * sin(angle) ** 0.8
            down = depth * 0.5 * (cos(0.12 * pi) - cos(angle)) * 1.02
            points.append(at + Vector((-0.32 * t * depth, hand * out * min(1.0, 4 * t + 0.1), 0.12 - down)))
        limb(shape, points, [0.055, 0.06, 0.055, 0.05, 0.046, 0.042, 0.038, 0.034, 0.026], 7)


def plate(shape: Shape, outline: Sequence[tuple[float, float]], left: float, right: float) -> None:
    """A flat bone in the plane across Y, from the points (x, z) of its rim."""
    count = len(outline)
    points = [(x, y, z) for y in (left, right) for x, z in outline]
    sides = [(i, (i + 1) % count, count + (i + 1) % count, count + i) for i in range(count)]
    shape.add(points, [tuple(reversed(range(count))), tuple(range(count, 2 * count)), *sides])


def hips_and_limbs(shape: Shape) -> None:
    """Pelvis, legs in stride, and small arms."""
    blade = [(-1.0, 3.42), (-0.85, 3.75), (-0.2, 4.02), (0.5, 3.95), (0.95, 3.6)]
    blade += [(0.75, 3.3), (0.2, 3.16), (-0.35, 3.16)]
    for hand in (-1, 1):
        plate(shape, blade, hand * 0.30 - 0.035, hand * 0.30 + 0.035)
        limb(
            shape,
            [(0.2, hand * 0.3, 3.2), (0.55, hand * 0.18, 2.55), (0.78, hand * 0.07, 1.95), (1.05, hand * 0.06, 1.86)],
            [0.1, 0.07, 0.08, 0.09],
        )
        limb(shape, [(0.78, hand * 0.07, 1.95), (0.45, hand * 0.06, 1.9)], [0.09, 0.05])
        ischium = [(-0.3, hand * 0.28, 3.2), (-0.75, hand * 0.16, 2.6), (-1.2, hand * 0.06, 2.25)]
        limb(shape, ischium, [0.09, 0.06, 0.04])
    strides = {1: ((0.75, 2.2), (0.3, 1.12), (0.85, 0.32)), -1: ((0.35, 2.05), (-0.75, 1.2), (-0.7, 0.32))}
    for hand, ((knee_x, knee_z), (ankle_x, ankle_z), (ball_x, ball_z)) in strides.items():
        y = hand * 0.52
        hip, knee = Vector((0.05, hand * 0.42, 3.22)), Vector((knee_x, y + hand * 0.06, knee_z))
        ankle, ball = Vector((ankle_x, y, ankle_z)), Vector((ball_x, y, ball_z))
        bone(shape, hip, knee, 0.115, 1.6)
        bone(shape, knee, ankle, 0.09, 1.7)
        bone(shape, knee + Vector((-0.07, hand * 0.1, 0)), ankle + Vector((0, hand * 0.07, 0.05)), 0.035, 1.4)
        for toe, spread in enumerate((-0.45, 0.0, 0.45)):
            out = Vector((cos(spread), sin(spread), 0))
            side = Vector((0, 0.09 * (toe - 1), 0))
            bone(shape, ankle + side * 0.7, ball + side, 0.045, 1.5)
            reach = 0.62 if toe == 1 else 0.5
            joints = [ball + side, ball + side + out * reach * 0.5 + Vector((0, 0, -0.1))]
            joints.append(ball + side + out * reach + Vector((0, 0, -0.2)))
            limb(shape, joints, [0.07, 0.06, 0.055])
            claw = joints[-1] + out * 0.2 + Vector((0, 0, -0.1))
            limb(shape, [joints[-1], joints[-1].lerp(claw, 0.5) + Vector((0, 0, 0.05)), claw], [0.055, 0.045, 0.008])
        shoulder = Vector((2.45, hand * 0.55, 3.0))
        limb(shape, [(1.35, hand * 0.62, 3.75), (2.0, hand * 0.68, 3.35), shoulder], [0.08, 0.055, 0.1])
        limb(shape, [shoulder, (2.75, hand * 0.2, 2.7)], [0.1, 0.08])
        elbow, wrist = Vector((2.25, hand * 0.62, 2.55)), Vector((2.62, hand * 0.58, 2.35))
        bone(shape, shoulder, elbow, 0.045)
        bone(shape, elbow, wrist, 0.032)
        for finger in (-0.05, 0.06):
            tip = wrist + Vector((0.16, finger, -0.12))
            limb(shape, [wrist, tip, tip + Vector((0.04, 0, -0.1))], [0.03, 0.026, 0.005])


def skull(shape: Shape) -> None:
    """Bars around great openings, a solid snout, and a jaw that gapes."""
    head = Matrix.Translation((3.62, -0.15, 5.0)) @ Matrix.Rotation(-0.16, 4, "Z") @ Matrix.Rotation(0.12, 4, "Y")

    def half_width(x: float) -> float:
        return float(np.interp(x, (0.0, 0.45, 0.75, 1.1, 1.5), (0.34, 0.36, 0.22, 0.17, 0.09)))

    def bar(points: Sequence[tuple[float, float]], radii: Sequence[float], place: Matrix, hand: int) -> None:
        limb(shape, [place @ Vector((x, hand * half_width(x), z)) for x, z in points], radii, 8)

    def teeth(rim: Sequence[tuple[float, float]], count: int, sign: int, place: Matrix, hand: int) -> None:
        x, z = np.array(rim).T
        for index, at in enumerate(np.linspace(x[0], x[-1], count)):
            root = Vector((at, hand * half_width(at) * 0.97, float(np.interp(at, x, z))))
            long = (0.12, 0.19, 0.15)[index % 3] * (1.0 if sign < 0 else 0.75)
            tip = [root + Vector((-0.1 * t * t, 0, sign * t * long)) for t in (0.0, 0.6, 1.0)]
            limb(shape, [place @ point for point in tip], [0.036, 0.028, 0.004], 6, 1)

    roof = [(0.0, 0.40), (0.3, 0.46), (0.55, 0.47), (0.8, 0.40), (1.1, 0.34), (1.35, 0.25), (1.52, 0.05)]
    lip = [(0.0, -0.16), (0.25, -0.13), (0.5, -0.20), (0.8, -0.19), (1.1, -0.14), (1.35, -0.12), (1.52, -0.05)]
    for hand in (-1, 1):
        bar(roof, [0.07, 0.08, 0.085, 0.07, 0.065, 0.06, 0.05], head, hand)
        bar(lip, [0.05, 0.045, 0.06, 0.075, 0.075, 0.07, 0.05], head, hand)
        bar([(0.0, 0.40), (0.07, 0.12), (-0.02, -0.2)], [0.07, 0.05, 0.08], head, hand)
        bar([(0.36, 0.45), (0.36, 0.15), (0.44, -0.18)], [0.08, 0.055, 0.06], head, hand)
        bar([(0.04, 0.12), (0.36, 0.2)], [0.05, 0.055], head, hand)
        bar([(0.66, 0.44), (0.62, 0.12), (0.7, -0.18)], [0.08, 0.05, 0.065], head, hand)
        bar([(1.06, 0.33), (0.96, 0.1), (1.02, -0.14)], [0.07, 0.06, 0.07], head, hand)
        bar([(0.98, 0.08), (0.78, -0.02), (0.68, -0.1)], [0.05, 0.035, 0.05], head, hand)
        snout = [head @ Vector((x, hand * half_width(x) * 0.98, z)) for x, z in [*roof[4:], *reversed(lip[4:])]]
        shape.add(snout, [tuple(range(6))])
        teeth(lip[3:], 13, -1, head, hand)
    top = [head @ Vector((x, hand * half_width(x), z + 0.03)) for x, z in roof for hand in (-1, 1)]
    shape.add(top, [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(roof) - 1)])
    jaw = head @ Matrix.Translation((0.02, 0, -0.2)) @ Matrix.Rotation(0.42, 4, "Y")
    upper = [(0.0, 0.0), (0.35, 0.08), (0.8, 0.0), (1.2, -0.01), (1.42, 0.03)]
    lower = [(0.0, -0.1), (0.35, -0.2), (0.8, -0.17), (1.2, -0.16), (1.42, -0.08)]
    for hand in (-1, 1):
        bar(upper, [0.06, 0.05, 0.05, 0.05, 0.045], jaw, hand)
        bar(lower, [0.055, 0.055, 0.06, 0.055, 0.05], jaw, hand)
        side = [jaw @ Vector((x, hand * half_width(x), z)) for x, z in [*upper[1:], *reversed(lower[1:])]]
        shape.add(side, [tuple(range(8))])
        teeth(upper[2:], 11, 1, jaw, hand)
    shape.ball(head @ Vector((0.06, 0, 0.14)), (0.22, 0.22, 0.24), 0, 14)


def tyrannosaur() -> bpy.types.Mesh:
    """All of it, 11 m long."""
    shape = Shape()
    spine_and_ribs(shape)
    hips_and_limbs(shape)
    skull(shape)
    return shape.mesh("Tyrannosaur", diffuse("Bone", (0.50, 0.40, 0.26)), diffuse("Teeth", (0.66, 0.60, 0.46)))
