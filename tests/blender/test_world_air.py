# SPDX-License-Identifier: GPL-3.0-or-later
"""The world's volume where nodes vary it: beside Cycles in a closed room, and the box that it fills."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy
import numpy as np
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.followed_scene import Followed
from support.small_scenes import Build, Node, cube, empty_scene, light, material, node, read
from tyndall.scene_description import SceneDescription

New, Link = Callable[[str], Node], Callable[..., object]
Socket = bpy.types.NodeSocket


def room(fog: Build) -> bpy.types.Scene:
    """Grey walls around a lamp and a camera in one of their corners, all of it filled with ``fog``."""
    scene = empty_scene(size_px=24)
    walls = cube("Walls", material("Walls", surface=lambda new, _: new("ShaderNodeBsdfDiffuse").outputs[0]))
    walls.scale = (2.0, 2.0, 2.0)
    light("POINT", (0.7, 0.3, 1.2), energy=40.0, shadow_soft_size=0.0)
    camera = scene.camera
    camera.data.type, camera.data.angle = "PERSP", 1.2
    camera.location, camera.rotation_euler = (-1.6, -1.6, -0.4), (1.6, 0.0, -0.785)
    tree = scene.world.node_tree
    tree.links.new(fog(tree.nodes.new, tree.links.new), tree.nodes["World Output"].inputs["Volume"])
    scene.world.cycles.volume_step_size = 0.05
    return scene


def height(new: New, link: Link, top_m: float = 1.5) -> Socket:
    """0.8 at the floor, 0 from ``top_m`` on, below the ceiling."""
    position, parts, ramp = (new(f"ShaderNode{kind}") for kind in ("NewGeometry", "SeparateXYZ", "MapRange"))
    link(position.outputs["Position"], parts.inputs[0])
    link(parts.outputs["Z"], ramp.inputs["Value"])
    for name, value in {"From Min": -2.0, "From Max": top_m, "To Min": 0.8, "To Max": 0.0}.items():
        ramp.inputs[name].default_value = value
    return ramp.outputs[0]


def lumps(output: str | None) -> Build:
    """Noise at an output of Texture Coordinate, or without a vector."""

    def build(new: New, link: Link) -> Socket:
        noise = node(new, "ShaderNodeTexNoise", Scale=0.8, Detail=0.0)
        if output is not None:
            link(new("ShaderNodeTexCoord").outputs[output], noise.inputs["Vector"])
        return noise.outputs[0]

    return build


def varying(kind: str, socket: str, by: Build, **inputs: object) -> Build:
    def build(new: New, link: Link) -> Socket:
        shader = node(new, kind, **inputs)
        link(by(new, link), shader.inputs[socket])
        return shader.outputs[0]

    return build


def noise_node() -> Node:
    return next(node for node in bpy.context.scene.world.node_tree.nodes if node.type == "TEX_NOISE")


def box_of(description: SceneDescription) -> tuple[np.ndarray, np.ndarray]:
    """Of the voxels of its one volume, to a voxel."""
    grid = description.volumes[0].grid.grid
    first, behind = grid.leaf_origins.min(axis=0), grid.leaf_origins.max(axis=0) + 8
    step, origin = np.diag(grid.local_from_index)[:3], grid.local_from_index[:3, 3]
    return origin + first * step, origin + behind * step


@pytest.mark.dealt
@pytest.mark.parametrize("place", ["height", "Object", "Generated", "nothing"])
def test_a_room_of_varying_absorption_is_cycles_pixel_by_pixel(place: str) -> None:
    """Absorption that is marched has no noise in Cycles, but for where its steps begin."""
    by = height if place == "height" else lumps(None if place == "nothing" else place)
    scene = room(varying("ShaderNodeVolumeAbsorption", "Density", by, Color=(0.2, 0.5, 0.9, 1.0)))
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=64, seed=1)
    assert cycles.min() < 0.3 * cycles.max()
    assert ours.mean(axis=(0, 1)) == pytest.approx(cycles.mean(axis=(0, 1)), rel=2e-3)
    assert np.median(np.abs(ours / cycles - 1.0)) < 3e-3


@pytest.mark.dealt
@pytest.mark.parametrize("kind", ["density", "colour"])
def test_a_room_of_varying_fog_scatters_as_in_cycles(kind: str) -> None:
    fog = {
        "density": varying("ShaderNodeVolumePrincipled", "Density", height, Anisotropy=0.3),
        "colour": varying("ShaderNodeVolumeScatter", "Color", lumps("Object"), Density=0.3),
    }[kind]
    scene = room(fog)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, samples=1024, seed=1)
    assert ours.mean() == pytest.approx(cycles.mean(), rel=5e-3)


def test_the_box_holds_what_is_drawn_and_lamps_but_no_sun_and_is_told() -> None:
    scene = room(varying("ShaderNodeVolumeScatter", "Density", lumps("Object")))
    light("SUN", (0, 0, 900))
    light("POINT", (0, 7, 0))
    far = cube("Far", material("Far"))
    far.location = (5000.0, 0.0, 0.0)
    scene.camera.data.clip_end = 20.0
    description = read()
    lower, upper = box_of(description)
    assert description.world.medium == -1
    assert (lower < -2.0).all()
    assert upper[1] > 7.0
    assert 18.4 < upper[0] < 22.0  # as far as the camera sees, and a margin
    assert upper[2] < 6.0
    (told,) = (line for line in description.reports if "box" in line)
    assert told.startswith('World "World": its volume varies')


def test_a_camera_that_moves_a_little_leaves_the_voxels_where_they_are() -> None:
    """Else an animation would flicker by what lies between them."""
    scene = room(varying("ShaderNodeVolumeScatter", "Density", lumps("Object")))
    keys = []
    for y in (-2.5, -2.6, -9.0):
        scene.camera.location.y = y
        bpy.context.view_layer.update()
        keys.append(read().volumes[0].grid.key)
    assert keys[0] == keys[1] != keys[2]


def test_what_does_not_vary_stays_without_bounds() -> None:
    def both(new: New, link: Link) -> Socket:
        shader = new("ShaderNodeAddShader")
        link(node(new, "ShaderNodeVolumeAbsorption", Density=0.25).outputs[0], shader.inputs[0])
        link(varying("ShaderNodeVolumeScatter", "Density", lumps("Object"))(new, link), shader.inputs[1])
        return shader.outputs[0]

    scene = room(both)
    description = read()
    assert len(description.volumes) == 1
    assert description.media[description.world.medium].sigma_t_per_m() == pytest.approx((0.05,) * 3)
    scene.world.node_tree.links.remove(noise_node().outputs[0].links[0])
    description = read()
    assert not description.volumes
    assert not any("box" in line for line in description.reports)


def test_air_in_layers_has_voxels_that_are_thin_upwards_alone() -> None:
    room(varying("ShaderNodeVolumeScatter", "Density", partial(height, top_m=-1.7)))
    step = np.diag(read().volumes[0].grid.grid.local_from_index)[:3]
    assert step[0] == pytest.approx(step[1])
    assert step[2] < 0.3 * step[0]


def test_a_viewport_follows_air_that_varies() -> None:
    room(varying("ShaderNodeVolumeScatter", "Density", lumps("Object")))
    followed = Followed()
    with followed.hears():
        first = followed.read().volumes[0].grid
        bpy.data.objects["Walls"].location.z = -3.0
        lower, _ = box_of(followed.read())
        assert lower[2] < -5.0
        noise_node().inputs["Scale"].default_value = 0.4
        assert followed.read().volumes[0].grid.key != first.key
        bpy.context.scene.world.node_tree.links.remove(noise_node().outputs[0].links[0])
        assert not followed.read().volumes
