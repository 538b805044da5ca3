# SPDX-License-Identifier: GPL-3.0-or-later
"""A room that nobody here made: 201 objects, a window, a spot outside, haze; its beams agree with Cycles'.

The scene lies beside the repository, in ../shared/data/blend; its README says what must be hidden. Compared is what the
haze scatters, pass against pass: surfaces come with the materials. Cycles is asked for single scattering, and lamps
alone light it: meshes that glow and area lights have tests of their own.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
import pytest

from support.cycles_reference import FloatArray, prepare_cycles, save_side_by_side
from support.exr import read_planes

REPOSITORY = Path(__file__).parents[2]
ROOM = "data/blend/engineer_room/bedroom.blend"
PICTURES = REPOSITORY / "out" / "engineer_room"
SIZE_PX = 240, 135

pytestmark = pytest.mark.long


def room_path() -> Path | None:
    """Beside the repository, or beside the main work tree of a linked one."""
    roots = [REPOSITORY.parent / "shared", Path(os.environ.get("TYNDALL_SHARED", "/nowhere"))]
    return next((root / ROOM for root in roots if (root / ROOM).exists()), None)


def open_room(path: Path) -> bpy.types.Scene:
    """Haze in the world, as note 1 of the README says; no light but lamps."""
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    scene = bpy.context.scene
    bpy.data.objects["blocker"].hide_render = True
    for thing in bpy.data.objects:
        if thing.type == "LIGHT" and thing.data.type == "AREA":
            thing.hide_render = True
        if thing.type == "LIGHT":  # the same rays would see lamps through these walls, once they pass through them
            thing.data.cycles.use_multiple_importance_sampling = False
        if thing.type == "MESH":  # rays that leave the haze after the last bounce still end on what glows, and see it
            thing.visible_volume_scatter = False
    for material in bpy.data.materials:
        if hasattr(material.cycles, "emission_sampling"):
            material.cycles.emission_sampling = "NONE"
        else:
            material.cycles.sample_as_light = False
    tree = scene.world.node_tree
    haze = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeVolumePrincipled")
    haze.inputs["Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    haze.inputs["Emission Strength"].default_value, haze.inputs["Density"].default_value = 0.0, 0.03
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputWorld")
    tree.links.new(haze.outputs[0], output.inputs["Volume"])
    for link in [link for link in tree.links if link.to_socket == output.inputs["Surface"]]:
        tree.links.remove(link)
    render = scene.render
    render.resolution_x, render.resolution_y = SIZE_PX
    render.resolution_percentage, render.use_border = 100, False
    render.use_compositing = render.use_sequencer = False
    return scene


def scattered(scene: bpy.types.Scene, folder: Path, pass_name: str) -> FloatArray:
    """Render, and read what the haze scattered."""
    settings = scene.render
    settings.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.image_settings.color_depth, settings.image_settings.exr_codec = "32", "NONE"
    settings.filepath = str(folder / "frame.exr")
    bpy.ops.render.render(write_still=True, scene=scene.name)
    planes = read_planes(folder / "frame.exr")
    (plane,) = (plane for name, plane in planes.items() if name.endswith(f".{pass_name}"))
    return plane[..., :3].astype(np.float64)


@dataclass(frozen=True)
class Agreement:
    """Relative to Cycles' mean, and to its root mean square."""

    mean_error: float
    error: float
    noise: float  #: Of Cycles' mean of two.


def compare(scene: bpy.types.Scene, folder: Path, method: str, light_samples: int, cycles_samples: int) -> Agreement:
    """The mean of (ours - A) (ours - B) over two seeds of Cycles is our squared error: their noises cancel."""
    layer = scene.view_layers[0]
    layer.cycles.use_pass_volume_direct = layer.tyndall.use_pass_shafts = True
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples = 1
    shafts = scene.tyndall.shafts
    shafts.method, shafts.light_samples = method, light_samples
    shafts.shares_strata = shafts.adapts_strata = False
    ours = scattered(scene, folder, "Shafts")
    name = "Volume Direct" if bpy.app.version >= (5, 0, 0) else "VolumeDir"
    seeds = []
    for seed in (1, 2):
        prepare_cycles(scene, cycles_samples, seed)
        seeds.append(scattered(scene, folder, name))
    first, second = seeds
    reference, power = (first + second) / 2, (first * second).mean()
    save_side_by_side(PICTURES / f"{bpy.app.version_string} {method} {light_samples}.png", ours, reference)
    return Agreement(
        mean_error=float(ours.sum() / reference.sum() - 1),
        error=float(np.sqrt(max(((ours - first) * (ours - second)).mean(), 0.0) / power)),
        noise=float(np.sqrt(((first - second) ** 2).mean() / 4 / power)),
    )


@pytest.fixture
def room() -> bpy.types.Scene:
    path = room_path()
    if path is None:
        pytest.skip(f"../shared/{ROOM} is not there")
    return open_room(path)


@pytest.mark.parametrize("method", ["EPIPOLAR", "EXACT"])
def test_the_beam_through_the_window_is_that_of_cycles(room: bpy.types.Scene, tmp_path: Path, method: str) -> None:
    for thing in bpy.data.objects:
        if thing.type == "LIGHT" and thing.name != "Spot":
            thing.hide_render = True
    found = compare(room, tmp_path, method, light_samples=64, cycles_samples=192)
    print(found)
    assert abs(found.mean_error) < 0.003
    assert found.error < 0.015  # a few pixels on the window's frame


def test_all_lamps_are_those_of_cycles(room: bpy.types.Scene, tmp_path: Path) -> None:
    """Ten of them, of 0.25 m, reach into shelves and walls; all together the haze has Cycles' mean."""
    found = compare(room, tmp_path, "EPIPOLAR", light_samples=32, cycles_samples=96)
    print(found)
    assert abs(found.mean_error) < 0.004  # 32 strata leave 0.1 %, and Cycles' own mean is known to 0.1 %
