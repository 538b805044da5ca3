# SPDX-License-Identifier: GPL-3.0-or-later
"""Geometry > Pointiness and Random Per Island are Cycles', on meshes of several islands, some of them only touching."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from support.engine_pictures import FloatArray, cycles_pixels, tyndall_pixels
from support.patch_nodes import Link, New
from support.small_scenes import add, empty_scene, material, mesh

_SIDE = 6


def _shown(name: str) -> FloatArray:
    """Ours and Cycles', of hills that touch at their borders: the vertices there are twice in one place."""

    def surface(new: New, link: Link) -> bpy.types.NodeSocket:
        emission = new("ShaderNodeEmission")
        link(new("ShaderNodeNewGeometry").outputs[name], emission.inputs["Color"])
        return emission.outputs[0]

    steps = np.linspace(0.0, 0.5, _SIDE + 1)
    corners: list[tuple[float, float, float]] = []
    faces: list[tuple[int, int, int, int]] = []
    for left, low in ((-0.5, -0.5), (0.0, -0.5), (-0.5, 0.0), (0.0, 0.0)):
        first = len(corners)
        corners += [
            (left + x, low + y, 0.3 * np.sin(9.0 * (left + x)) * np.cos(7.0 * (low + y))) for y in steps for x in steps
        ]
        starts = [first + row * (_SIDE + 1) + column for row in range(_SIDE) for column in range(_SIDE)]
        faces += [(at, at + 1, at + _SIDE + 2, at + _SIDE + 1) for at in starts]
    scene = empty_scene(24)
    scene.camera.data.ortho_scale = 1.0
    order = np.random.default_rng(5).permutation(len(faces))
    data = mesh("Hills", corners, [faces[index] for index in order], material("Shown", surface))
    data.polygons.foreach_set("use_smooth", np.ones(len(faces), np.bool_))
    add("Hills", data)
    return np.stack([tyndall_pixels(scene), cycles_pixels(scene, samples=1, seed=1)])


# Seen to fail without the neighbours' mean, and with borders that are not one.
def test_pointiness() -> None:
    ours, cycles = _shown("Pointiness")
    assert np.ptp(cycles) > 0.1
    # A picture of Cycles is up to a hundredth of a pixel off its pixels' centres.
    assert ours == pytest.approx(cycles, abs=2e-3)


# Seen to fail with the lowest number of an island's vertices in place of its root.
def test_islands() -> None:
    ours, cycles = _shown("Random Per Island")
    assert len(np.unique(cycles)) == 4
    assert ours == pytest.approx(cycles, abs=1e-6)
