# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture that memory has no room for is refused before the scene is read, and no file is touched."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from addon.engine import final
from support.small_scenes import empty_scene, plane
from tyndall import memory_estimate


def test_a_picture_without_room_is_an_error_that_says_what_to_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: 100 << 20)
    monkeypatch.setattr(final, "LookReader", lambda **_: pytest.fail("the scene was read"))
    scene = empty_scene(3000)
    plane()
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(tmp_path / "picture.png")
    with pytest.raises(RuntimeError, match=r"3000 x 3000 pixels takes 0\.3 GiB .* 0\.1 GiB are free: lower the resol"):
        bpy.ops.render.render(write_still=True)
    assert not list(tmp_path.iterdir())
