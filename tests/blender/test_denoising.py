# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising data: the passes are Cycles', and the compositor's node takes noise away with them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import denoising
from addon.over_engine.compositor import tree_of
from support.exr import read_planes
from support.pass_pictures import render_passes
from support.small_scenes import Node, cube, empty_scene, light, material, node, plane

FEATURES = ("Denoising Albedo", "Denoising Normal", "Denoising Depth")
GLOSSY = "ShaderNodeBsdfAnisotropic" if bpy.app.version >= (4, 0, 0) else "ShaderNodeBsdfGlossy"


def diffuse(name: str, color: tuple[float, ...]) -> bpy.types.Material:
    return material(name, surface=lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=color).outputs[0])


def glossy(name: str, color: tuple[float, ...], roughness: float) -> bpy.types.Material:
    return material(name, surface=lambda new, _: node(new, GLOSSY, Color=color, Roughness=roughness).outputs[0])


def pane(cover: float) -> bpy.types.Material:
    def surface(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        mix = node(new, "ShaderNodeMixShader", Fac=cover)
        link(node(new, "ShaderNodeBsdfTransparent", Color=(0.6, 0.9, 0.6, 1)).outputs[0], mix.inputs[1])
        link(node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.2, 0.2, 1)).outputs[0], mix.inputs[2])
        return mix.outputs[0]

    return material(f"Pane {cover}", surface=surface)


@pytest.fixture
def stage() -> bpy.types.Scene:
    """A floor, rough gloss, a mirror, panes that cover nothing and 0.6, something that glows, and a blue world."""
    scene = empty_scene(48)
    scene.camera.location, scene.camera.rotation_euler = (0.3, -8, 6), (0.9, 0.1, 0.05)
    scene.camera.data.type = "PERSP"
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.5, 1)
    plane(material=diffuse("Floor", (0.5, 0.4, 0.3, 1)), half_side=2.5)
    place(cube("Gloss", glossy("Gloss", (0.9, 0.6, 0.2, 1), 0.5)), (-1.5, 0, 0.7))
    place(cube("Mirror", glossy("Mirror", (0.8, 0.7, 0.9, 1), 0.0)), (0.2, 0.6, 0.7))
    place(cube("Thin", pane(0.0)), (1.6, -1, 0.7))
    place(cube("Thick", pane(0.6)), (1.6, 1, 0.7))
    glow = material("Glow", surface=lambda new, _: node(new, "ShaderNodeEmission", Color=(0.1, 0.6, 0.2, 1)).outputs[0])
    place(cube("Glow", glow), (-1.5, 1.7, 0.7))
    light("SUN", (0, 0, 5), energy=3.0)
    scene.view_layers[0].tyndall.use_pass_denoising_data = True
    scene.view_layers[0].cycles.denoising_store_passes = True
    # Paths that Cycles ends by chance have no features, and those that go on have no more for it.
    scene.cycles.min_light_bounces = scene.cycles.min_transparent_bounces = 8
    return scene


def place(thing: bpy.types.Object, location: tuple[float, ...]) -> None:
    thing.location, thing.scale = location, (0.5, 0.5, 0.5)


