# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents by triangles are Blender's own where it has them, and Cycles' where faces have more than four corners."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon import last_render
from addon.sync.corner_tangents import corner_tangents
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.patch_nodes import Link, New
from support.small_scenes import add, empty_scene, material, mesh

_SHAPES = ["smooth", "flat", "with sharp edges", "with a mirrored map", "with a map of a point"]


def _bent(shape: str) -> bpy.types.Mesh:
    """A hill of triangles, whose map is bent, too."""
    steps = np.linspace(-0.4, 0.4, 8)
    corners = np.array([(x, y, 0.3 * np.cos(3.0 * x) * np.cos(4.0 * y + 0.6)) for y in steps for x in steps])
    faces = [
        face
        for row in range(7)
        for first in range(row * 8, row * 8 + 7)
        for face in ((first, first + 1, first + 9), (first, first + 9, first + 8))
    ]
    data = mesh("Hill", corners.tolist(), faces)
    data.polygons.foreach_set("use_smooth", np.full(len(faces), shape != "flat"))
    if shape == "with sharp edges" and bpy.app.version >= (4, 1, 0):
        data.set_sharp_from_angle(angle=0.15)
    layer = data.uv_layers.new(name="UVMap")
    for loop in data.loops:
        x, y, _ = corners[loop.vertex_index]
        layer.data[loop.index].uv = {
            "with a mirrored map": (abs(x - steps[4]), y + 0.3 * x * x),
            "with a map of a point": (max(x, -0.1), max(y, 0.05)),
        }.get(shape, (1.4 * x + 0.4 * y, 1.6 * y - 0.2 * x + 0.8 * x * x))
    return data


def _stored(elements: object, field: str, channels: int) -> NDArray[np.float32]:
    values = np.empty(len(elements) * channels, np.float32)  # type: ignore[arg-type]
    elements.foreach_get(field, values)  # type: ignore[attr-defined]
    return values.reshape(-1, channels)


# Seen to fail with groups that reach over the edge of a mirrored map, and with all weights alike.
@pytest.mark.parametrize("shape", _SHAPES)
def test_triangles_have_the_tangents_that_blender_gives_them(shape: str) -> None:
    empty_scene()
    data = _bent(shape)
    data.calc_loop_triangles()
    data.calc_tangents(uvmap="UVMap")
    theirs = np.column_stack([_stored(data.loops, "tangent", 3), _stored(data.loops, "bitangent_sign", 1)])
    normals = _stored(data.loops, "normal", 3)
    vertices = _stored(data.loops, "vertex_index", 1).astype(np.intp)[:, 0]
    triangles = np.array([triangle.loops[:] for triangle in data.loop_triangles], np.intp)
    uvs = _stored(data.uv_layers["UVMap"].data, "uv", 2)
    ours = corner_tangents(_stored(data.vertices, "co", 3)[vertices], normals, uvs, triangles)
    edges = np.diff(uvs[triangles], axis=1)
    has_area = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) > 1e-6  # on the map
    assert has_area.mean() > 0.3
    known = triangles[has_area].ravel()
    np.testing.assert_allclose(ours[known], theirs[known], atol=2e-4)


def test_the_tangents_of_many_cornered_faces_are_those_of_cycles() -> None:
    """A ring of twelve corners around a smooth, raised face of twelve."""
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    rings = [
        (radius * np.cos(a), 1.1 * radius * np.sin(a), z) for radius, z in ((0.3, 0.2), (0.45, 0.0)) for a in angles
    ]
    sides = [(i, 12 + i, 12 + (i + 1) % 12, (i + 1) % 12) for i in range(12)]

    def shown(new: New, link: Link) -> bpy.types.NodeSocket:
        tangent, moved, emission = new("ShaderNodeTangent"), new("ShaderNodeVectorMath"), new("ShaderNodeEmission")
        tangent.direction_type = "UV_MAP"
        moved.inputs[1].default_value = (2.0, 2.0, 2.0)
        link(tangent.outputs[0], moved.inputs[0])
        link(moved.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    scene = empty_scene(24)
    scene.camera.data.ortho_scale = 1.0
    data = mesh("Cap", rings, [tuple(range(12)), *sides], material("Shown", shown))
    data.polygons.foreach_set("use_smooth", np.ones(13, np.bool_))
    layer = data.uv_layers.new(name="UVMap")
    for loop in data.loops:
        x, y, _ = rings[loop.vertex_index]
        layer.data[loop.index].uv = (0.5 + x + 0.3 * y, 0.5 + y - 0.6 * x * y)
    add("Cap", data)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=1, seed=1)
    assert not [line for line in last_render.statistics_of(scene.name)["reports"] if "tangents" in line]
    off = np.abs(ours - cycles).max(axis=2)[cycles.max(axis=2) > 0.0]
    assert np.quantile(off, 0.95) < 0.02, np.quantile(off, [0.5, 0.9, 0.95, 1.0])
