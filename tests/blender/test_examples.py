# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples open in every Blender that we support; a newer one's files crash 3.4 while it reads them."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.blend"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_was_saved_by_the_oldest_blender(path: Path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert bpy.data.version[:2] == (3, 4)
    assert bpy.context.scene.camera is not None
