# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air: what is set, keyed, driven and painted is what is sent, and what pictures show of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon.animation_paths import curves_at
from addon.engine.settings import frame_window, render_config
from addon.engine.viewport_worker import View, coarser
from addon.painted_air import write_volume
from addon.panels.presets import TYNDALL_PT_air_presets, shipped_presets
from addon.properties.heterogeneity import UPSAMPLINGS, TyndallHeterogeneity, may_be_painted
from addon.sync.cameras import read_camera
from addon.sync.reports import Reports
from support.beam_scene import build_beam_scene
from support.engine_pictures import tyndall_pixels
from support.new_file import new_file
from support.small_scenes import add
from support.textured_air import at, key_wind, read, sent, textured_air
from tyndall.heterogeneity import AirNoise, Heterogeneity

pytestmark = pytest.mark.dealt

PRESETS = shipped_presets(TYNDALL_PT_air_presets)


@pytest.fixture
def air() -> TyndallHeterogeneity:
    """The texture of a scene at 24 frames a second, switched on."""
    return textured_air()


def test_the_air_is_even_until_it_is_switched_on(air: TyndallHeterogeneity) -> None:
    """Whatever is set, nothing is sent: a scene without texture costs nothing."""
    air.amount, air.scale_m = 1.0, 3.0
    air.is_enabled = False
    assert read() == (None, ())
    scene = bpy.context.scene
    config = render_config(scene, bpy.context.view_layer, frame_window(scene.render, (8, 8)))
    assert config.heterogeneity is None


def test_every_setting_arrives(air: TyndallHeterogeneity) -> None:
    """Under the names of the description; the offset is where the noise has been moved to."""
    air.amount, air.level, air.intensity = 0.5, 1.5, 2.0
    air.scale_m, air.octaves, air.persistence, air.contrast, air.seed = 4.0, 3, 0.25, 2.0, 7
    air.weighting, air.step_count, air.upsampling = "WHOLE_RAY", 32, "8"
    air.offset_m = (1.0, -2.0, 0.5)
    assert sent() == Heterogeneity(
        noise=AirNoise(scale_m=4.0, octaves=3, persistence=0.25, contrast=2.0, seed=7),
        moved_m=(1.0, -2.0, 0.5),
        amount=0.5,
        level=1.5,
        intensity=2.0,
        weighting="WHOLE_RAY",
        step_count=32,
        upsampling=8,
    )


def test_a_viewport_looks_at_the_air_more_coarsely(air: TyndallHeterogeneity) -> None:
    """As coarsely as it is told; its first pictures, whose pixels are large themselves, share no more than that."""
    assert [int(identifier) for identifier, *_ in UPSAMPLINGS] == [1, 2, 4, 8, 16]
    air.upsampling, air.viewport_upsampling = "2", "16"
    final, viewport = sent(), read(is_viewport=True)[0]
    assert (final.upsampling, viewport.upsampling) == (2, 16)
    scene = bpy.context.scene
    depsgraph = bpy.context.evaluated_depsgraph_get()
    config = render_config(scene, bpy.context.view_layer, frame_window(scene.render, (64, 64)), (), viewport)
    view = View(camera=read_camera(scene.camera, depsgraph.scene_eval.render, (64, 64), Reports()), config=config)
    assert [coarser(view, scale).config.heterogeneity.upsampling for scale in (2, 4, 8)] == [8, 4, 2]
    even = View(camera=view.camera, config=replace(config, heterogeneity=None))
    assert coarser(even, 8).config.heterogeneity is None


