# SPDX-License-Identifier: GPL-3.0-or-later
"""Are hair's own shaders as in Cycles? On bands, tubes and meshes, in every kind of light; and values along a hair.

All but the hair is black: nothing else is compared. Cycles' I0 is a series cut short, by up to 1.5 %.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Vector

from support.hair_scenes import agree, block_means, both_engines, furry, made_by_nodes, stage
from support.pass_pictures import render_passes
from support.small_scenes import add, material, mesh, node, read

IS_OLD = bpy.app.version < (4, 0, 0)
SAMPLES = 49
TAN, WHITE = (0.7, 0.45, 0.2, 1.0), (1.0, 1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0, 1.0)


def hair_look(kind: str, settings: dict[str, str], inputs: dict[str, Any]) -> bpy.types.Material:
    def build(new, link):  # noqa: ANN001, ANN202
        shader = new(kind)
        for name, value in settings.items():  # first: which inputs there are follows from them
            setattr(shader, name, value)
        for name, value in inputs.items():
            shader.inputs[name.replace("_", " ")].default_value = value
        return shader.outputs[0]

    return material("Hair look", build)


def principled(parametrization: str = "COLOR", **inputs: object) -> bpy.types.Material:
    return hair_look("ShaderNodeBsdfHairPrincipled", {"parametrization": parametrization}, inputs)


def hair_bsdf(component: str, **inputs: object) -> bpy.types.Material:
    return hair_look("ShaderNodeBsdfHair", {"component": component}, {"Color": TAN, **inputs})


def hard_sun(scene: bpy.types.Scene) -> None:
    """The stage's."""


def soft_sun(scene: bpy.types.Scene) -> None:
    bpy.data.lights["Sun"].angle = 0.3


def area_light(scene: bpy.types.Scene) -> None:
    """From behind: half of what hair sends on passes it."""
    bpy.data.lights["Sun"].energy = 0.0
    lamp = bpy.data.lights.new("Area", "AREA")
    lamp.energy, lamp.size = 150.0, 1.5
    thing = add("Area", lamp, (1.5, 1.5, 2.5))
    thing.rotation_euler = (Vector((0, 0, 0.3)) - thing.location).to_track_quat("-Z", "Y").to_euler()


def even_world(scene: bpy.types.Scene) -> None:
    bpy.data.lights["Sun"].energy = 0.0
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.4, 0.5, 0.7, 1.0)
    scene.render.film_transparent = True


def coloured() -> bpy.types.Material:
    return principled(Color=TAN)


def of_melanin() -> bpy.types.Material:
    """Every hair another."""
    varying = {"Random_Color": 0.5, "Random_Roughness": 0.6}
    colour = {"Melanin": 0.4, "Melanin_Redness": 0.4, "Tint": (1.0, 0.8, 0.6, 1.0)}
    return principled("MELANIN", Coat=0.5, Offset=math.radians(8.0), **colour, **varying)


def absorbing() -> bpy.types.Material:
    rough = {"Roughness": 0.6, "Radial_Roughness": 0.8}
    return principled("ABSORPTION", Absorption_Coefficient=(0.2, 0.4, 0.8), IOR=1.4, **rough)


def reflection() -> bpy.types.Material:
    return hair_bsdf("Reflection", RoughnessU=0.2, RoughnessV=0.6, Offset=0.1)


def transmission() -> bpy.types.Material:
    return hair_bsdf("Transmission", RoughnessU=0.2, RoughnessV=0.6, Offset=0.1)


def brushed() -> bpy.types.Material:
    """Gloss that is wider along the hair than across it: five times as much light as from even gloss."""
    kind = "ShaderNodeBsdfAnisotropic"
    return hair_look(kind, {}, {"Color": WHITE, "Roughness": 0.4, "Anisotropy": -0.8})


# Seen to fail: by 11 % of the mean with 3.x's scales in 4.5, by 13 % and more without the light from the other side.
@pytest.mark.dealt
@pytest.mark.parametrize(
    ("shape", "look", "light"),
    [
        ("RIBBONS", coloured, hard_sun),
        ("THICK", of_melanin, hard_sun),
        ("THICK", coloured, soft_sun),
        ("RIBBONS", absorbing, area_light),
        ("THICK", absorbing, even_world),
        ("RIBBONS", reflection, hard_sun),
        ("THICK", reflection, even_world),
        ("THICK", transmission, area_light),
        ("RIBBONS", transmission, even_world),
        ("THICK", brushed, hard_sun),
    ],
)
def test_hair_is_lit_as_in_cycles(
    shape: str, look: Callable[[], bpy.types.Material], light: Callable[[bpy.types.Scene], None]
) -> None:
    scene = stage()
    patch = furry(scene, shape)
    patch.data.materials[1] = look()
    for name in ("Floor", "Skin"):
        bpy.data.materials[name].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = BLACK
    light(scene)
    pictures = both_engines(scene, SAMPLES)
    is_noisy = light in {area_light, even_world} or look is brushed  # in both engines
    bounds = {"mean_bound": 0.015, "median_bound": 0.04 if is_noisy else 0.015, "block_bound": 0.2}
    agree(f"{look.__name__}_{shape.lower()}_{light.__name__}", *pictures, block_px=18, **bounds)
    assert not [line for line in read().reports if "Hair look" in line]


