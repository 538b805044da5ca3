# SPDX-License-Identifier: GPL-3.0-or-later
"""Indirect light is that of Cycles, within its own noise: its AO pass, one bounce, and mirrors.

A corner of coloured walls with a white box in it, under a lamp, a sun or the world alone.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon import last_render
from support.cycles_reference import (
    Pair,
    agreement,
    cycles_pixels,
    pixels_on_edges,
    prepare_cycles,
    rendered_pixels,
    tyndall_pixels,
)
from support.exr import read_planes
from support.small_scenes import Build, add, cube, empty_scene, light, material, mesh, node, plane, read

RED, GREEN, WHITE = (0.8, 0.1, 0.05, 1), (0.1, 0.6, 0.15, 1), (0.8, 0.8, 0.8, 1)
SIZE_PX = 63
IS_4, IS_5 = (bpy.app.version >= (major, 0, 0) for major in (4, 5))
FloatArray = NDArray[np.float64]


def diffuse(name: str, colour: tuple[float, ...]) -> bpy.types.Material:
    return material(name, lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=colour).outputs[0])


def glowing(name: str, strength: float) -> bpy.types.Material:
    return material(
        name, lambda new, _: node(new, "ShaderNodeEmission", Color=(1, 0.8, 0.5, 1), Strength=strength).outputs[0]
    )


def wall(name: str, corners: list[tuple[float, ...]], made_of: bpy.types.Material) -> bpy.types.Object:
    return add(name, mesh(name, corners, [(0, 1, 2, 3)], made_of))


def corner(world: float = 0.0) -> bpy.types.Scene:
    """Floor, a red wall, a green wall, and a turned white box on the floor; seen from outside of the corner."""
    scene = empty_scene(SIZE_PX)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (world, world, 1.3 * world, 1)
    wall("Floor", [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], diffuse("White", WHITE))
    wall("Left", [(-2, -2, 0), (-2, 2, 0), (-2, 2, 3), (-2, -2, 3)], diffuse("Red", RED))
    wall("Back", [(-2, 2, 0), (2, 2, 0), (2, 2, 3), (-2, 2, 3)], diffuse("Green", GREEN))
    box = cube("Box", bpy.data.materials["White"])
    box.location, box.scale, box.rotation_euler = (-0.5, 0.5, 0.61), (0.6, 0.6, 0.6), (0, 0, 0.5)
    camera = scene.camera
    camera.data.type, camera.data.angle = "PERSP", 0.8
    camera.location, camera.rotation_euler = (4.5, -4.5, 3.5), (1.1, 0, 0.78)
    return scene


def lit(kind: str) -> bpy.types.Scene:
    scene = corner(world=0.4 if kind == "world" else 0.0)
    if kind == "sun":
        light("SUN", (0, 0, 5), energy=3.0, angle=0.05).rotation_euler = (0.5, 0.5, 0)
    elif kind == "lamp":
        light("POINT", (0.8, -0.8, 2.2), energy=150.0, shadow_soft_size=0.0)
    elif kind == "panel":
        wall("Panel", [(0, -1, 2.9), (0, 0.5, 2.9), (1.5, 0.5, 2.9), (1.5, -1, 2.9)], glowing("Panel", 4.0))
    return scene


def assert_agree(ours: Pair, cycles: Pair, left_out: NDArray[np.bool_]) -> None:
    found = agreement(ours, cycles, left_out)
    assert found.holds, str(found)
    assert found.noise < 0.03, "a comparison that sees nothing"


@pytest.mark.dealt
@pytest.mark.parametrize("kind", ["sun", "lamp", "world"])
def test_one_bounce_is_that_of_cycles(kind: str) -> None:
    """What lamps and world throw on surfaces, and what these throw on one another."""
    scene = lit(kind)
    left_out = pixels_on_edges(scene)
    without = tyndall_pixels(scene, ["EXACT"], surface_samples=64)[0]
    scene.tyndall.indirect.has_bounce = True
    ours = tuple(tyndall_pixels(scene, ["EXACT"], surface_samples=64, seed=seed)[0] for seed in (0, 1))
    assert ours[0].mean() > 1.05 * without.mean()
    cycles = tuple(cycles_pixels(scene, seed=seed, diffuse_bounces=1) for seed in (1, 2))
    assert_agree(ours, cycles, left_out)


@pytest.mark.dealt
def test_a_bounce_meets_what_shines_through() -> None:
    """A sheet of paper between the lamp and the floor, which is lit by it alone; once it was black from behind."""
    scene = lit("lamp")
    paper = material("Paper", lambda new, _: node(new, "ShaderNodeBsdfTranslucent", Color=WHITE).outputs[0])
    wall("Sheet", [(0.0, -1.8, 1.5), (1.8, -1.8, 1.5), (1.8, 0.0, 1.7), (0.0, 0.0, 1.7)], paper).visible_camera = False
    left_out = pixels_on_edges(scene)
    scene.tyndall.indirect.has_bounce = True
    ours = tuple(tyndall_pixels(scene, ["EXACT"], surface_samples=128, seed=seed)[0] for seed in (0, 1))
    cycles = tuple(cycles_pixels(scene, seed=seed, diffuse_bounces=1) for seed in (1, 2))
    assert_agree(ours, cycles, left_out)


@pytest.mark.dealt
@pytest.mark.skipif(not IS_4, reason="in 3.4 a few blocks differ beyond noise, the mean by 0.07 %: not explained yet")
@pytest.mark.parametrize("bounces", [0, 1])
def test_a_glowing_panel_lights_surfaces_as_in_cycles(bounces: int) -> None:
    """Straight, as a light does; a bounce adds what other surfaces throw, and not the panel once more."""
    scene = lit("panel")
    left_out = pixels_on_edges(scene)
    scene.tyndall.indirect.has_bounce = bounces > 0
    ours = tuple(tyndall_pixels(scene, ["EXACT"], surface_samples=64, seed=seed)[0] for seed in (0, 1))
    cycles = tuple(cycles_pixels(scene, seed=seed, diffuse_bounces=bounces) for seed in (1, 2))
    assert_agree(ours, cycles, left_out)


def glossy(colour: tuple[float, ...], roughness: float = 0.0) -> Build:
    return lambda new, _: node(new, "ShaderNodeBsdfGlossy", Color=colour, Roughness=roughness).outputs[0]


def principled(colour: tuple[float, ...], **inputs: object) -> Build:
    return lambda new, _: node(
        new, "ShaderNodeBsdfPrincipled", Base_Color=colour, **{"Roughness": 0.0, **inputs}
    ).outputs[0]


def half_mirror(new: object, link: object) -> bpy.types.NodeSocket:
    mix = new("ShaderNodeMixShader")
    mix.inputs[0].default_value = 0.5
    link(node(new, "ShaderNodeBsdfGlossy", Color=(0.9, 0.7, 0.3, 1), Roughness=0.0).outputs[0], mix.inputs[1])
    link(node(new, "ShaderNodeBsdfDiffuse", Color=(0.2, 0.4, 0.8, 1)).outputs[0], mix.inputs[2])
    return mix.outputs[0]


MIRRORS: dict[str, Build] = {
    "glossy": glossy((0.9, 0.8, 0.6, 1)),
    "metal": principled((0.9, 0.6, 0.2, 1), Metallic=1.0),
    # Up to 3.x the diffuse part of Principled is not Lambert's, as which it is drawn: there it is black.
    "polished": principled((0.1, 0.2, 0.4, 1) if IS_4 else (0, 0, 0, 1)),
    "mixed": half_mirror,
}
if IS_4:
    MIRRORS["half metal"] = principled((0.6, 0.5, 0.3, 1), Metallic=0.5)
    MIRRORS["tinted"] = principled((0.1, 0.2, 0.4, 1), IOR=2.5, Specular_Tint=(1, 0.5, 0.3, 1))


def bumped(new: object, link: object) -> bpy.types.NodeSocket:
    """Bent by a normal map of one colour, as is what a missing image makes of a surface."""
    bent = node(new, "ShaderNodeNormalMap", Color=(0.8, 0.35, 0.9, 1))
    bent.space = "WORLD"
    diffuse = node(new, "ShaderNodeBsdfDiffuse", Color=WHITE)
    link(bent.outputs[0], diffuse.inputs["Normal"])
    return diffuse.outputs[0]


GLOSSES: dict[str, Build] = {
    "glossy": glossy((0.9, 0.8, 0.6, 1), roughness=0.4),
    # At a flat angle most of what it sends back is gloss.
    "dark": principled((0.03, 0.03, 0.03, 1) if IS_4 else (0, 0, 0, 1), Roughness=0.35),
    "metal": principled((0.9, 0.6, 0.2, 1), Metallic=1.0, Roughness=0.45),
    "matte": lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=WHITE, Roughness=1.0).outputs[0],
    "bumped": bumped,
}


@pytest.mark.dealt
@pytest.mark.parametrize("name", GLOSSES)
def test_gloss_catches_a_bounce_from_where_it_shines(name: str) -> None:
    """As in Cycles with one bounce, diffuse or glossy; once it was caught from all around, as if gloss were diffuse."""
    scene = lit("lamp")
    for thing in ("Floor", "Box"):
        bpy.data.objects[thing].data.materials[0] = material(name, GLOSSES[name])
    scene.camera.location, scene.camera.rotation_euler = (4.5, -4.5, 1.5), (1.38, 0, 0.78)
    scene.tyndall.indirect.has_bounce = True
    left_out = pixels_on_edges(scene)
    ours = tuple(tyndall_pixels(scene, ["EXACT"], surface_samples=128, seed=seed)[0] for seed in (0, 1))
    cycles = []
    for seed in (1, 2):
        prepare_cycles(scene, 256, seed, diffuse_bounces=1, glossy_bounces=1)
        scene.cycles.max_bounces, scene.cycles.caustics_reflective = 1, True
        cycles.append(rendered_pixels(scene))
    assert_agree(ours, (cycles[0], cycles[1]), left_out)


@pytest.mark.dealt
@pytest.mark.parametrize("name", MIRRORS)
def test_mirrors_show_what_they_show_in_cycles(name: str) -> None:
    """A wall, a floor and a box that mirror one another once, with the shares that the version's shaders give them."""
    scene = lit("world")
    light("POINT", (0.8, -0.8, 2.2), energy=100.0, shadow_soft_size=0.0)
    for thing in ("Back", "Box"):
        bpy.data.objects[thing].data.materials[0] = material(name, MIRRORS[name])
    scene.tyndall.indirect.has_mirrors, scene.tyndall.indirect.mirror_depth = True, 1
    left_out = pixels_on_edges(scene)
    ours = tuple(tyndall_pixels(scene, ["EXACT"], surface_samples=64, seed=seed)[0] for seed in (0, 1))
    assert not last_render.statistics_of(scene.name)["reports"]
    cycles = tuple(cycles_pixels(scene, seed=seed, glossy_bounces=1) for seed in (1, 2))
    assert_agree(ours, cycles, left_out)


