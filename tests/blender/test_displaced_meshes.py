# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that move their meshes: the same surface, depth, light and shadows as in Cycles."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from support.closure_scenes import IS_OLD, errors
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, add, displace, empty_scene, light, material, mesh, node

BOUND = 0.01
SIDE = 40
New, Link = Callable[[str], bpy.types.Node], Callable[..., object]


def grid(name: str, shown: bpy.types.Material, *, is_smooth: bool) -> bpy.types.Object:
    """From -1 to 1, of quads, with a UV map."""
    corners = [(2 * x / SIDE - 1, 2 * y / SIDE - 1, 0.0) for y in range(SIDE + 1) for x in range(SIDE + 1)]
    first = [y * (SIDE + 1) + x for y in range(SIDE) for x in range(SIDE)]
    faces = [(at, at + 1, at + SIDE + 2, at + SIDE + 1) for at in first]
    data = mesh(name, corners, faces, shown)
    uvs = [(0.5 + 0.5 * corners[vertex][0], 0.5 + 0.5 * corners[vertex][1]) for face in faces for vertex in face]
    data.uv_layers.new().data.foreach_set("uv", np.array(uvs, np.float32).ravel())
    data.polygons.foreach_set("use_smooth", [is_smooth] * len(faces))
    return add(name, data)


def by_image(new: New, link: Link) -> bpy.types.NodeSocket:
    texture = new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("Heights", 16, 16, float_buffer=True)
    texture.image.colorspace_settings.name = "Non-Color"
    heights = np.ones((16, 16, 4), np.float32)
    heights[..., :3] = np.random.default_rng(3).random((16, 16, 1))
    texture.image.pixels.foreach_set(heights.ravel())
    link(new("ShaderNodeTexCoord").outputs["UV"], texture.inputs["Vector"])
    return texture.outputs["Color"]


def by_noise(coordinate: str) -> Build:
    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        texture = node(new, "ShaderNodeTexNoise", Scale=2.5, Detail=1.0)
        link(new("ShaderNodeTexCoord").outputs[coordinate], texture.inputs["Vector"])
        return texture.outputs[0]

    return build


def diffuse(new: New, _: Link) -> bpy.types.NodeSocket:
    return node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.6, 0.4, 1.0)).outputs[0]


def far(new: New, link: Link) -> bpy.types.NodeSocket:
    """Shines by its distance from the camera."""
    glow = new("ShaderNodeEmission")
    link(new("ShaderNodeCameraData").outputs["View Distance"], glow.inputs["Color"])
    return glow.outputs[0]


def displaced_grid(
    surface: Build, heights: Build, method: str = "DISPLACEMENT", *, is_smooth: bool = True, space: str = "OBJECT"
) -> bpy.types.Scene:
    """Seen and lit from aside, over a floor that it shadows."""
    scene = empty_scene(56)
    scene.camera.data.ortho_scale = 3.2
    scene.camera.location, scene.camera.rotation_euler = (0.0, -4.0, 2.6), (math.radians(57.0), 0.0, 0.0)

    def moved(new: New, link: Link) -> bpy.types.NodeSocket:
        displacement = node(new, "ShaderNodeDisplacement", Midlevel=0.4, Scale=0.5)
        displacement.space = space
        link(heights(new, link), displacement.inputs["Height"])
        return displacement.outputs[0]

    shown = material("Shown", surface)
    displace(shown, moved, method)
    thing = grid("Grid", shown, is_smooth=is_smooth)
    thing.rotation_euler, thing.scale = (0.1, 0.05, 0.4), (1.0, 0.9, 0.8)
    floor = mesh("Floor", [(-3, -3, -0.5), (3, -3, -0.5), (3, 3, -0.5), (-3, 3, -0.5)], [(0, 1, 2, 3)])
    floor.materials.append(material("Floor", surface))
    add("Floor", floor)
    sun = light("SUN", (0, 0, 5), energy=3.0, angle=0.0)
    sun.rotation_euler = (math.radians(35.0), math.radians(40.0), 0.0)
    return scene


HEIGHTS: dict[str, Build] = {"image": by_image, "noise": by_noise("Object"), "generated": by_noise("Generated")}


@pytest.mark.dealt
@pytest.mark.parametrize("is_smooth", [True, False], ids=["smooth", "flat"])
@pytest.mark.parametrize("name", HEIGHTS)
def test_a_moved_mesh_is_lit_as_in_cycles(name: str, is_smooth: bool) -> None:  # noqa: FBT001  a parameter
    scene = displaced_grid(diffuse, HEIGHTS[name], is_smooth=is_smooth)
    ours, cycles = tyndall_pixels(scene, 4), cycles_pixels(scene, 16, seed=1)
    assert max(errors(ours, cycles)) <= BOUND


@pytest.mark.parametrize("space", ["OBJECT", "WORLD"])
def test_a_moved_mesh_is_where_cycles_has_it(space: str) -> None:
    scene = displaced_grid(far, by_noise("Object"), space=space)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, 1, seed=1)
    off = np.abs(ours - cycles).max(axis=2)
    assert np.quantile(off, 0.98) < 1e-3  # rays through silhouettes may see what is behind
    assert off.mean() < 5e-3


@pytest.mark.parametrize("name", ["image", "noise"])
def test_what_is_moved_and_bumped_is_as_in_cycles(name: str) -> None:
    scene = displaced_grid(diffuse, HEIGHTS[name], "BOTH")
    for thing in scene.objects:
        if thing.name == "Grid":
            thing.scale = (1.0, 1.0, 1.0)
    mean, median = errors(tyndall_pixels(scene, 4), cycles_pixels(scene, 16, seed=1))
    assert median <= BOUND
    assert mean <= (2 * BOUND if IS_OLD else BOUND)  # what bumps shadow in the last degrees before dark


def test_one_of_two_materials_moves_its_part() -> None:
    scene = displaced_grid(diffuse, by_noise("Object"))
    data = bpy.data.meshes["Grid"]
    data.materials.append(material("Still", diffuse))
    data.polygons.foreach_set("material_index", [index % SIDE >= SIDE // 2 for index in range(SIDE * SIDE)])
    ours, cycles = tyndall_pixels(scene, 4), cycles_pixels(scene, 16, seed=1)
    assert max(errors(ours, cycles)) <= BOUND


def test_a_moved_mesh_is_sent_once_and_others_are_as_they_were() -> None:
    scene = displaced_grid(diffuse, by_noise("Object"))
    scene.render.use_persistent_data = True
    first = tyndall_pixels(scene)
    assert last_render.statistics_of("Scene")["counts"]["meshes sent"] == 2
    assert (tyndall_pixels(scene) == first).all()
    assert last_render.statistics_of("Scene")["counts"]["meshes sent"] == 0
    node_of_scale = next(each for each in bpy.data.materials["Shown"].node_tree.nodes if each.type == "DISPLACEMENT")
    node_of_scale.inputs["Scale"].default_value = 0.2
    assert (tyndall_pixels(scene) != first).any()
    assert last_render.statistics_of("Scene")["counts"]["meshes sent"] == 1
    assert not any("displace" in line for line in last_render.statistics_of("Scene")["reports"])
