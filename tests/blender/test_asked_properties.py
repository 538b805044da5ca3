# SPDX-License-Identifier: GPL-3.0-or-later
"""Attribute nodes read properties of objects, their data, view layers, scenes and worlds, as Cycles finds them."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon import last_render
from support.cycles_reference import prepare_cycles, rendered_pixels
from support.small_scenes import add, empty_scene, material, node

OUTPUTS = "Color", "Vector", "Fac", "Alpha"
OF_OBJECT = (
    *("share", "count", "two", "three", "four", "flag", "counts", "with space", "of_data"),
    *('["share"]', '["with space"]', "color", '["color"]', "pass_index", "hide_render", "location", "rotation_euler"),
    # Nothing that is a number, or no more than four: 0.
    *("text", "five", "location[0]", "location.x", "matrix_world", "data.name", "display_type", "nobody's", ""),
)
OF_LAYER = (
    *("of_layer", "of_scene", "of_world", "frame_current", "render.fps", "use_sky", '["of_scene"]', "share", "color"),
)


def shown(kind: str, name: str, output: str) -> bpy.types.Material:
    def build(new: object, link: object) -> bpy.types.NodeSocket:
        asked = node(new, "ShaderNodeAttribute")
        asked.attribute_type, asked.attribute_name = kind, name
        glow = node(new, "ShaderNodeEmission")
        link(asked.outputs[output], glow.inputs["Color"])
        return glow.outputs[0]

    return material(f"{kind} {name} {output}", surface=build)


def strip(name: str, materials: list[bpy.types.Material]) -> bpy.types.Object:
    """A square of a metre for each."""
    corners = [(float(x), float(y), 0.0) for x in range(len(materials) + 1) for y in (0, 1)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], [(2 * x, 2 * x + 2, 2 * x + 3, 2 * x + 1) for x in range(len(materials))])
    for index, shader in enumerate(materials):
        mesh.materials.append(shader)
        mesh.polygons[index].material_index = index
    return add(name, mesh)


def look_along(length_m: int) -> bpy.types.Scene:
    """A pixel for each square, in the third of the four lines that a picture has at least."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = length_m, 4
    scene.camera.data.ortho_scale = length_m
    scene.camera.location = (length_m / 2.0, 0.0, 3.0)
    return scene


def pictures(scene: bpy.types.Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    scene.tyndall.pixel_samples = 1
    ours = rendered_pixels(scene)[2]
    prepare_cycles(scene, 1, 1)
    return ours, rendered_pixels(scene)[2]


@pytest.fixture
def thing() -> bpy.types.Object:
    """Whose properties are asked for, and the scene's."""
    scene = empty_scene()
    kinds = [("OBJECT", name) for name in OF_OBJECT] + [("VIEW_LAYER", name) for name in OF_LAYER]
    kinds += [("INSTANCER", name) for name in ("share", "four")]
    made = strip("Strip", [shown(kind, name, output) for kind, name in kinds for output in OUTPUTS])
    made["share"], made["count"], made["flag"], made["with space"], made["text"] = 0.25, 3, True, 0.75, "x"
    made["two"], made["three"], made["four"] = (0.5, 0.6), (0.1, 0.2, 0.3), (0.1, 0.2, 0.3, 0.4)
    made["five"] = [0.1] * 5
    made["counts"], made["pass_index"] = (1, 2, 3), 0.33  # before the object's own
    made.data["of_data"], made.color, made.pass_index = 0.125, (0.2, 0.4, 0.6, 0.8), 7
    scene["of_scene"], scene.world["of_world"], bpy.context.view_layer["of_layer"] = 0.3, 0.6, 0.9
    return made


def test_properties_are_those_of_cycles(thing: bpy.types.Object) -> None:
    ours, cycles = pictures(look_along(len(thing.data.materials)))
    wrong = [
        f"{shader.name}: {found} is {wanted}"
        for shader, found, wanted in zip(thing.data.materials, ours, cycles, strict=True)
        if not np.allclose(found, wanted, rtol=1e-5, atol=1e-6)
    ]
    assert not wrong
    assert len({tuple(pixel) for pixel in cycles}) > 20, "they differ"
    assert not (last_render.statistics_of(bpy.context.scene.name) or {})["reports"]


def test_objects_that_share_a_material_have_their_own() -> None:
    """Copies that a collection instances as well: of these it is the object's that is instanced."""
    scene = empty_scene()
    shader = shown("OBJECT", "tint", "Color")
    for index, tint in enumerate(((1.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.5, 0.0), None)):
        made = strip(f"Strip {index}", [shader])
        made.location.x = index
        if tint is not None:
            made["tint"] = tint
    collection = bpy.data.collections.new("Instanced")
    collection.objects.link(made := strip("Hidden", [shader]))
    scene.collection.objects.unlink(made)
    made["tint"] = 0.25
    instancer = add("Instancer", None, (4.0, 0.0, 0.0))
    instancer.instance_type, instancer.instance_collection, instancer["tint"] = "COLLECTION", collection, 0.75
    ours, cycles = pictures(look_along(5))
    assert ours == pytest.approx(cycles, abs=1e-6)
    assert ours.sum(axis=1) == pytest.approx([1.0, 0.5, 0.5, 0.0, 0.75], abs=1e-6)
