# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the air to a file through Blender's file browser, and loads it again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from support.mouse import TAB, click, show_only


def session(window: Any) -> Iterator[float]:
    from addon.baked_air import baked_volume
    from addon.painted_air import read_volume, write_volume

    yield from window.calm()
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    bpy.context.scene.render.engine = "TYNDALL"
    bpy.ops.tyndall.add_painted_box(voxels=16)
    box = bpy.context.scene.tyndall.heterogeneity.painted
    nx, ny, nz = box.tyndall.painted_air.resolution
    painted = np.ones((nz, ny, nx), np.float32)
    painted[: nz // 2] = 0.25
    write_volume(box, "intensity", painted)
    area, path = window.area("VIEW_3D"), window.folder / "air.vdb"
    area.spaces[0].show_region_ui = True
    show_only("TYNDALL_PT_painted_volumes")
    yield from window.calm()
    yield from click(window, TAB)
    window.screenshot("air_files_panel")

    def through_browser(operator: Callable[..., Any], name: str) -> Iterator[float]:
        with bpy.context.temp_override(window=window.bpy_window, area=area, region=window.region("VIEW_3D")):
            operator("INVOKE_DEFAULT", filepath=str(path))
        yield 1.0
        yield from window.calm()
        window.screenshot(name)
        with bpy.context.temp_override(window=window.bpy_window, area=window.area("FILE_BROWSER")):
            bpy.ops.file.execute()
        yield 0.5
        yield from window.calm()

    yield from through_browser(bpy.ops.tyndall.bake_air, "air_files_bake")
    window.facts["is_written"] = Path(path).is_file()
    window.facts["is_shown"] = baked_volume(box) is not None
    window.screenshot("air_files_volume")
    write_volume(box, "intensity", None)
    yield from through_browser(bpy.ops.tyndall.load_painted_air, "air_files_load")
    loaded = read_volume(box, "intensity")
    window.facts["is_loaded"] = loaded is not None and bool((loaded == painted).all())
