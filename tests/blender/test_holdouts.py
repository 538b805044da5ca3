# SPDX-License-Identifier: GPL-3.0-or-later
"""Holes in the picture are Cycles': Holdout nodes, alone and mixed; held out objects, collections, instancers."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, Node, add, cube, empty_scene, light, material, node, plane, read

pytestmark = pytest.mark.dealt

New, Link = Callable[[str], Node], Callable[..., object]
Socket = bpy.types.NodeSocket


def emission(new: New, _link: Link) -> Socket:
    return node(new, "ShaderNodeEmission", Color=(0.9, 0.4, 0.2, 1.0), Strength=0.6).outputs[0]


def diffuse(new: New, _link: Link) -> Socket:
    return node(new, "ShaderNodeBsdfDiffuse", Color=(0.2, 0.5, 0.8, 1.0)).outputs[0]


def clear(new: New, _link: Link) -> Socket:
    return node(new, "ShaderNodeBsdfTransparent", Color=(0.9, 0.9, 0.9, 1.0)).outputs[0]


def holdout(new: New, _link: Link) -> Socket:
    return new("ShaderNodeHoldout").outputs[0]


def mixed(first: Build, second: Build, share: float) -> Build:
    def build(new: New, link: Link) -> Socket:
        mix = new("ShaderNodeMixShader")
        mix.inputs[0].default_value = share
        for index, shader in enumerate((first, second)):
            link(shader(new, link), mix.inputs[1 + index])
        return mix.outputs[0]

    return build


def chequered(new: New, link: Link) -> Socket:
    """A share that no program knows without its point."""
    checker = node(new, "ShaderNodeTexChecker", Color1=(0.8, 0.8, 0.8, 1.0), Color2=(0.1, 0.1, 0.1, 1.0), Scale=0.7)
    link(new("ShaderNodeTexCoord").outputs["Object"], checker.inputs["Vector"])
    mix = new("ShaderNodeMixShader")
    link(checker.outputs["Color"], mix.inputs[0])
    link(diffuse(new, link), mix.inputs[1])
    link(holdout(new, link), mix.inputs[2])
    return mix.outputs[0]


MATERIALS: dict[str, Build] = {
    "alone": holdout,
    "beside diffuse": mixed(holdout, diffuse, 0.3),
    "beside transparent": mixed(clear, holdout, 0.4),
    "beside emission": mixed(emission, holdout, 0.7),
    "by a pattern": chequered,
}
OBJECTS: dict[str, Build] = {"opaque": diffuse, "half clear": mixed(clear, diffuse, 0.6), "glowing": emission}


def stage() -> bpy.types.Scene:
    """A glowing square and the sky behind what is to be held out."""
    scene = empty_scene(16)
    scene.camera.data.ortho_scale, scene.camera.location.z = 4.0, 5.0
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.3, 0.3, 0.5, 1.0)
    plane(-0.5, material("Floor", surface=emission), half_side=1.2)
    sun = light("SUN", (0, 0, 5), energy=2.0, angle=0.0)
    sun.rotation_euler = (0.4, 0.2, 0.0)
    return scene


def cover(surface: Build) -> bpy.types.Object:
    """Covers half of the square, and some of the sky."""
    thing = cube("Cover", material("Cover", surface=surface))
    thing.location, thing.scale = (1.0, 0.3, 0.4), (1.0, 1.4, 0.02)
    return thing


def in_own_collection(thing: bpy.types.Object) -> bpy.types.LayerCollection:
    collection = bpy.data.collections.new(f"Of {thing.name}")
    bpy.context.scene.collection.children.link(collection)
    bpy.context.scene.collection.objects.unlink(thing)
    collection.objects.link(thing)
    return bpy.context.view_layer.layer_collection.children[collection.name]


def check_against_cycles(scene: bpy.types.Scene, cycles_samples: int = 64) -> None:
    """Cycles picks closures and layers at random: blocks of pixels are compared."""
    for is_transparent in (True, False):
        scene.render.film_transparent = is_transparent
        ours, cycles = tyndall_pixels(scene, 4, "RGBA"), cycles_pixels(scene, cycles_samples, 1, "RGBA")
        assert np.ptp(cycles[..., 3]) > 0.05
        blocks = [image.reshape(4, 4, 4, 4, 4).mean(axis=(1, 3)) for image in (ours, cycles)]
        print(f"film {is_transparent}: {np.abs(blocks[0] - blocks[1]).max(axis=(0, 1))}")
        assert np.abs(blocks[0] - blocks[1]).max() <= 0.005
        assert np.abs(ours.mean(axis=(0, 1)) - cycles.mean(axis=(0, 1))).max() <= 0.004


@pytest.mark.parametrize("surface", MATERIALS.values(), ids=MATERIALS.keys())
def test_holdout_nodes_are_those_of_cycles(surface: Build) -> None:
    scene = stage()
    cover(surface)
    check_against_cycles(scene)
    assert not read().reports


@pytest.mark.parametrize("surface", OBJECTS.values(), ids=OBJECTS.keys())
def test_held_out_objects_are_those_of_cycles(surface: Build) -> None:
    scene = stage()
    cover(surface).is_holdout = True
    check_against_cycles(scene)
    assert not [line for line in read().reports if "held out" in line or "holdout" in line]


def test_a_held_out_collection_is_that_of_cycles() -> None:
    scene = stage()
    in_own_collection(cover(diffuse)).holdout = True
    check_against_cycles(scene)


def test_what_a_held_out_instancer_shows_is_held_out_and_nothing_else() -> None:
    scene = stage()
    twig = bpy.data.collections.new("Twig")
    leaf = cube("Leaf", material("Leaf", surface=diffuse))
    leaf.scale = (0.3, 0.3, 0.02)
    scene.collection.objects.unlink(leaf)
    twig.objects.link(leaf)
    for index in range(2):
        instancer = add(f"Instancer {index}", None, (1.5 * index - 0.8, 0.4, 0.3))
        instancer.instance_type, instancer.instance_collection = "COLLECTION", twig
        instancer.is_holdout = index == 1
    flags = sorted(group.is_held_out for group in read().instances if group.object_names[0] == "Leaf")
    assert flags == [False, True]
    check_against_cycles(scene)


def test_fog_before_a_hole_stays_as_in_cycles() -> None:
    scene = stage()
    cover(diffuse).is_holdout = True
    fog = cube(
        "Fog", material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.3).outputs[0])
    )
    fog.location.z, fog.scale = 1.6, (4.0, 4.0, 1.0)
    check_against_cycles(scene, cycles_samples=1024)