@pytest.mark.parametrize("name", ["amount", "level", "intensity", "scale_m", "persistence", "contrast"])
def test_a_key_gives_its_value_exactly(air: TyndallHeterogeneity, name: str) -> None:
    """At its frame, and nowhere beside it something else."""
    scene = bpy.context.scene
    path = f"tyndall.heterogeneity.{name}"
    values = {1: 0.25, 11: 0.75, 21: 0.5}
    for frame, value in values.items():
        setattr(air, name, value)
        scene.keyframe_insert(path, frame=frame)
    for frame, value in values.items():
        heterogeneity = at(frame)
        assert getattr(heterogeneity.noise if hasattr(heterogeneity.noise, name) else heterogeneity, name) == value
    assert curves_at(scene, path)


def test_a_driver_is_followed(air: TyndallHeterogeneity) -> None:
    """As of any property of Blender."""
    bpy.context.scene.driver_add("tyndall.heterogeneity.amount").driver.expression = "frame / 100"
    assert at(25).amount == pytest.approx(0.25)
    assert at(50).amount == pytest.approx(0.5)


@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.stem)
def test_each_preset_is_a_texture_of_its_own(air: TyndallHeterogeneity, preset: Path) -> None:
    """It switches the texture on, brings a wind, keeps what is the scene's own, and is undone."""
    air.is_enabled, air.seed, air.step_count = False, 5, 32
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.tyndall.preset_apply(filepath=str(preset)) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="preset")
    made = sent()
    assert (made.noise.seed, made.step_count) == (5, 32)
    assert made.amount > 0.0
    assert any(bpy.context.scene.tyndall.heterogeneity.wind_m_per_s)
    looks = {(one.noise, one.amount, one.level) for one in (made, *_other_presets(preset))}
    assert len(looks) == len(PRESETS) >= 6
    bpy.ops.ed.undo()
    while bpy.context.scene.tyndall.heterogeneity.is_enabled:  # those of the others, too
        bpy.ops.ed.undo()
    assert bpy.context.scene.tyndall.heterogeneity.seed == 5


def _other_presets(preset: Path) -> list[Heterogeneity]:
    found = []
    for other in PRESETS:
        if other != preset:
            bpy.ops.tyndall.preset_apply(filepath=str(other))
            found.append(sent())
    return found


def test_a_preset_that_fails_says_why(air: TyndallHeterogeneity, tmp_path: Path) -> None:
    """One that somebody wrote by hand for another version; what it had set until then stays."""
    broken = tmp_path / "My_Fog.py"
    broken.write_text("import bpy\nbpy.context.scene.tyndall.fluff.amount = 1\n")
    with pytest.raises(RuntimeError, match=r'The preset "My Fog" fails: .*fluff'):
        bpy.ops.tyndall.preset_apply(filepath=str(broken))


def test_settings_survive_save_and_copies_of_the_scene(air: TyndallHeterogeneity, tmp_path: Path) -> None:
    """With their keys: a copied scene blows on its own."""
    key_wind((0, 1.0), (48, 3.0))
    before = at(48)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "air.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "air.blend"))
    assert at(48) == before
    copied = bpy.context.scene.copy()
    bpy.context.window.scene = copied
    assert at(48) == before


# Pictures


def picture() -> np.ndarray:
    """(36, 64, 3), through the pixels' centres."""
    return tyndall_pixels(bpy.context.scene)


@pytest.fixture
def beams() -> TyndallHeterogeneity:
    """The texture of a scene with four shafts of a lamp, off."""
    new_file()
    scene = build_beam_scene()
    scene.render.resolution_x, scene.render.resolution_y = 64, 36
    return scene.tyndall.heterogeneity


def test_an_amount_of_0_changes_no_bit(beams: TyndallHeterogeneity) -> None:
    """Nor does a texture that is off; 1 does, and keeps how bright the shafts are as a whole."""
    even = picture()
    beams.amount, beams.scale_m = 1.0, 0.5
    assert np.array_equal(picture(), even)
    beams.is_enabled = True
    beams.amount = 0.0
    assert np.array_equal(picture(), even)
    beams.amount = 1.0
    textured = picture()
    assert np.abs(textured - even).max() > 0.1 * textured.mean()
    assert textured.mean() == pytest.approx(even.mean(), rel=0.1)


