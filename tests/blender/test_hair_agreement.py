# SPDX-License-Identifier: GPL-3.0-or-later
"""Is hair as in Cycles? Particle hair, hair curves and point clouds under a sun, their shadows, and their shafts.

The pictures' pixels are box-filtered squares, and hairs are thinner than some: compared are the mean and blocks.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Vector
from numpy.typing import NDArray

from support.cycles_reference import prepare_cycles, rendered_pixels, save_side_by_side
from support.small_scenes import CUBE_FACES, add, empty_scene, material, mesh, node, plane, read

PICTURES = Path(__file__).parents[2] / "out" / "hair_agreement"
SIZE_PX, BLOCK_PX = 90, 9
SAMPLES = 144


def stage() -> bpy.types.Scene:
    """A hard sun and a camera that looks down on a grey floor."""
    scene = empty_scene(SIZE_PX)
    scene.render.resolution_percentage = 100
    camera = scene.camera
    camera.data.type, camera.data.lens = "PERSP", 90.0
    camera.location = (1.2, -3.2, 2.2)
    camera.rotation_euler = (Vector((0, 0, 0.3)) - Vector(camera.location)).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = math.pi, 0.0
    add("Sun", sun).rotation_euler = (0.6, 0.5, 0.0)
    plane(-0.01, diffuse("Floor", (0.5, 0.5, 0.5, 1)))
    return scene


def diffuse(name: str, color: tuple[float, ...]) -> bpy.types.Material:
    return material(name, lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=color).outputs[0])


def furry(scene: bpy.types.Scene, shape: str) -> bpy.types.Object:
    """A patch with 300 hairs, of a material of their own; thick enough to be told from each other."""
    corners = [(-0.6, -0.6, 0), (0.6, -0.6, 0), (0.6, 0.6, 0), (-0.6, 0.6, 0)]
    patch = add("Patch", mesh("Patch", corners, [(0, 1, 2, 3)], diffuse("Skin", (0.1, 0.3, 0.1, 1))))
    patch.data.materials.append(diffuse("Hair", (0.7, 0.45, 0.2, 1)))
    patch.scale, patch.rotation_euler = (1.0, 1.0, 1.0), (0.0, 0.0, 0.3)
    patch.modifiers.new("Fur", "PARTICLE_SYSTEM")
    settings = patch.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length = "HAIR", 300, 0.7
    settings.factor_random = 0.05  # they stand at an angle each
    settings.brownian_factor = 0.03
    settings.render_step, settings.display_step = 3, 3
    settings.material = 2
    settings.radius_scale, settings.root_radius, settings.tip_radius, settings.shape = 1.0, 0.05, 0.01, 0.2
    scene.cycles_curves.shape = shape
    return patch


def both_engines(scene: bpy.types.Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    scene.render.engine, settings = "TYNDALL", scene.tyndall
    settings.pixel_samples, settings.noise_threshold = SAMPLES, 0.0
    settings.pixel_filter, settings.filter_width_px = "BOX", 1.0
    ours = rendered_pixels(scene)
    prepare_cycles(scene, SAMPLES, seed=1)
    scene.cycles.pixel_filter_type = "BOX"
    return ours, rendered_pixels(scene)


def block_means(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    blocks = SIZE_PX // BLOCK_PX
    return picture.reshape(blocks, BLOCK_PX, blocks, BLOCK_PX, 3).mean(axis=(1, 3))


def agree(name: str, ours: NDArray[np.float64], cycles: NDArray[np.float64]) -> None:
    save_side_by_side(PICTURES / f"{name}.png", ours, cycles)
    level = float(cycles.mean())
    errors = np.abs(block_means(ours) - block_means(cycles)).mean(axis=2)
    mean, median = abs(float(ours.mean()) / level - 1.0), float(np.median(errors)) / level
    print(f"{name}: mean {mean:.3%}, median block {median:.3%}, largest block {errors.max() / level:.3%}")
    assert mean < 0.01
    assert median < 0.01
    assert errors.max() < 0.08 * level


@pytest.mark.parametrize("shape", ["RIBBONS", "THICK"])
def test_particle_hair_is_lit_and_throws_shadows_as_in_cycles(shape: str) -> None:
    scene = stage()
    patch = furry(scene, shape)
    ours, cycles = both_engines(scene)
    agree(f"particles_{shape.lower()}", ours, cycles)
    patch.modifiers[0].show_render = False
    scene.render.engine = "TYNDALL"
    assert np.abs(rendered_pixels(scene) - ours).mean() > 0.1 * ours.mean()  # the hair is what was compared


def test_children_and_hidden_emitters_are_as_in_cycles() -> None:
    scene = stage()
    patch = furry(scene, "RIBBONS")
    settings = patch.particle_systems[0].settings
    settings.count, settings.child_type = 40, "SIMPLE"
    settings.rendered_child_count = 10
    settings.child_radius = 0.15
    patch.show_instancer_for_render = False
    agree("children", *both_engines(scene))


def made_by_nodes(data: bpy.types.ID, kinds: list[tuple[str, dict[str, object]]]) -> bpy.types.Object:
    """An object of which geometry nodes, one after another, make what it shows."""
    thing = add("Made", data)
    tree = bpy.data.node_groups.new("Made", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        for way in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    last = tree.nodes.new("NodeGroupInput").outputs[0]
    for kind, inputs in kinds:
        new = tree.nodes.new(kind)
        if hasattr(new, "spline_type"):  # poly curves are another thing in 5.0
            new.spline_type = "CATMULL_ROM"
        for name, value in inputs.items():
            new.inputs[name].default_value = value
        if new.inputs and new.inputs[0].type == "GEOMETRY":
            tree.links.new(last, new.inputs[0])
        last = new.outputs[0]
    tree.links.new(last, tree.nodes.new("NodeGroupOutput").inputs[0])
    thing.modifiers.new("Nodes", "NODES").node_group = tree
    return thing


@pytest.mark.parametrize("shape", ["RIBBONS", "THICK"])
def test_hair_curves_are_as_in_cycles(shape: str) -> None:
    """A thick arc that turns in space."""
    scene = stage()
    scene.cycles_curves.shape = shape
    arc = {"Resolution": 7, "Start": (-0.8, 0.0, -0.3), "Middle": (0.0, 0.8, 1.6), "End": (0.8, -0.3, -0.3)}
    look = {"Material": diffuse("Hair", (0.7, 0.45, 0.2, 1))}
    thing = made_by_nodes(
        bpy.data.hair_curves.new("Hair"),
        [
            ("GeometryNodeCurveQuadraticBezier", arc),
            ("GeometryNodeCurveSplineType", {}),
            ("GeometryNodeSetCurveRadius", {"Radius": 0.1}),
            ("GeometryNodeSetMaterial", look),
        ],
    )
    assert thing.type == "CURVES"
    assert len(read().strand_objects) == 1
    agree(f"curves_{shape.lower()}", *both_engines(scene))


def test_point_clouds_are_as_in_cycles() -> None:
    scene = stage()
    corners = [(0.3 * x, 0.3 * y, 0.3 * z) for x in (-2, -1, 1, 2) for y in (-1, 1) for z in (1, 3)]
    look = {"Material": diffuse("Beads", (0.7, 0.45, 0.2, 1))}
    made_by_nodes(
        mesh("Corners", corners, []),
        [("GeometryNodeMeshToPoints", {"Radius": 0.13}), ("GeometryNodeSetMaterial", look)],
    )
    assert sum(len(group.object_names) for group in read().strand_objects) == 1
    agree("points", *both_engines(scene))


@pytest.mark.parametrize("output", ["Intercept", "Length", "Thickness", "Random", "Tangent Normal"])
def test_hair_info_is_as_in_cycles(output: str) -> None:
    """As colours that glow: where a point lies on its hair, how thick that is, and the direction to the viewer."""
    scale = 10.0 if output == "Thickness" else 1.0
    scene = stage()
    patch = furry(scene, "THICK")

    def glowing(new, link):  # noqa: ANN001, ANN202
        info = new("ShaderNodeHairInfo")
        times = new("ShaderNodeVectorMath")
        times.operation = "ABSOLUTE"
        link(info.outputs[output], times.inputs[0])
        emission = node(new, "ShaderNodeEmission", Strength=scale)
        link(times.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    patch.data.materials[1] = material(f"Hair {output}", glowing)
    for name in ("Floor", "Skin"):  # Cycles lights them by the hair
        bpy.data.materials[name].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0, 0, 0, 1)
    ours, cycles = both_engines(scene)
    agree("info_" + output.lower().replace(" ", "_"), ours, cycles)


@pytest.mark.parametrize("method", ["EPIPOLAR", "SHADOW_MAP", "EXACT"])
def test_a_lock_of_hair_throws_shafts_as_in_cycles(method: str) -> None:
    """A furry patch hangs over a box of fog's floor, and dims the sun in the fog below."""
    scene = stage()
    patch = furry(scene, "RIBBONS")
    patch.location = (0.0, 0.0, 0.6)
    patch.show_instancer_for_render = False
    fog = material("Fog", None, lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.4).outputs[0])
    box = add("Fog", mesh("Fog", [(x, y, z) for x in (-3, 3) for y in (-6, 3) for z in (-2, 4)], CUBE_FACES, fog))
    box.display_type = "WIRE"
    scene.tyndall.shafts.method = method
    agree(f"shafts_{method.lower()}", *both_engines(scene))


def test_an_empty_system_and_broken_radii_are_named_once() -> None:
    scene = stage()
    patch = furry(scene, "RIBBONS")
    patch.particle_systems[0].settings.count = 0
    assert [line for line in read().reports if "Patch" in line] == [
        'Object "Patch", particle system "Fur": has no hair'
    ]
    patch.particle_systems[0].settings.count = 10
    patch.particle_systems[0].settings.radius_scale = 0.0
    groups = read().strand_objects
    assert len(groups) == 1
    assert not groups[0].strands.points[:, 3].any()
