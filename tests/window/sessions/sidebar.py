# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab Light Shafts from the medium to the output: its steps, as an artist first sees them, and their buttons.

Places are those of Blender 3.4's sidebar at its default width, in pixels from its right and its top, in a high window,
while the tab shows one panel alone.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy

from support.beam_scene import build_beam_scene
from support.mouse import TAB, click, press, show_only

CLICKS = (
    "tyndall.add_fog_box",
    "tyndall.select_medium",
    "tyndall.show_light_depth",
    "tyndall.transfer_state_key",
    "tyndall.key_wind",
    "tyndall.loop_wind",
    "tyndall.loop_holes",
    "tyndall.toggle_key",
    "tyndall.jump_to_key",
    "tyndall.render_preset_add",
    "tyndall.preset_apply",
    "tyndall.copy_reports",
)
PANEL_HEADER = (100, 15)
ADD_FOG_BOX, SELECT = (104, 83), (48, 72)
SHOW_DEPTH_MAP = (104, 495)
PREVIOUS_KEY, NEXT_KEY = (202, 46), (68, 46)
KEY_COLOURS, KEY_WIND, LOOP_WIND, LOOP_HOLES = ((104, y) for y in (72, 93, 114, 135))
KEY_OF_FIRST = (202, 161)
PRESETS, ADD_PRESET, PRODUCTION = (68, 16), (-25, 129), (70, 76)
LAST_RENDER, COPY = (180, 215), (104, 366)


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    build_beam_scene()
    bpy.context.view_layer.objects.active = bpy.data.objects["Lamp"]
    bpy.ops.ed.undo_push(message="begin")
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    yield from window.calm()
    yield from click(window, TAB)
    window.screenshot("sidebar_begin")
    window.facts["steps"] = {}
    yield from fill_with_haze(window)
    yield from look_through_the_lamp(window)
    yield from animate(window)
    yield from put_out(window)


def play(window: Any, name: str, places: tuple[tuple[int, int], ...], found: Callable[[], object]) -> Iterator[float]:
    """Click, look, and write down what came of it."""
    for place in places:
        yield from click(window, place)
    window.facts["steps"][name] = found()
    window.screenshot(f"sidebar_{name.replace(' ', '_')}")


def fill_with_haze(window: Any) -> Iterator[float]:
    def media() -> list[list[str]]:
        selected = [thing.name for thing in bpy.context.selected_objects]
        return [[thing.name for thing in bpy.data.objects if thing.name.startswith("Fog")], selected]

    bpy.data.objects.remove(bpy.data.objects["Fog Box"])
    bpy.data.materials.remove(bpy.data.materials["Fog"])
    show_only("TYNDALL_PT_sidebar_medium")
    yield from window.calm()
    window.screenshot("sidebar_no_medium")
    yield from play(window, "fog box", (ADD_FOG_BOX,), media)
    bpy.ops.object.select_all(action="DESELECT")
    yield from play(window, "select", (SELECT,), media)


def look_through_the_lamp(window: Any) -> Iterator[float]:
    """In an Image Editor, which takes the picture by itself."""
    bpy.context.view_layer.objects.active = bpy.data.objects["Lamp"]
    bpy.ops.tyndall.occluder_edit_add(kind="HOLES")
    area = window.area("PROPERTIES")
    area.type = "IMAGE_EDITOR"
    show_only("TYNDALL_PT_sidebar_occluder_edits")
    yield from window.calm()
    yield from play(window, "depth map", (SHOW_DEPTH_MAP,), lambda: area.spaces[0].image.name)
    area.type = "PROPERTIES"


def animate(window: Any) -> Iterator[float]:
    from addon.keyed_shafts import animated_properties

    def keys() -> dict[str, list[float]]:
        return {one.label: list(one.key_frames) for one in animated_properties(bpy.context.scene)}

    air = bpy.context.scene.tyndall.heterogeneity
    air.is_enabled, air.scale_m, air.wind_m_per_s = True, 2.0, (1.0, 0.1, 0.0)
    bpy.ops.tyndall.transfer_function_preset(preset="SUNRISE")
    bpy.ops.ed.undo_push(message="animate")
    show_only("TYNDALL_PT_sidebar_animate")
    yield from window.calm()
    yield from click(window, PANEL_HEADER)
    window.screenshot("sidebar_nothing_keyed")
    yield from play(window, "loop wind", (LOOP_WIND,), lambda: list(air.wind_m_per_s))
    for name, place in (("key colours", KEY_COLOURS), ("key wind", KEY_WIND), ("loop holes", LOOP_HOLES)):
        yield from play(window, name, (place,), keys)
    for name, place in (("next key", NEXT_KEY), ("previous key", PREVIOUS_KEY)):
        yield from play(window, name, (place,), lambda: bpy.context.scene.frame_current)
    yield from play(window, "remove key", (KEY_OF_FIRST,), keys)
    for name, key in (("undo remove key", "ctrl+z"), ("redo remove key", "ctrl+shift+z")):
        yield from press(window, (key,))
        window.facts["steps"][name] = keys()


def put_out(window: Any) -> Iterator[float]:
    from addon import last_render

    last_render.record(
        bpy.context.scene.name,
        {
            "stages": [{"name": "scene update", "seconds": 0.012}, {"name": "light shafts", "seconds": 1.2}],
            "skipped": [{"what": "world", "reason": "it is black"}],
            "reports": ['Material "Gold": Glossy is drawn as Diffuse'],
        },
    )
    show_only("TYNDALL_PT_sidebar_output")
    yield from window.calm()
    yield from click(window, PANEL_HEADER)

    def presets() -> list[str]:
        return [path.parent.name for path in Path.home().rglob("New_Preset.py")]

    yield from play(window, "save preset", (PRESETS, ADD_PRESET), presets)
    yield from press(window, ("Escape",))
    yield from play(window, "preset", (PRESETS, PRODUCTION), lambda: bpy.context.scene.tyndall.pixel_samples)
    yield from press(window, ("Escape",))
    yield from play(window, "copy", (LAST_RENDER, COPY), lambda: json.loads(bpy.context.window_manager.clipboard))
