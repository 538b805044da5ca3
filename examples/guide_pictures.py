# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the pictures of the guide to light shafts, so that they show what the code does.

scripts/python examples/guide_pictures.py [NAME...]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy

import tyndall.blender

ROOT = Path(__file__).resolve().parent.parent
SIZE_PX = (640, 360)


def sun() -> bpy.types.Light:
    """The scene's only one."""
    return next(thing.data for thing in bpy.context.scene.objects if thing.type == "LIGHT" and thing.data.type == "SUN")


def add_edit(kind: str, **settings: object) -> bpy.types.PropertyGroup:
    """Add an edit of the sun's occluders; settings of the noise are given as they are called there."""
    edits = sun().tyndall.occluder_edits
    edit = edits.add()
    edit.name, edit.kind, edit.order = kind, kind, len(edits)
    for name, value in settings.items():
        setattr(edit.noise if hasattr(edit.noise, name) else edit, name, value)
    return edit


def colour(preset: str) -> None:
    """Recolour the shafts by a transfer function made of a preset."""
    bpy.ops.tyndall.transfer_function_preset(preset=preset)


def sunrise(state: float) -> None:
    """Recolour by what lies between the whole functions of night, dawn and sunrise."""
    for preset in ("MOONLIT", "PASTEL_DAWN", "SUNRISE"):
        bpy.ops.tyndall.transfer_state_add()
        colour(preset)
    bpy.context.scene.tyndall.shafts.transfer_state = state


@dataclass(frozen=True)
class Picture:
    """One of docs/pictures: an example, and what is done to it."""

    name: str
    scene: str
    edit: Callable[[], object] = lambda: None


PICTURES = (
    Picture("edits_forest_before", "forest_clearing"),
    Picture("edits_forest_close", "forest_clearing", lambda: add_edit("CLOSE", size_m=0.35)),
    Picture("edits_forest_close_along", "forest_clearing", lambda: add_edit("EPIPOLAR_CLOSE", size_m=0.25)),
    Picture("edits_forest_silhouette", "forest_clearing", lambda: add_edit("SILHOUETTE", size_m=0.15)),
    Picture("edits_hall_before", "window_hall"),
    Picture(
        "edits_hall_holes",
        "window_hall",
        lambda: add_edit("HOLES", scale_m=1.0, octaves=4, probability=0.12, affects_surfaces=True),
    ),
    Picture("colour_hall_ember", "window_hall", lambda: colour("EMBER")),
    Picture("colour_hall_teal_orange", "window_hall", lambda: colour("TEAL_ORANGE")),
    Picture("colour_hall_alarm", "window_hall", lambda: colour("ALARM")),
    Picture("colour_forest_alarm", "forest_clearing", lambda: colour("ALARM")),
    Picture("colour_sunrise_0", "forest_clearing", lambda: sunrise(0.0)),
    Picture("colour_sunrise_1", "forest_clearing", lambda: sunrise(1.0)),
    Picture("colour_sunrise_2", "forest_clearing", lambda: sunrise(1.6)),
)


def render(picture: Picture) -> None:
    """Write docs/pictures/NAME.jpg."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "examples" / f"{picture.scene}.blend"))
    scene = bpy.context.scene
    picture.edit()
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y = SIZE_PX
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "JPEG", 88
    scene.render.filepath = str(ROOT / "docs" / "pictures" / f"{picture.name}.jpg")
    bpy.ops.render.render(write_still=True)


def main() -> None:
    """Render all, or those that are named."""
    wanted = sys.argv[1:] or [picture.name for picture in PICTURES]
    tyndall.blender.enable()
    try:
        for picture in PICTURES:
            if picture.name in wanted:
                render(picture)
    finally:
        tyndall.blender.disable()


if __name__ == "__main__":
    main()