@pytest.mark.skipif(not IS_4, reason="up to 3.x no setting makes such an index")
def test_a_layer_of_a_large_index_mirrors_no_less_at_an_angle() -> None:
    """As in Cycles, whose layers only rise: a dielectric of index 20 itself has 82 % straight on, here 66 %."""
    scene = empty_scene(16)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    plane(0.0, material("Layer", principled((0, 0, 0, 1), IOR=20.0)), half_side=50.0)
    scene.camera.data.type, scene.camera.data.angle = "PERSP", 0.05
    scene.camera.location, scene.camera.rotation_euler = (0, -10, 2), (1.37, 0, 0)
    scene.tyndall.indirect.has_mirrors, scene.tyndall.indirect.mirror_depth = True, 1
    ours = tyndall_pixels(scene, ["EXACT"])[0]
    assert ours == pytest.approx(cycles_pixels(scene, 16, glossy_bounces=1), rel=1e-3)


def test_a_tint_that_mirrors_leave_out_is_named() -> None:
    """That of a layer beside metal, and up to 3.x any."""
    scene = lit("lamp")
    tint = {"Specular_Tint": (1, 0.5, 0.5, 1), "Metallic": 0.5} if IS_4 else {"Specular_Tint": 0.5}
    bpy.data.objects["Box"].data.materials[0] = material("Tinted", principled(WHITE, **tint))
    for is_mirror in (False, True):
        scene.tyndall.indirect.has_mirrors = is_mirror
        assert any("the tint of specular" in line for line in read().reports) == is_mirror


