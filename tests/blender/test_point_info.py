# SPDX-License-Identifier: GPL-3.0-or-later
"""What Point Info tells of the points of a cloud is what Cycles tells."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.hair_scenes import made_by_nodes
from support.patch_nodes import Link, New, Socket
from support.small_scenes import add, empty_scene, material, mesh

OFFSET = 8.0  #: What is shown is the node's output plus this, as light is not negative.
EDGES = 0.03  #: Share of the pixels at which a sphere's edge may lie: Cycles' lie up to a hundredth of one elsewhere.


def cloud(output: str, scale: tuple[float, float, float], *, is_twice: bool = False) -> bpy.types.Scene:
    """Nine beads of different sizes, and a strip of mesh with their material."""

    def build(new: New, link: Link) -> Socket:
        moved, emission = new("ShaderNodeVectorMath"), new("ShaderNodeEmission")
        moved.inputs[1].default_value = (OFFSET, OFFSET, OFFSET)
        link(new("ShaderNodePointInfo").outputs[output], moved.inputs[0])
        link(moved.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    scene = empty_scene(32)
    scene.camera.data.ortho_scale, scene.camera.location.z = 4.0, 6.0
    told = material("Told", build)
    corners = [(x - 1.0, y - 1.0, 0.1 * x) for x in range(3) for y in range(3)]
    beads = made_by_nodes(
        mesh("Corners", corners, []),
        [("GeometryNodeMeshToPoints", {"Radius": 0.2}), ("GeometryNodeSetMaterial", {"Material": told})],
    )
    beads.location, beads.scale = (0.3, 0.1, 0.2), scale
    if is_twice:
        shown = bpy.data.collections.new("Beads")
        shown.objects.link(beads)
        scene.collection.objects.unlink(beads)
        for index in range(2):
            instancer = add(f"Instancer {index}", None, (0.4 * index - 0.4, 0.0, -2.0 * index))
            instancer.instance_type, instancer.instance_collection = "COLLECTION", shown
    corners = [(1.7, -2, -3), (2, -2, -3), (2, 2, -3), (1.7, 2, -3)]
    add("Strip", mesh("Strip", corners, [(0, 1, 2, 3)], told))
    return scene


# Seen to fail with positions in the object, with radii of the object, and with the hash of the next point.
@pytest.mark.parametrize("drawn", ["once", "twice"])
@pytest.mark.parametrize("output", ["Position", "Radius", "Random"])
def test_points_tell_what_they_do_in_cycles(output: str, drawn: str) -> None:
    is_twice = drawn == "twice"
    scene = cloud(output, (1.3, 1.3, 1.3), is_twice=is_twice)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=1, seed=1)
    assert np.quantile(np.abs(ours - cycles).max(axis=2), 1.0 - EDGES) < 1e-4
    kinds = np.unique(np.round(ours.reshape(-1, 3), 4), axis=0)
    assert len(kinds) == (3 if output == "Radius" else 20 if is_twice and output == "Position" else 11)
    assert ours[16, -1] == pytest.approx(OFFSET)  # a mesh has no points


@pytest.mark.skipif(bpy.app.version < (4, 0, 0), reason="3.x has another radius of what is drawn once")
def test_a_radius_is_stretched_as_in_cycles() -> None:
    scene = cloud("Radius", (0.8, 1.2, 2.0))
    assert tyndall_pixels(scene).max() == pytest.approx(cycles_pixels(scene, samples=1, seed=1).max(), abs=1e-5)
