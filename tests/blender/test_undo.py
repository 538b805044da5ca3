# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-Z takes back whatever a tool did, whole, and Ctrl-Shift-Z brings it back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import pytest

from addon import denoising, painted_air
from addon.operators import CLASSES
from addon.panels.presets import TYNDALL_PT_air_presets, shipped_presets
from support.file_state import file_state
from support.small_scenes import cube, empty_scene, light, material, node, plane
from tyndall.voxel_dag import Config, from_coordinates

OPERATORS = [cls for cls in CLASSES if issubclass(cls, bpy.types.Operator)]
#: They are no step of undo, because:
NOT_UNDONE = {
    "tyndall.copy_reports": "the clipboard is not the file",
    "tyndall.show_light_depth": "its images show the light's state, and are made anew by the next click",
    "tyndall.paint_air": "each of its strokes is a step, as those of Blender's brushes are",
    "tyndall.export_voxels_vdb": "it writes a file, and changes nothing here",
    "tyndall.export_voxels_vox": "it writes a file, and changes nothing here",
    "tyndall.render_preset_add": "a preset is a file of the user",
    "tyndall.air_preset_add": "a preset is a file of the user",
}


@pytest.fixture
def workshop() -> bpy.types.Object:
    """A scene in which every tool has something to work on; gives its sun, which is active."""
    scene = empty_scene(size_px=16)
    painted_air.forget()
    scene.camera.data.type, scene.camera.location = "PERSP", (0.0, 0.0, 6.0)
    plane(half_side=4.0)
    fog = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.05).outputs["Volume"])
    box = cube("Fog", fog)
    box.location, box.scale = (0.0, 0.0, 0.5), (4.0, 4.0, 0.5)
    tools = bpy.ops.tyndall

    tools.add_painted_box(voxels=8)
    brush = scene.tyndall.air_brush
    brush.volume, brush.intensity, brush.opacity, brush.radius_m = "INTENSITY", 0.25, 1.0, 1.0
    tools.paint_air_stroke(dabs=[{"name": "", "location": (-2.0, 0.0, 0.5), "pressure": 1.0}])
    air = scene.tyndall.heterogeneity
    air.wind_m_per_s, air.scale_m = (1.0, 0.0, 0.0), 2.0
    air.keyframe_insert("amount", frame=5)

    sun = light("SUN", (0.0, 0.0, 5.0))
    bpy.context.view_layer.objects.active = sun
    for kind in ("CLOSE", "HOLES"):
        tools.occluder_edit_add(kind=kind)
    sun.data.tyndall.occluder_edits[1].keyframe_insert("size_m", frame=1)

    tools.transfer_function_new()
    for kind in ("SOLID", "GRADIENT", "DIFFUSION"):
        tools.transfer_layer_add(kind=kind)
    for _ in range(2):
        tools.transfer_constraint_add()
    tools.transfer_state_key()

    tools.fit_view_add()
    fit = sun.data.tyndall.light_map_fit
    fit.resolution, fit.views[0].camera = 16, scene.camera
    fit.views[0].strokes = strokes = bpy.data.images.new("Strokes", 16, 16, alpha=True, float_buffer=True)
    strokes.pixels.foreach_set([1.0, 0.0, 0.0, 1.0] * 256)
    strokes.pack()  # or undo forgets them, as it does all that a script fills an image with
    # A click on Paint Strokes renders what lies behind them.
    scene.tyndall.pixel_samples = scene.tyndall.shafts.light_samples = 1
    scene.tyndall.shafts.resolution = 64
    return sun


def key_of_amount(_sun: bpy.types.Object, _folder: Path) -> dict[str, Any]:
    return {"identifier": "bpy.data.scenes['Scene'].tyndall.heterogeneity.amount"}


def fitted(sun: bpy.types.Object, _folder: Path) -> None:
    """Not to its end: to go on changes the map."""
    sun.data.tyndall.light_map_fit.steps = 2
    bpy.ops.tyndall.fit_light_map()


def under_a_bright_image(_sun: bpy.types.Object, _folder: Path) -> None:
    tree = bpy.context.scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.new("Sky", 64, 32, float_buffer=True)
    pixels = [0.1, 0.1, 0.1, 1.0] * (64 * 32)
    first = 4 * (64 * 24 + 10)
    pixels[first : first + 3] = [1000.0] * 3
    texture.image.pixels.foreach_set(pixels)
    texture.image.pack()
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def under_cycles(_sun: bpy.types.Object, _folder: Path) -> None:
    bpy.context.scene.render.engine = "CYCLES"


def over_cycles(sun: bpy.types.Object, folder: Path) -> None:
    under_cycles(sun, folder)
    bpy.ops.tyndall.over_engine_set_up()


def where_there_is_a_denoiser(*_: object) -> None:
    if not denoising.is_built_in():
        pytest.skip("this Blender has no OpenImageDenoise: the button is grey")


def denoised(*_: object) -> None:
    where_there_is_a_denoiser()
    bpy.ops.tyndall.denoising_set_up()


def into_file(_sun: bpy.types.Object, folder: Path) -> dict[str, Any]:
    return {"filepath": str(folder / "air.vdb"), "voxels": 8}