@pytest.mark.dealt
def test_mirrors_show_each_other_and_what_a_bounce_lights() -> None:
    """Two mirrors face each other; between them colours bleed."""
    scene = lit("lamp")
    for thing in ("Back", "Left"):
        bpy.data.objects[thing].data.materials[0] = material(thing, glossy((0.9, 0.8, 0.7, 1)))
    bpy.data.objects["Box"].data.materials[0] = bpy.data.materials["Red"]
    indirect = scene.tyndall.indirect
    indirect.has_mirrors, indirect.mirror_depth, indirect.has_bounce = True, 2, True
    left_out = pixels_on_edges(scene)
    ours = tuple(tyndall_pixels(scene, ["EXACT"], surface_samples=64, seed=seed)[0] for seed in (0, 1))
    cycles = tuple(cycles_pixels(scene, seed=seed, diffuse_bounces=1, glossy_bounces=2) for seed in (1, 2))
    assert_agree(ours, cycles, left_out)


@pytest.mark.dealt
def test_without_mirrors_gloss_shows_lamps_and_the_world_alone() -> None:
    """As Cycles' does without bounces; where it is rough, asked for mirrors or not."""
    scene = lit("lamp")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.5, 1)
    wall = bpy.data.objects["Back"].data
    left_out = pixels_on_edges(scene)
    for roughness in (0.0, 0.3):
        wall.materials[0] = material("Gloss", glossy(GREEN, roughness))
        ours = tuple(tyndall_pixels(scene, ["EXACT"], surface_samples=64, seed=seed)[0] for seed in (0, 1))
        found = agreement(ours, tuple(cycles_pixels(scene, seed=seed) for seed in (1, 2)), left_out)
        # Edges that are mirrored sharply are pixels' edges, too: some blocks have them.
        assert abs(found.mean_error) < 1e-3, str(found)
        assert found.median_error < 1e-3, str(found)
        assert roughness == 0.0 or found.holds, str(found)
        reports = last_render.statistics_of(scene.name)["reports"]
        assert any("as sharp as a mirror" in line for line in reports) == (roughness == 0.0)
    scene.tyndall.indirect.has_mirrors = True
    assert tyndall_pixels(scene, ["EXACT"], surface_samples=64)[0] == pytest.approx(ours[0], abs=1e-6)
    scene.tyndall.indirect.mirror_roughness = 0.3
    assert tyndall_pixels(scene, ["EXACT"])[0] != pytest.approx(ours[0], abs=1e-3)


