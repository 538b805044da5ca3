# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh becomes voxels by the buttons of the sidebar, Esc stops it, the view shows blocks, and a file is imported.

Places are those of Blender 3.4's sidebar at its default width, in pixels from its right and its top, in a high window.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import bpy

from support.mouse import click, press, through_browser, xdotool

CLICKS = (
    "tyndall.voxelize",
    "tyndall.import_tdag",
    "tyndall.import_vox",
    "tyndall.reload_voxels",
    "tyndall.voxels_to_mesh",
    "tyndall.export_voxels_vdb",
    "tyndall.export_voxels_vox",
)
TAB = (8, 245)
VOXELIZE, IMPORT_TDAG, IMPORT_VOX = (121, 367), (164, 393), (77, 393)
RELOAD = (44, 458)
TO_MESH, TO_VDB, TO_VOX = (178, 637), (121, 637), (63, 637)


def boxes() -> list[str]:
    return sorted(thing.name for thing in bpy.data.objects if thing.tyndall_voxels.path)


def paint(thing: bpy.types.Object) -> None:
    """Red, with a green face that the view shows."""
    for colour in ((1.0, 0.02, 0.02, 1.0), (0.02, 1.0, 0.02, 1.0)):
        material = bpy.data.materials.new("Paint")
        material.use_nodes = True
        material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = colour
        thing.data.materials.append(material)
    thing.data.materials.pop(index=0)
    top = max(thing.data.polygons, key=lambda polygon: polygon.center.z)
    top.material_index = 1


def is_at_work() -> bool:
    return any(thread.name == "tyndall voxelize" for thread in threading.enumerate())


def stop_by_escape(window: Any) -> Iterator[float]:
    """What would never end."""
    from addon.operators.voxelize import TYNDALL_OT_voxelize

    def endless(_operator: Any, progress: Any) -> None:
        progress.message = "voxels without end"
        while True:
            progress.poll()
            time.sleep(0.01)

    whole, TYNDALL_OT_voxelize.work = TYNDALL_OT_voxelize.work, endless
    yield from click(window, VOXELIZE)
    window.screenshot("voxels_dialog")
    xdotool("key", "Return")
    yield from window.until(is_at_work)
    yield 0.5
    window.screenshot("voxels_running")
    xdotool("key", "Escape")
    yield from window.until(lambda: not is_at_work())
    yield from window.calm()
    TYNDALL_OT_voxelize.work = whole


def session(window: Any) -> Iterator[float]:
    yield from window.calm()
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    bpy.context.scene.render.engine = "TYNDALL"
    bpy.context.scene.tyndall.voxelize.resolution = "64"
    bpy.ops.object.modifier_add(type="SUBSURF")
    bpy.context.object.modifiers[0].levels = 4
    paint(bpy.context.object)
    bpy.ops.wm.save_as_mainfile(filepath=str(window.folder / "scene.blend"))
    bpy.ops.ed.undo_push(message="begin")
    window.area("VIEW_3D").spaces[0].show_region_ui = True
    yield from window.calm()
    yield from click(window, TAB)
    window.screenshot("voxels_tab")
    yield from stop_by_escape(window)
    window.facts["stopped"] = boxes()
    yield from click(window, VOXELIZE)
    xdotool("key", "Return")
    yield from window.until(lambda: bool(boxes()))
    yield from window.calm()
    yield 0.5
    window.facts["made"] = boxes()
    window.screenshot("voxels_made")
    for name, key in (("undone", "ctrl+z"), ("redone", "ctrl+shift+z")):
        xdotool("mousemove", 500, 700)
        yield from window.settled()
        yield from press(window, (key,))
        window.facts[name] = boxes()
    yield from click(window, RELOAD)
    yield from through_browser(window, IMPORT_TDAG, "voxels_browser")
    yield from through_browser(window, TO_VOX, "voxels_to_vox")
    yield from through_browser(window, IMPORT_VOX, "voxels_from_vox")
    window.facts["imported"] = boxes()
    window.screenshot("voxels_imported")
    yield from through_browser(window, TO_VDB, "voxels_to_vdb")
    window.facts["written"] = sorted(path.name for path in window.folder.glob("*.v[do][bx]"))
    yield from click(window, TO_MESH)
    window.facts["mesh"] = len(bpy.context.object.data.polygons)
    window.screenshot("voxels_mesh")