def out_of_file(_sun: bpy.types.Object, folder: Path) -> dict[str, Any]:
    path = str(folder / "air.vdb")
    bpy.ops.tyndall.bake_air(filepath=path, voxels=8, shows=False)
    bpy.ops.tyndall.painted_air_clear()
    return {"filepath": path}


def selected(_sun: bpy.types.Object, folder: Path) -> None:
    box = bpy.data.objects["Fog"]
    box.data.materials.clear()  # fog has no surface that could become voxels
    box.select_set(True)
    settings = bpy.context.scene.tyndall.voxelize
    settings.resolution, settings.path = "4", str(folder / "fog.tdag")


def tdag_file(_sun: bpy.types.Object, folder: Path) -> dict[str, Any]:
    path = folder / "corner.tdag"
    from_coordinates([[0, 0, 0]], Config(resolution=4)).save(path)
    return {"filepath": str(path)}


def vox_file(_sun: bpy.types.Object, folder: Path) -> dict[str, Any]:
    path = folder / "corner.vox"
    from_coordinates([[0, 0, 0]], Config(resolution=4)).to_vox(path)
    return {"filepath": str(path)}


def voxel_box(sun: bpy.types.Object, folder: Path) -> None:
    bpy.ops.tyndall.import_tdag(**tdag_file(sun, folder))


def another_file(sun: bpy.types.Object, folder: Path) -> None:
    """Where one was imported: its cube is larger."""
    settings = tdag_file(sun, folder)
    bpy.ops.tyndall.import_tdag(**settings)
    from_coordinates([[0, 0, 0]], Config(resolution=8)).save(settings["filepath"])


def without_strokes(sun: bpy.types.Object, _folder: Path) -> None:
    sun.data.tyndall.light_map_fit.views[0].strokes = None


def at_another_frame(_sun: bpy.types.Object, _folder: Path) -> None:
    bpy.context.scene.frame_set(3)


#: Of those that need them: what is done before, and the settings, which are returned.
SETTINGS: dict[str, Callable[[bpy.types.Object, Path], dict[str, Any] | None]] = {
    "tyndall.toggle_key": key_of_amount,
    "tyndall.select_medium": lambda *_: {"material_name": "Fog"},
    "tyndall.occluder_edit_add": lambda *_: {"kind": "SILHOUETTE"},
    "tyndall.occluder_edit_move": lambda *_: {"direction": "UP"},
    "tyndall.transfer_function_preset": lambda *_: {"preset": "EMBER"},
    "tyndall.transfer_layer_add": lambda *_: {"kind": "IMAGE"},
    "tyndall.transfer_layer_move": lambda *_: {"direction": "DOWN"},
    "tyndall.transfer_state_key": at_another_frame,
    "tyndall.pick_constraint": lambda *_: {"place": (0.5, 0.5)},
    "tyndall.continue_light_map": fitted,
    "tyndall.paint_strokes": without_strokes,
    "tyndall.sun_from_world": under_a_bright_image,
    "tyndall.over_engine_set_up": under_cycles,
    "tyndall.over_engine_remove": over_cycles,
    "tyndall.leave_fog": over_cycles,
    "tyndall.denoising_set_up": where_there_is_a_denoiser,
    "tyndall.denoising_remove": denoised,
    "tyndall.paint_air_stroke": lambda *_: {"dabs": [{"name": "", "location": (2.0, 0.0, 0.5), "pressure": 1.0}]},
    "tyndall.painted_air_resample": lambda *_: {"resolution": (4, 4, 2)},
    "tyndall.bake_air": into_file,
    "tyndall.load_painted_air": out_of_file,
    "tyndall.voxelize": selected,
    "tyndall.import_tdag": tdag_file,
    "tyndall.import_vox": vox_file,
    "tyndall.reload_voxels": another_file,
    "tyndall.voxels_to_mesh": voxel_box,
    "tyndall.preset_apply": lambda *_: {"filepath": str(shipped_presets(TYNDALL_PT_air_presets)[0])},
}


def test_every_tool_is_a_step_of_undo_or_says_why_not() -> None:
    assert {cls.bl_idname for cls in OPERATORS if "UNDO" not in cls.bl_options} == set(NOT_UNDONE)


@pytest.mark.parametrize("name", sorted({cls.bl_idname for cls in OPERATORS} - set(NOT_UNDONE)))
def test_a_tool_is_undone_and_redone(workshop: bpy.types.Object, tmp_path: Path, name: str) -> None:
    """Settings, lists, keys, nodes, paint, objects, selection and frame are what they were, and what they became."""
    settings = SETTINGS[name](workshop, tmp_path) if name in SETTINGS else None
    bpy.context.preferences.edit.use_global_undo = True
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="before")
    before = file_state()
    assert getattr(bpy.ops.tyndall, name.partition(".")[2])(**(settings or {})) == {"FINISHED"}
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message=name)
    after = file_state()
    assert after != before
    bpy.ops.ed.undo()
    assert file_state() == before
    bpy.ops.ed.redo()
    assert file_state() == after