def ambient_pass(scene: bpy.types.Scene) -> FloatArray:
    """The pass as it arrives in a file, from the engine that the scene has."""
    scene.view_layers[0].use_pass_ambient_occlusion = True
    settings = scene.render.image_settings
    if IS_5:
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        planes = {name.partition(".")[2]: plane for name, plane in read_planes(Path(scene.render.filepath)).items()}
    if IS_5:
        settings.media_type = "IMAGE"
    return planes["Ambient Occlusion" if IS_5 else "AO"][..., :3].astype(np.float64)


# Seen to fail: with a distance of our own, which the world's was not asked for.
@pytest.mark.dealt
@pytest.mark.parametrize("distance_m", [1e4, 0.8])
def test_the_ambient_occlusion_pass_is_that_of_cycles(distance_m: float) -> None:
    """Its distance is the world's."""
    scene = lit("world")
    left_out = pixels_on_edges(scene)
    scene.world.light_settings.distance = distance_m
    scene.tyndall.indirect.ambient_samples = 16
    ours, cycles = [], []
    for seed in (1, 2):
        scene.render.engine = "TYNDALL"
        scene.tyndall.pixel_samples, scene.tyndall.seed, scene.tyndall.noise_threshold = 16, seed, 0.0
        scene.tyndall.pixel_filter, scene.tyndall.filter_width_px = "BOX", 0.01
        ours.append(ambient_pass(scene))
        prepare_cycles(scene, 256, seed)
        cycles.append(ambient_pass(scene))
    assert ours[0][~left_out].min() < 0.6 < ours[0].max()
    assert_agree(tuple(ours), tuple(cycles), left_out)


def test_nothing_stands_within_no_distance() -> None:
    """As in Cycles, where the world's distance is 0."""
    scene = lit("world")
    scene.world.light_settings.distance = 0.0
    scene.render.engine = "TYNDALL"
    assert ambient_pass(scene)[24:60, 24:36].min() == 1.0  # surfaces alone


def test_with_ambient_occlusion_the_world_lights_surfaces_as_the_pass_says() -> None:
    """Combined is colour times radiance times pass, as Cycles' passes would be put together."""
    scene = lit("world")
    left_out = pixels_on_edges(scene)
    indirect = scene.tyndall.indirect
    indirect.has_ambient_occlusion, indirect.ambient_distance_m = True, 0.8
    picture = tyndall_pixels(scene, ["EXACT"], surface_samples=256)[0]
    scene.tyndall.pixel_samples = 64
    share = ambient_pass(scene)
    radiance = np.array([0.4, 0.4, 0.52])
    expected = np.stack([share * np.array(colour[:3]) * radiance for colour in (WHITE, RED, GREEN)])
    error = np.abs(picture - expected).max(axis=-1).min(axis=0)[~left_out & (share[..., 0] > 0)]
    assert np.median(error) < 0.005
    assert np.quantile(error, 0.95) < 0.02
