# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture the Air, by the mouse: presets, the box that is painted in, all that is done to it at once, and its files.

Places are those of Blender 3.4's sidebar at its default width, in pixels from its right and its top, in a high window.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy

from support.mouse import TAB, click, press, show_only, through_browser, xdotool

CLICKS = (
    "tyndall.preset_apply",
    "tyndall.air_preset_add",
    "tyndall.add_painted_box",
    "tyndall.painted_air_fill",
    "tyndall.painted_air_clear",
    "tyndall.painted_air_flip",
    "tyndall.painted_air_resample",
    "tyndall.painted_air_bake",
    "tyndall.bake_air",
    "tyndall.load_painted_air",
)
PANEL_HEADER = (100, 15)
PRESETS, MIST_BANKS, ADD_PRESET = (68, 16), (70, 118), (-25, 234)
PAINT_HEADER, ADD_BOX = (180, 236), (104, 292)
VOLUMES_HEADER = (180, 552)
FILL, CLEAR = (147, 774), (60, 774)
FLIP, RESAMPLE = (147, 800), (60, 800)
BAKE, TO_FILE, FROM_FILE = (104, 826), (147, 852), (60, 852)


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    bpy.context.scene.render.engine = "TYNDALL"
    bpy.context.scene.tyndall.heterogeneity.is_enabled = True
    bpy.ops.wm.save_as_mainfile(filepath=str(window.folder / "scene.blend"))
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    window.facts["steps"] = {}
    show_only("TYNDALL_PT_heterogeneity")
    yield from window.calm()
    yield from click(window, TAB)
    yield from click(window, PANEL_HEADER)
    yield from choose_presets(window)
    show_only("TYNDALL_PT_painted_volumes")
    yield from window.calm()
    yield from click(window, PAINT_HEADER)
    yield from change_volumes(window)
    yield from go_through_files(window)


def play(window: Any, name: str, places: tuple[tuple[int, int], ...], found: Callable[[], object]) -> Iterator[float]:
    """Click, look, and write down what came of it."""
    for place in places:
        yield from click(window, place)
    window.facts["steps"][name] = found()
    window.screenshot(f"air_{name.replace(' ', '_')}")


def choose_presets(window: Any) -> Iterator[float]:
    air = bpy.context.scene.tyndall.heterogeneity
    window.screenshot("air_texture")
    yield from play(window, "preset", (PRESETS, MIST_BANKS), lambda: [air.scale_m, *air.wind_m_per_s])
    yield from press(window, ("Escape",))
    yield from play(
        window,
        "save preset",
        (PRESETS, ADD_PRESET),
        lambda: [path.parent.name for path in Path.home().rglob("New_Preset.py")],
    )
    yield from press(window, ("Escape",))


def box() -> Any:
    return bpy.context.scene.tyndall.heterogeneity.painted


def painted() -> list[float | None]:
    """Means of intensity, amount and softness; None: nothing is painted."""
    from addon.painted_air import read_volume

    volumes = [read_volume(box(), name) for name in ("intensity", "amount", "level")]
    return [None if values is None else round(float(values.mean()), 4) for values in volumes]


def change_volumes(window: Any) -> Iterator[float]:
    from addon.painted_air import read_volume, write_volume

    yield from play(window, "box", (ADD_BOX,), lambda: box().name)
    yield from click(window, VOLUMES_HEADER)
    bpy.context.scene.tyndall.air_brush.intensity = 0.25
    yield from play(window, "fill", (FILL,), painted)
    values = read_volume(box(), "intensity").copy()
    values[:, :, : values.shape[2] // 4] = 1.0
    write_volume(box(), "intensity", values)
    bpy.ops.ed.undo_push(message="uneven")
    yield from play(window, "flip", (FLIP,), lambda: bool((read_volume(box(), "intensity") == values[..., ::-1]).all()))
    for name, key in (("undo flip", "ctrl+z"), ("redo flip", "ctrl+shift+z")):
        yield from press(window, (key,))
        window.facts["steps"][name] = bool((read_volume(box(), "intensity") == values[..., ::-1]).all())
    yield from click(window, RESAMPLE)
    window.screenshot("air_resample_dialog")
    xdotool("key", "Return")
    yield from window.calm()
    yield from play(window, "resample", (), lambda: list(box().tyndall.painted_air.kept_resolution))
    yield from play(window, "bake", (BAKE,), painted)
    yield from press(window, ("ctrl+z",))
    yield from play(window, "undo bake", (), painted)


def go_through_files(window: Any) -> Iterator[float]:
    """Bake, clear and load, through Blender's file browser, which shows what may be chosen."""
    from addon.baked_air import baked_volume
    from addon.painted_air import read_volume

    yield from through_browser(window, TO_FILE, "air_bake_to_file")
    window.facts["steps"]["to file"] = Path(window.folder / "scene_air.vdb").is_file()
    window.facts["steps"]["is shown"] = baked_volume(box()) is not None
    before = read_volume(box(), "intensity")
    yield from play(window, "clear", (CLEAR,), painted)
    yield from through_browser(window, FROM_FILE, "air_load_from_file")
    loaded = read_volume(box(), "intensity")
    window.facts["steps"]["from file"] = loaded is not None and bool((loaded == before).all())
    window.screenshot("air_loaded")