def test_the_texture_goes_with_the_wind(beams: TyndallHeterogeneity) -> None:
    """Carried along by a metre in a second, it is the one that was put there by hand; a second later it is another."""
    beams.is_enabled, beams.scale_m, beams.amount = True, 0.5, 1.0
    beams.wind_m_per_s = (0.0, 1.0, 0.0)
    scene = bpy.context.scene
    scene.frame_set(24)
    carried = picture()
    scene.frame_set(48)
    assert not np.allclose(picture(), carried, rtol=0.05)
    beams.wind_m_per_s, beams.offset_m = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    assert np.array_equal(picture(), carried)


@pytest.mark.parametrize("wind_m_per_s", [(2.5, 0.0, 0.0), (0.0, 1.7, 0.2), (-1.0, 0.0, -4.0)])
def test_a_looped_wind_ends_where_it_begins(beams: TyndallHeterogeneity, wind_m_per_s: tuple[float, ...]) -> None:
    """The frame after the last is the first, to a ten-thousandth of the brightest pixel: speeds are single floats.

    A third through it is another picture.
    """
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 48
    beams.is_enabled, beams.scale_m, beams.amount = True, 0.5, 1.0
    beams.wind_m_per_s = wind_m_per_s
    bpy.ops.tyndall.loop_wind()
    pictures = {}
    for frame in (1, 17, 49):
        scene.frame_set(frame)
        pictures[frame] = picture()
    brightest = pictures[1].max()
    assert np.abs(pictures[49] - pictures[1]).max() < 1e-4 * brightest
    assert np.abs(pictures[17] - pictures[1]).max() > 0.05 * brightest


# What is painted


def paint(value: float = 0.5) -> bpy.types.Object:
    """An Empty whose cube of 2 m has an intensity painted all over it."""
    scene = bpy.context.scene
    box = add("Box", None, location=(1.0, 2.0, 3.0))
    box.tyndall.painted_air.resolution = (16, 8, 4)
    write_volume(box, "intensity", np.full((4, 8, 16), value, np.float32))
    scene.tyndall.heterogeneity.painted = box
    return box


def test_what_is_painted_goes_with_its_box(air: TyndallHeterogeneity) -> None:
    """At each frame where the Empty is then, keyed or not; equal to itself until anything of it changes."""
    box = paint()
    box.keyframe_insert("location", frame=1)
    box.location.x = 11.0
    box.keyframe_insert("location", frame=11)
    first, last = at(1), at(11)
    assert [row[3] for row in first.painted.world_from_unit] == [0.0, 1.0, 2.0, 1.0]
    assert last.painted.world_from_unit[0][3] == 10.0
    assert np.all(first.painted.intensity == 0.5)
    assert first.painted.amount is None
    assert at(1) == first != last
    write_volume(box, "intensity", np.full((4, 8, 16), 0.25, np.float32))
    assert at(1) != first


def test_a_painted_box_that_is_gone_or_flat_is_left_out(air: TyndallHeterogeneity) -> None:
    """The report names scene, box and reason; the texture stays."""
    box = paint()
    box.scale.z = 0.0
    heterogeneity, lines = read()
    assert heterogeneity.painted is None
    assert 'its painted air is left out: "Box" has a scale or a size of 0' in lines[0]
    box.scale.z = 1.0
    bpy.context.scene.collection.objects.unlink(box)
    heterogeneity, lines = read()
    assert heterogeneity.painted is None
    assert lines == ('Scene "Scene": its painted air is left out: "Box" is not in the scene',)
    bpy.data.objects.remove(box)
    assert read()[1] == ()


def test_only_a_box_can_be_chosen(air: TyndallHeterogeneity) -> None:
    """The field offers Empties."""
    assert may_be_painted(air, add("Empty", None))
    assert not may_be_painted(air, bpy.context.scene.camera)