# Seen to fail: coloured ones from the front, by 15 %, with a direction that is the same from both sides.
@pytest.mark.dealt
@pytest.mark.parametrize("side_seen", ["front", "back"])
@pytest.mark.parametrize("towards", [0.5, 2.6], ids=["from ahead", "from behind"])
@pytest.mark.parametrize("look", [coloured, reflection, transmission])
def test_cards_of_hair_are_lit_as_in_cycles(
    look: Callable[[], bpy.types.Material], towards: float, side_seen: str
) -> None:
    """Meshes have a direction along them for each triangle, which is another one from behind."""
    if look is coloured and bpy.app.version >= (5, 0, 0):
        pytest.skip("Cycles 5.0 leaves out what comes from across the plane through hair and viewer")
    scene = stage()
    for name in ("Plane", "Camera"):
        bpy.data.objects.remove(bpy.data.objects[name])
    scene.camera = add("Camera", bpy.data.cameras.new("Camera"), (0, 0, 3))
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 2.0
    bpy.data.objects["Sun"].rotation_euler = (towards, 0.4, 0.0)
    random = np.random.default_rng(3)
    side = 7
    corners = [
        (2 * x / (side - 1) - 1, 2 * y / (side - 1) - 1, 0.3 * random.random())
        for x in range(side)
        for y in range(side)
    ]
    faces = [(at, at + 1, at + side + 1, at + side) for at in range(side * (side - 1)) if at % side < side - 1]
    if side_seen == "front":
        faces = [face[::-1] for face in faces]
    add("Card", mesh("Card", corners, faces, look())).rotation_euler = (0.2, 0.1, 0.3)
    ours, cycles = both_engines(scene, 16)
    is_dark = (look is reflection and towards > 1.0) or (look is transmission and towards < 1.0)
    if is_dark:
        assert ours.max() == cycles.max() == 0.0
    else:
        # Blocks: at edges of sharp mirror images.
        agree(f"card_{look.__name__}_{towards}_{side_seen}", ours, cycles, block_bound=0.2)


def test_colours_that_vary_along_a_hair_are_as_in_cycles() -> None:
    """Attributes of a hair's points, straight between them; and those of whole hairs."""
    scene = stage()
    scene.cycles_curves.shape = "THICK"

    def glowing(new, link):  # noqa: ANN001, ANN202
        mix = node(new, "ShaderNodeEmission", Strength=1.0)
        attribute = new("ShaderNodeAttribute")
        attribute.attribute_name = "along"
        link(attribute.outputs["Color"], mix.inputs["Color"])
        return mix.outputs[0]

    arc = {"Resolution": 5, "Start": (-0.8, 0.0, -0.3), "Middle": (0.0, 0.8, 1.6), "End": (0.8, -0.3, -0.3)}
    thing = made_by_nodes(
        bpy.data.hair_curves.new("Hair"),
        [
            ("GeometryNodeCurveQuadraticBezier", arc),
            ("GeometryNodeCurveSplineType", {}),
            ("GeometryNodeSetCurveRadius", {"Radius": 0.1}),
            ("GeometryNodeStoreNamedAttribute", {"Name": "along"}),
            ("GeometryNodeSetMaterial", {"Material": material("Glow", glowing)}),
        ],
    )
    tree = thing.modifiers["Nodes"].node_group
    store = next(one for one in tree.nodes if one.bl_idname == "GeometryNodeStoreNamedAttribute")
    store.domain = "POINT"
    value = next(one for one in store.inputs if one.name == "Value" and one.enabled)
    tree.links.new(tree.nodes.new("GeometryNodeSplineParameter").outputs["Factor"], value)
    floor = bpy.data.materials["Floor"].node_tree.nodes["Diffuse BSDF"]
    floor.inputs["Color"].default_value = BLACK  # Cycles lights it by the hair
    agree("along", *both_engines(scene, 36))
    (group,) = read().strand_objects
    assert {len(values) for _, values in group.strands.uv_maps} == {len(group.strands.points)}


