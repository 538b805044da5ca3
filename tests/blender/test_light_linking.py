# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: an emitter lights what its collection says, and only what that says blocks it."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon.sync.scene import SceneReader
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import add, cube, empty_scene, light, material, node, placements, plane, read
from tyndall.scene_description import ALL_SETS

pytestmark = pytest.mark.skipif(bpy.app.version < (4, 0, 0), reason="Blender links lights from 4.0 on")

SIZE_PX = 24
WHITE = (1.0, 1.0, 1.0, 1.0)
Picture = NDArray[np.float64]


def link(emitter: bpy.types.Object, kind: str, *things: bpy.types.Object, state: str = "INCLUDE") -> None:
    """``kind``: receiver or blocker."""
    collection = bpy.data.collections.new(kind)
    for thing in things:
        collection.objects.link(thing)
    for entry in collection.collection_objects:
        entry.light_linking.link_state = state
    setattr(emitter.light_linking, f"{kind}_collection", collection)


def emitter(kind: str) -> bpy.types.Object:
    """From the upper right."""
    if kind == "SUN":
        found = light("SUN", (3, -3, 5), energy=3.0, angle=0.05)
    elif kind == "GLOW":
        glowing = material("Glow", surface=lambda new, _: node(new, "ShaderNodeEmission", Strength=30.0).outputs[0])
        found = plane(0.0, glowing, half_side=0.5)
        found.location = (3, -3, 5)
    else:
        sizes = {"AREA": {"size": 0.6}, "POINT": {"shadow_soft_size": 0.2}}
        found = light(kind, (3, -3, 5), energy=700.0, **sizes[kind])
    found.rotation_euler = (0.6, 0.5, 0)
    if kind == "GLOW":  # its front looks down
        found.rotation_euler = (0.6 + np.pi, 0.5, 0)
    return found


@pytest.fixture
def stage() -> bpy.types.Scene:
    """Two cubes on a floor, seen from above, where they shadow the floor and one another."""
    scene = empty_scene(SIZE_PX)
    scene.camera.location, scene.camera.rotation_euler = (0, -7, 7), (0.75, 0, 0)
    scene.camera.data.type = "PERSP"
    plane(half_side=4)
    for name, x in (("Left", -1.2), ("Right", 0.8)):
        box = cube(name)
        box.scale, box.location = (0.6, 0.6, 0.8), (x, 0, 0.8)
    return scene


def add_fog(name: str, x: float, shared: bpy.types.Material | None = None) -> bpy.types.Object:
    fog = shared or material(
        "Fog",
        volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.15, Color=WHITE, Anisotropy=0.2).outputs[
            0
        ],
    )
    box = cube(name, fog)
    box.scale, box.location = (1.5, 2.5, 1.5), (x, 0, 1.6)
    return box


