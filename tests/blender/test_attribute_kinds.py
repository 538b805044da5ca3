# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of each kind and domain, and none, as each node that reads them has them in Cycles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.hair_scenes import made_by_nodes
from support.small_scenes import empty_scene, material, mesh, plane

if TYPE_CHECKING:
    import bpy

    from support.patch_nodes import Link, New, Socket

pytestmark = pytest.mark.dealt
NAME = "Told"
#: Type, domain, where the value is, and what it is.
KINDS = {
    "none": None,
    "UV map": None,
    "number": ("FLOAT", "POINT", "value", 0.3),
    "number of faces": ("FLOAT", "FACE", "value", 0.3),
    "integer": ("INT", "POINT", "value", 2),
    "switch": ("BOOLEAN", "POINT", "value", True),
    "pair": ("FLOAT2", "POINT", "vector", (0.2, 0.6)),
    "vector": ("FLOAT_VECTOR", "POINT", "vector", (0.2, 0.6, 0.9)),
    "vector of corners": ("FLOAT_VECTOR", "CORNER", "vector", (0.2, 0.6, 0.9)),
    "colour": ("FLOAT_COLOR", "CORNER", "color", (0.2, 0.6, 0.9, 0.4)),
    "colour of faces": ("FLOAT_COLOR", "FACE", "color", (0.2, 0.6, 0.9, 0.4)),
    "bytes": ("BYTE_COLOR", "POINT", "color", (0.2, 0.6, 0.9, 0.4)),
}
READERS = {
    "ShaderNodeAttribute": ("attribute_name", ("Color", "Vector", "Fac", "Alpha")),
    "ShaderNodeUVMap": ("uv_map", ("UV",)),
    "ShaderNodeVertexColor": ("layer_name", ("Color", "Alpha")),
}
#: Where Color Attribute names what is no colour, Cycles 4.5 crashes.
PAIRS = [
    (reader, kind)
    for reader in READERS
    for kind in KINDS
    if reader != "ShaderNodeVertexColor" or kind in {"none", "colour", "bytes"}
]


def told(reader: str, output: str, name: str = NAME) -> bpy.types.Material:
    def build(new: New, link: Link) -> Socket:
        asking, emission = new(reader), new("ShaderNodeEmission")
        setattr(asking, READERS[reader][0], name)
        link(asking.outputs[output], emission.inputs["Color"])
        return emission.outputs[0]

    return material("Told", build)


@pytest.mark.parametrize(("reader", "kind"), PAIRS)
def test_meshes_tell_what_they_do_in_cycles(reader: str, kind: str) -> None:
    """Seen to fail: Alpha was 0 of no attribute, Fac of pairs the mean of three, and UV Map found UV maps alone."""
    for output in READERS[reader][1]:
        scene = empty_scene(8)
        thing = plane(0.0, told(reader, output))
        if kind == "UV map":
            thing.data.uv_layers.new(name=NAME)
        if KINDS[kind] is not None:
            type_name, domain, field, value = KINDS[kind]
            for element in thing.data.attributes.new(NAME, type_name, domain).data:
                setattr(element, field, value)
        ours, cycles = tyndall_pixels(scene, 1), cycles_pixels(scene, 1, seed=1)
        channels = 2 if reader == "ShaderNodeUVMap" else 3  # the third of a UV map is 0
        # Cycles' filter of 0.01 px shows in what changes from place to place.
        assert ours[..., :channels] == pytest.approx(cycles[..., :channels], abs=5e-3), output


def test_a_uv_map_that_is_an_attribute_is_not_the_active_one() -> None:
    """Of a mesh that has no UV map at all."""
    scene = empty_scene(8)

    def build(new: New, link: Link) -> Socket:
        both, emission, named = new("ShaderNodeVectorMath"), new("ShaderNodeEmission"), new("ShaderNodeUVMap")
        named.uv_map = NAME
        link(named.outputs[0], both.inputs[0])
        link(new("ShaderNodeUVMap").outputs[0], both.inputs[1])
        link(both.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    thing = plane(0.0, material("Both", build))
    for layer in list(thing.data.uv_layers):
        thing.data.uv_layers.remove(layer)
    for corner in thing.data.attributes.new(NAME, "FLOAT_VECTOR", "CORNER").data:
        corner.vector = (0.2, 0.6, 0.0)
    ours, cycles = tyndall_pixels(scene, 1), cycles_pixels(scene, 1, seed=1)
    assert ours == pytest.approx(cycles, abs=1e-5)
    assert ours[4, 4] == pytest.approx((0.2, 0.6, 0.0), abs=1e-5)


@pytest.mark.parametrize("name", [NAME, "radius"])
@pytest.mark.parametrize("output", ["Fac", "Alpha"])
def test_points_tell_what_they_do_in_cycles(output: str, name: str) -> None:
    scene = empty_scene(16)
    scene.camera.data.ortho_scale = 1.0
    look = told("ShaderNodeAttribute", output, name)
    made_by_nodes(
        mesh("Corner", [(0.0, 0.0, 0.0)], []),
        [("GeometryNodeMeshToPoints", {"Radius": 0.4}), ("GeometryNodeSetMaterial", {"Material": look})],
    )
    ours, cycles = tyndall_pixels(scene, 1), cycles_pixels(scene, 1, seed=1)
    assert ours[8, 8] == pytest.approx(cycles[8, 8], abs=1e-4)
    assert ours[8, 8] == pytest.approx((1.0,) * 3 if output == "Alpha" else (0.4 if name == "radius" else 0.0,) * 3)