def test_huangs_model_is_named() -> None:
    if IS_OLD:
        pytest.skip("from 4.0 on")
    scene = stage()
    patch = furry(scene, "RIBBONS")
    patch.data.materials[1] = hair_look("ShaderNodeBsdfHairPrincipled", {"model": "HUANG"}, {})
    (line,) = [line for line in read().reports if "Hair look" in line]
    assert line == "Material \"Hair look\": Principled Hair BSDF's model HUANG is drawn as Chiang's"


def told_of_object(new, link):  # noqa: ANN001, ANN201
    """Colour and random number of the object, and its index, as light."""
    info, emission, sum_of_all = new("ShaderNodeObjectInfo"), new("ShaderNodeEmission"), new("ShaderNodeVectorMath")
    numbers = new("ShaderNodeCombineXYZ")
    link(info.outputs["Random"], numbers.inputs[0])
    link(info.outputs["Object Index"], numbers.inputs[1])
    link(info.outputs["Color"], sum_of_all.inputs[0])
    link(numbers.outputs[0], sum_of_all.inputs[1])
    link(sum_of_all.outputs[0], emission.inputs["Color"])
    return emission.outputs[0]


def shown(kind: str, output: str) -> Callable[..., Any]:
    """A vector as light, which is not negative."""

    def build(new, link):  # noqa: ANN001, ANN202
        emission, moved = new("ShaderNodeEmission"), new("ShaderNodeVectorMath")
        moved.inputs[1].default_value = (1.0, 1.0, 1.0)
        link(new(kind).outputs[output], moved.inputs[0])
        link(moved.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    return build


TOLD = {
    "object": told_of_object,
    "place": shown("ShaderNodeTexCoord", "Generated"),
    "way": shown("ShaderNodeNewGeometry", "Tangent"),
}


# Seen to fail: white objects of number 0, coordinates of 0 and tangents around the object, as all of them were.
@pytest.mark.dealt
@pytest.mark.parametrize(
    ("kind", "what"),
    [
        (kind, what)
        for kind in ("particles", "curves", "points")
        for what in TOLD
        if (kind, what) != ("points", "way")  # no number in Cycles
    ],
)
def test_strands_and_points_tell_of_their_object_as_in_cycles(kind: str, what: str) -> None:
    scene = stage()
    scene.view_layers[0].use_pass_object_index = True
    told = material("Told", TOLD[what])
    if kind == "particles":
        thing = furry(scene, "THICK")
        thing.data.materials[1] = told
    elif kind == "curves":
        arc = {"Resolution": 5, "Start": (-0.8, 0.0, -0.3), "Middle": (0.0, 0.8, 1.6), "End": (0.8, -0.3, -0.3)}
        nodes = [("GeometryNodeCurveQuadraticBezier", arc), ("GeometryNodeCurveSplineType", {})]
        nodes += [("GeometryNodeSetCurveRadius", {"Radius": 0.2}), ("GeometryNodeSetMaterial", {"Material": told})]
        thing = made_by_nodes(bpy.data.hair_curves.new("Hair"), nodes)
    else:
        nodes = [("GeometryNodeMeshToPoints", {"Radius": 0.4}), ("GeometryNodeSetMaterial", {"Material": told})]
        thing = made_by_nodes(mesh("Corners", [(-0.6, 0, 0.4), (0.6, 0, 0.4)], []), nodes)
    thing.color, thing.pass_index = (0.2, 0.9, 0.4, 1.0), 3
    for name in {"Floor", "Skin"} & set(bpy.data.materials.keys()):  # Cycles lights them by what glows
        bpy.data.materials[name].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = BLACK
    agree(f"told_{what}_{kind}", *both_engines(scene, 36))
    with tempfile.TemporaryDirectory() as folder:
        planes = render_passes(scene, Path(folder), "TYNDALL", 1).planes
    index = planes.get("IndexOB", planes.get("Object Index"))
    assert set(np.unique(index)) == {0.0, 3.0}


# Seen to fail: hair had no coordinates.
@pytest.mark.dealt
def test_the_pass_of_hairs_coordinates_is_cycles() -> None:
    """Those of the emitter at the root of each, though no material asks for them."""
    scene = stage()
    scene.view_layers[0].use_pass_uv = True
    patch = furry(scene, "THICK")
    layer = patch.data.uv_layers.new()
    for corner, place in zip(layer.data, [(0.1, 0.9), (0.8, 0.7), (0.9, 0.2), (0.3, 0.0)], strict=True):
        corner.uv = place
    bpy.data.objects["Plane"].hide_render = True
    with tempfile.TemporaryDirectory() as folder:
        ours, cycles = (render_passes(scene, Path(folder), engine, 49).planes["UV"] for engine in ("TYNDALL", "CYCLES"))
    ours, cycles = block_means(ours), block_means(cycles)
    error = np.abs(ours - cycles)
    assert error.mean() < 0.01 * cycles.mean()
    assert np.quantile(error, 0.99) < 0.1 * cycles.max()
