# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews, as far as they go without a window: what Blender gets, and what the artist's scene does not notice."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import last_render
from addon.engine import TyndallRenderEngine, failures, preview, sessions
from support.exr import read_planes
from support.small_scenes import cube, empty_scene, light, material, node


@pytest.fixture
def stage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> bpy.types.Scene:
    """A mirror before a red world, below a sun. All that renders is a preview."""
    monkeypatch.setattr(TyndallRenderEngine, "render", preview.render)
    failures.clear()
    scene = empty_scene(16)
    scene.camera.data.ortho_scale = 4.0
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.02, 0.02, 1)
    glossy = "ShaderNodeBsdfAnisotropic" if bpy.app.version >= (4, 0, 0) else "ShaderNodeBsdfGlossy"
    mirror = material(
        "Mirror", surface=lambda new, _: node(new, glossy, Color=(0.8, 0.8, 0.8, 1), Roughness=0.0).outputs[0]
    )
    cube(material=mirror)
    light("SUN", (0, 0, 5), energy=1.0).rotation_euler = (0.5, 0.0, 0.0)  # else the mirror showed it
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode = "OPEN_EXR", "RGBA"
    settings.color_depth, settings.exr_codec = "32", "NONE"
    scene.render.filepath = str(tmp_path / "preview.exr")
    return scene


def test_a_preview_follows_mirrors_and_leaves_no_trace(stage: bpy.types.Scene) -> None:
    """The mirror shows the world, though the scene's settings ask for no mirrors; nobody recorded anything."""
    bpy.ops.render.render(write_still=True)
    pixels = read_planes(Path(stage.render.filepath))[""]
    assert np.abs(pixels[8, 8, :3] - (0.4, 0.016, 0.016)).max() < 1e-4
    assert np.abs(pixels[0, 0, :3] - (0.5, 0.02, 0.02)).max() < 1e-4
    assert last_render.statistics_of(stage.name) is None
    assert not sessions._kept  # noqa: SLF001
    assert failures.last_error() is None


def test_a_preview_that_is_not_wanted_any_more_ends_at_once(
    stage: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blender asks it to stop when a slider moves: nothing of the scene is read."""
    went_on: list[object] = []
    monkeypatch.setattr(preview, "is_esc_pressed", lambda _engine: True)
    monkeypatch.setattr(preview, "read_camera", lambda *_args, **_more: went_on.append(True))
    bpy.ops.render.render()
    assert not went_on


def test_a_preview_that_fails_is_a_picture_all_the_same(
    stage: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An exception in the thread of a preview ends it, and neither Blender nor the state of final renders."""

    def broken(*_args: object, **_more: object) -> None:
        raise ValueError("broken on purpose")

    monkeypatch.setattr(preview, "read_camera", broken)
    messages: list[str] = []
    monkeypatch.setattr(preview, "tell", lambda _engine, message: messages.append(message))
    bpy.ops.render.render()
    assert messages == ["Tyndall: broken on purpose"]
    assert failures.last_error() is None
