# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders FOLDER/scene.blend in the background, and compares with FOLDER/window.exr, float by float."""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

REPOSITORY = Path(__file__).parents[2]
for source in (REPOSITORY, REPOSITORY / "python", REPOSITORY / "build/release/python"):
    sys.path.append(str(source))

import addon  # noqa: E402  only there once the path is set


def pixels(path: Path) -> np.ndarray:
    image = bpy.data.images.load(str(path))
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values


folder = Path(sys.argv[sys.argv.index("--") + 1])
addon.register()
bpy.ops.wm.open_mainfile(filepath=str(folder / "scene.blend"))
bpy.context.scene.render.filepath = str(folder / "headless.exr")
bpy.ops.render.render(write_still=True)
seen, expected = pixels(folder / "window.exr"), pixels(folder / "headless.exr")
facts = {
    "largest_difference": float(np.abs(seen - expected).max()),
    "contrast": float(expected.reshape(-1, 4)[:, :3].std()),
}
(folder / "comparison.json").write_text(json.dumps(facts))
addon.unregister()
