# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m tyndall render`` with the real bpy, in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import bpy
import pytest

from support.small_scenes import cube, empty_scene, light

REPOSITORY = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(not getattr(bpy.app, "module", False), reason="needs a Python that has bpy")


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    """A lit cube of which the second frame is another picture than the first."""
    scene = empty_scene()
    scene.camera.data.ortho_scale = 5
    cube(material=None)
    lamp = light("SUN", (0, 0, 5))
    for frame in (1, 2):
        lamp.data.energy = frame
        lamp.data.keyframe_insert("energy", frame=frame)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    folders = os.pathsep.join(str(REPOSITORY / folder) for folder in ("python", "build/release/python"))
    command = [sys.executable, "-m", "tyndall", "render", *arguments]
    environment = os.environ | {"PYTHONPATH": folders}
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=180, env=environment)


def test_frames_statistics_and_resume(blend: Path) -> None:
    """Two frames, one session: the second sends no geometry; the same command again renders nothing."""
    output, statistics = blend.parent / "out" / "f.exr", blend.parent / "s.json"
    arguments = (
        str(blend),
        "--output",
        str(output),
        "--frames",
        "1-2",
        "--samples",
        "1",
        "--statistics",
        str(statistics),
    )
    done = run(*arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(path.name for path in output.parent.iterdir()) == ["f_0001.exr", "f_0002.exr"]
    first, second = json.loads(statistics.read_text())["frames"]
    assert (first["status"], second["status"]) == ("rendered", "rendered")
    assert first["statistics"]["counts"]["samples per pixel"] == 1
    assert first["statistics"]["counts"]["meshes sent"] == 1
    assert second["statistics"]["counts"]["meshes sent"] == 0
    again = run(*arguments)
    assert again.returncode == 0
    assert again.stdout.count("skipped") == 2


def test_a_frame_that_fails_gives_an_exit_code_and_no_file(blend: Path) -> None:
    """The scene lacks a camera; the reason is told, and no picture is left."""
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    bpy.data.objects.remove(bpy.context.scene.camera)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
    done = run(str(blend), "--output", str(blend.parent / "f.png"))
    assert done.returncode == 1, done.stdout + done.stderr
    assert "camera" in done.stderr.lower()
    assert not (blend.parent / "f.png").exists()