def test_features_are_those_of_cycles(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """Albedo, normal in the camera's space and depth, through what is sharp and where edges are antialiased."""
    stage.tyndall.indirect.has_mirrors = True
    ours = render_passes(stage, tmp_path, "TYNDALL", 64).planes
    theirs = render_passes(stage, tmp_path, "CYCLES", 128, bounces=2).planes
    assert ours["Denoising Albedo"].min() >= 0.0
    assert ours["Denoising Albedo"].max() <= 1.0
    for name, largest_median, largest in (
        ("Denoising Albedo", 0.002, 0.04),  # in the mirror Cycles dims the world twice
        ("Denoising Normal", 0.002, 0.02),
        ("Denoising Depth", 0.005, 0.12),
    ):
        blocks = np.abs((ours[name] - theirs[name]).reshape(12, 4, 12, 4, -1).mean((1, 3)))
        assert theirs[name].std() > 0.1, "an empty pass would prove nothing"
        assert np.median(blocks) < largest_median
        assert np.quantile(blocks, 0.95) < 10 * largest_median
        assert blocks.max() < largest


def test_a_mirror_shows_the_features_of_what_it_mirrors(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """With its tint; a mirror that is not followed shows its own."""
    mirror = stage.objects["Mirror"]
    for thing in stage.objects:
        if thing.type == "MESH" and thing != mirror:
            thing.hide_render = True
    mirror.scale, mirror.location = (9, 9, 0.01), (0, 0, 0)
    world, tint = np.array([0.1, 0.2, 0.5]), np.array([0.8, 0.7, 0.9])
    own = render_passes(stage, tmp_path, "TYNDALL", 4).planes["Denoising Albedo"][20:28, 20:28]
    assert np.abs(own - tint).max() < 0.02
    stage.tyndall.indirect.has_mirrors = True
    followed = render_passes(stage, tmp_path, "TYNDALL", 4, seed=1).planes["Denoising Albedo"][20:28, 20:28]
    assert np.abs(followed - world * tint).max() < 0.01


def test_passes_that_nobody_asks_for_change_nothing(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """The picture's bits are the same with them and without."""
    with_features = render_passes(stage, tmp_path, "TYNDALL", 4).planes["Combined"]
    stage.view_layers[0].tyndall.use_pass_denoising_data = False
    without = render_passes(stage, tmp_path, "TYNDALL", 4, seed=0).planes
    assert "Denoising Albedo" not in without
    assert np.array_equal(with_features, without["Combined"])


needs_denoiser = pytest.mark.skipif(not denoising.is_built_in(), reason="this Blender has no OpenImageDenoise")


@pytest.mark.skipif(denoising.is_built_in(), reason="of a Blender without OpenImageDenoise")
def test_a_blender_without_a_denoiser_says_so(scene: bpy.types.Scene) -> None:
    """The button is grey, and tells why."""
    assert "without OpenImageDenoise" in denoising.why_not(scene)
    assert not bpy.ops.tyndall.denoising_set_up.poll()


@needs_denoiser
def test_the_button_puts_the_node_in_and_takes_it_out(scene: bpy.types.Scene) -> None:
    """Twice pressed is once; what the picture went to is fed by the node, and by the picture again in the end."""
    for _ in range(2):
        assert bpy.ops.tyndall.denoising_set_up() == {"FINISHED"}
    tree = tree_of(scene)
    (made,) = denoising.nodes_of(scene)
    assert scene.view_layers[0].tyndall.use_pass_denoising_data
    sources = {name: made.inputs[name].links[0].from_socket.name for name in ("Image", "Normal", "Albedo")}
    assert sources == {"Image": "Image", "Normal": "Denoising Normal", "Albedo": "Denoising Albedo"}
    layer = made.inputs["Image"].links[0].from_node
    (end,) = [link.to_node for link in made.outputs["Image"].links]
    assert bpy.ops.tyndall.denoising_remove() == {"FINISHED"}
    assert not denoising.nodes_of(scene)
    assert [link.to_node for link in layer.outputs["Image"].links] == [end]
    assert end.name in tree.nodes


@pytest.mark.dealt
@needs_denoiser
def test_a_denoised_picture_is_nearer_to_the_converged_one(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """Under a lamp as large as the room, at 2 samples: less than two thirds of the error are left, edges included.

    Seen to leave half.
    """
    stage.render.resolution_x = stage.render.resolution_y = 96
    stage.objects["Sun"].data.energy = 0.0
    lamp = light("AREA", (2, -2, 4), energy=400.0)
    lamp.data.size = 5.0
    stage.tyndall.noise_threshold = 0.0
    settings = stage.render.image_settings
    settings.file_format, settings.color_mode = "OPEN_EXR", "RGBA"
    settings.color_depth, settings.exr_codec = "32", "NONE"
    stage.render.filepath = str(tmp_path / "frame.exr")

    def picture(samples: int, seed: int = 0) -> np.ndarray:
        stage.tyndall.pixel_samples, stage.tyndall.seed = samples, seed
        bpy.ops.render.render(write_still=True)
        return read_planes(Path(stage.render.filepath))[""][..., :3]

    converged = picture(128)
    noisy = picture(2, seed=1)
    denoising.set_up(stage)
    denoised = picture(2, seed=1)
    error, left = (float(np.sqrt(np.mean((found - converged) ** 2))) for found in (noisy, denoised))
    assert left < 0.65 * error