def assert_like_cycles(scene: bpy.types.Scene, samples: int = 128) -> None:
    """Means, and blocks of 4 x 4 pixels, to the noise that two seeds tell."""
    ours = tyndall_pixels(scene, 64)
    first, second = (cycles_pixels(scene, samples, seed) for seed in (1, 2))
    mine, one, two = (
        picture.reshape(SIZE_PX // 4, 4, SIZE_PX // 4, 4, 3).mean((1, 3)) for picture in (ours, first, second)
    )
    theirs, spread = (one + two) / 2, float(np.sqrt(((one - two) ** 2).mean() / 2))
    assert theirs.mean() > 0.005
    assert mine.mean() == pytest.approx(theirs.mean(), rel=0.01, abs=spread / 6)
    assert float(np.sqrt(((mine - theirs) ** 2).mean())) < 2 * spread + 0.012 * theirs.mean()


@pytest.mark.parametrize(
    ("kind", "state"),
    [
        ("POINT", "INCLUDE"),
        ("SUN", "EXCLUDE"),
        ("GLOW", "EXCLUDE"),
        *(
            pytest.param(kind, state, marks=pytest.mark.long)
            for kind, state in (
                ("POINT", "EXCLUDE"),
                ("SUN", "INCLUDE"),
                ("AREA", "INCLUDE"),
                ("AREA", "EXCLUDE"),
                ("GLOW", "INCLUDE"),
            )
        ),
    ],
)
def test_surfaces_are_lit_and_shadowed_as_in_cycles(stage: bpy.types.Scene, kind: str, state: str) -> None:
    """One light of each kind, linked both ways, beside a sun that is not."""
    light("SUN", (0, 0, 5), energy=0.4).rotation_euler = (-0.4, 0.2, 0)
    linked, left, right = emitter(kind), bpy.data.objects["Left"], bpy.data.objects["Right"]
    link(linked, "receiver", *((left, bpy.data.objects["Plane"]) if state == "INCLUDE" else (left,)), state=state)
    link(linked, "blocker", right, state=state)
    assert_like_cycles(stage)


def test_what_a_light_does_not_reach_is_as_without_it(stage: bpy.types.Scene) -> None:
    """And the rest as if it reached all, bit for bit."""
    lamp, left = emitter("POINT"), bpy.data.objects["Left"]
    lamp.data.shadow_soft_size = 0.0
    light("SUN", (0, 0, 5), energy=0.4, angle=0.0)
    lit = tyndall_pixels(stage)
    link(lamp, "receiver", left, state="EXCLUDE")
    linked = tyndall_pixels(stage)
    lamp.hide_render = True
    unlit = tyndall_pixels(stage)
    is_as_unlit = (linked == unlit).all(-1) & (linked != lit).any(-1)
    assert is_as_unlit.sum() > 10
    assert (is_as_unlit | (linked == lit).all(-1)).all()


@pytest.mark.parametrize("method", ["EXACT", "EPIPOLAR", "SHADOW_MAP"])
@pytest.mark.parametrize("kind", ["POINT", "SUN"])
def test_shafts_see_only_the_blockers(stage: bpy.types.Scene, kind: str, method: str) -> None:
    """As if the others cast no shadow at all."""
    add_fog("Fog", 0.0)
    lamp, right = emitter(kind), bpy.data.objects["Right"]
    shadowed = shafts_by(stage, method)
    link(lamp, "blocker", right, state="EXCLUDE")
    linked = shafts_by(stage, method)
    lamp.light_linking.blocker_collection = None
    right.visible_shadow = False
    expected = shafts_by(stage, method)
    assert np.abs(linked - expected).max() < 1e-6
    assert np.abs(shadowed - expected).max() > 0.02


def shafts_by(scene: bpy.types.Scene, method: str) -> Picture:
    from support.cycles_reference import rendered_pixels  # noqa: PLC0415 - only this asks for a method

    scene.render.engine = "TYNDALL"
    ours = scene.tyndall
    ours.pixel_samples, ours.shafts.method, ours.shafts.adapts_strata = 4, method, False
    ours.shafts.resolution = 1024
    return rendered_pixels(scene)


@pytest.mark.dealt
def test_blockers_shape_shafts_and_fog_is_a_receiver_as_in_cycles(stage: bpy.types.Scene) -> None:
    """Two boxes of one fog: the lamp lights one of them; a sun lights both."""
    first = add_fog("Lit", 1.55)
    second = add_fog("Unlit", -1.55, first.data.materials[0])
    light("SUN", (0, 0, 5), energy=0.3).rotation_euler = (-0.4, 0.2, 0)
    lamp = emitter("POINT")
    link(lamp, "receiver", second, state="EXCLUDE")
    link(lamp, "blocker", bpy.data.objects["Left"], state="EXCLUDE")
    assert_like_cycles(stage, 256)
    with_fog = tyndall_pixels(stage)
    lamp.light_linking.receiver_collection = None
    assert np.abs(tyndall_pixels(stage) - with_fog).max() > 0.02


def test_fog_that_no_collection_includes_is_dark_and_dims_all_the_same(stage: bpy.types.Scene) -> None:
    fog = add_fog("Fog", 0.0)
    lamp = emitter("POINT")
    lamp.data.shadow_soft_size = 0.0
    link(lamp, "receiver", bpy.data.objects["Plane"], bpy.data.objects["Left"], bpy.data.objects["Right"])
    scattering = tyndall_pixels(stage)
    absorbing = material(
        "Smoke",
        volume=lambda new, _: node(new, "ShaderNodeVolumeAbsorption", Density=0.15, Color=(0, 0, 0, 1)).outputs[0],
    )
    fog.data.materials[0] = absorbing
    lamp.light_linking.receiver_collection = None
    assert np.abs(tyndall_pixels(stage) - scattering).max() < 1e-6
    assert scattering.max() > 0.05


def test_collections_sort_objects_into_sets_as_blender_does(stage: bpy.types.Scene) -> None:
    """A child collection's state holds for all below it; where some are included, no others count."""
    lamp, sun = emitter("POINT"), emitter("SUN")
    left, right, floor = (bpy.data.objects[name] for name in ("Left", "Right", "Plane"))
    nested, inner = bpy.data.collections.new("nested"), bpy.data.collections.new("inner")
    inner.objects.link(left)
    nested.children.link(inner)
    outer = bpy.data.collections.new("outer")
    outer.children.link(nested)
    outer.collection_children[0].light_linking.link_state = "EXCLUDE"
    lamp.light_linking.receiver_collection = outer
    link(sun, "receiver", right)
    description = read()
    set_of = {}
    for thing in (left, right, floor):
        (group,) = placements(description, thing.name)
        set_of[thing.name] = 0 if group.lighting is None else group.lighting.receiver_set
    assert set_of["Plane"] == 0
    assert len(set(set_of.values())) == 3
    links = {found.name: found.links for found in description.lights}
    assert links["Point"].receiver_sets == ALL_SETS & ~(1 << set_of["Left"])
    assert links["Sun"].receiver_sets == 1 << set_of["Right"]
    assert links["Sun"].blocker_sets == ALL_SETS


def test_an_instancer_links_what_it_instances(stage: bpy.types.Scene) -> None:
    boxes = bpy.data.collections.new("Boxes")
    box = bpy.data.objects["Left"]
    boxes.objects.link(box)
    stage.collection.objects.unlink(box)
    placed = [add(f"At {x}", None, (x, 2, 0)) for x in (-1, 1)]
    for thing in placed:
        thing.instance_type, thing.instance_collection = "COLLECTION", boxes
    link(emitter("POINT"), "receiver", placed[0], state="EXCLUDE")
    sets = [0 if group.lighting is None else group.lighting.receiver_set for group in placements(read(), "Left")]
    assert sorted(sets) == [0, 1]


def test_a_live_scene_follows_its_links(stage: bpy.types.Scene) -> None:
    """A light that is linked anew makes another of its receivers, though nothing else was updated."""
    lamp, left = emitter("POINT"), bpy.data.objects["Left"]
    reader = SceneReader()
    read(reader, is_live=True)
    link(lamp, "receiver", left, state="EXCLUDE")
    bpy.context.view_layer.update()
    reader.note_updates(bpy.context.evaluated_depsgraph_get())
    found = read(reader, is_live=True)
    (group,) = placements(found, "Left")
    assert group.lighting is not None
    assert not found.lights[0].links.receiver_sets >> group.lighting.receiver_set & 1
