# SPDX-License-Identifier: GPL-3.0-or-later
"""A room that nobody here made: 201 objects, blinds, a spot outside, haze; its beams agree with Cycles'.

The scene lies beside the repository, in ../shared/data/blend; its README says what must be hidden. Compared is what the
haze scatters, pass against pass: surfaces come with the materials. Cycles is asked for single scattering, and lamps
alone light it; meshes that glow wait for their own issue, as do area lights.
"""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import numpy as np
import pytest

from support.cycles_reference import FloatArray, prepare_cycles, save_side_by_side
from support.exr import read_planes

REPOSITORY = Path(__file__).parents[2]
ROOM = "data/blend/engineer_room/bedroom.blend"
PICTURES = REPOSITORY / "out" / "engineer_room"
CYCLES_SAMPLES = int(os.environ.get("TYNDALL_ROOM_SAMPLES", "64"))
SIZE_PX = 480, 270
#: Of the mean of the picture, and of its root mean square per pixel. Cycles' pixels are points, too.
MEAN_BOUND, ERROR_BOUND = 0.005, 0.05

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
        if thing.type == "MESH":  # rays that leave the haze after the last bounce still end on what glows, and see it
            thing.visible_volume_scatter = False
    for material in bpy.data.materials:
        if hasattr(material, "cycles") and hasattr(material.cycles, "emission_sampling"):
            material.cycles.emission_sampling = "NONE"
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


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, FloatArray]:
    """Ours by both methods, and two of Cycles' with different seeds."""
    path = room_path()
    if path is None:
        pytest.skip(f"../shared/{ROOM} is not there")
    scene = open_room(path)
    layer = scene.view_layers[0]
    layer.cycles.use_pass_volume_direct = layer.tyndall.use_pass_shafts = True
    folder = tmp_path_factory.mktemp("room")
    found = {}
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples = 1
    scene.tyndall.shafts.light_samples = 64
    scene.tyndall.shafts.shares_strata = False
    for method in ("EPIPOLAR", "EXACT"):
        scene.tyndall.shafts.method = method
        found[method] = scattered(scene, folder, "Shafts")
    for seed in (1, 2):
        prepare_cycles(scene, CYCLES_SAMPLES, seed)
        name = "Volume Direct" if bpy.app.version >= (5, 0, 0) else "VolumeDir"
        found[f"Cycles {seed}"] = scattered(scene, folder, name)
    for name, picture in found.items():
        np.save(folder / f"{name}.npy", picture)
    return found


@pytest.mark.parametrize("method", ["EPIPOLAR", "EXACT"])
def test_beams_agree_with_cycles(pictures: dict[str, FloatArray], method: str) -> None:
    """The mean of (ours - A) (ours - B) over two seeds of Cycles is our squared error: their noises cancel."""
    ours, first, second = pictures[method], pictures["Cycles 1"], pictures["Cycles 2"]
    reference = (first + second) / 2
    save_side_by_side(PICTURES / f"{bpy.app.version_string} {method}.png", ours, reference)
    mean_error = ours.sum() / reference.sum() - 1
    error = np.sqrt(max(((ours - first) * (ours - second)).mean(), 0.0) / (first * second).mean())
    noise = np.sqrt(((first - second) ** 2).mean() / 4 / (first * second).mean())
    print(f"{method}: mean {mean_error:+.3%}, error {error:.2%}, Cycles' noise {noise:.2%}")
    assert abs(mean_error) < MEAN_BOUND
    assert error < ERROR_BOUND
