# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the pictures of the guide to light shafts, so that they show what the code does.

scripts/python examples/guide_pictures.py [NAME...]
"""

from __future__ import annotations

import colorsys
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy
import numpy as np

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


def show_frame(frame: int) -> None:
    """Go to a frame of an animated example."""
    bpy.context.scene.frame_set(frame)


def alarm_at_dawn() -> None:
    """Give the terrain, which has functions of its own, the one of the other scenes."""
    scene = bpy.context.scene
    scene.tyndall.shafts.transfer_states.clear()
    colour("ALARM")
    scene.frame_set(25)


def stained_glass(size_px: int = 512, pane_count: int = 60) -> bpy.types.Image:
    """Panes of coloured glass between strips of lead, which tile."""
    random = np.random.default_rng(4)
    centres = random.random((pane_count, 2))
    hues = random.choice([0.0, 0.08, 0.12, 0.38, 0.6, 0.63, 0.8], pane_count)
    colours = np.array([colorsys.hsv_to_rgb(hue, 0.95, 1.0) for hue in hues])
    axis = (np.arange(size_px) + 0.5) / size_px
    places = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 1, 2)
    away = np.abs(places - centres)
    distance = np.hypot(*np.moveaxis(np.minimum(away, 1.0 - away), -1, 0))
    nearest = np.argsort(distance, axis=1)[:, :2]
    gap = np.take_along_axis(distance, nearest, axis=1)
    pixels = np.ones((size_px * size_px, 4), np.float32)
    pixels[:, :3] = colours[nearest[:, 0]] * np.clip((gap[:, 1] - gap[:, 0]) / 0.02 - 0.5, 0.0, 1.0)[:, None]
    image = bpy.data.images.new("Stained Glass", size_px, size_px)
    image.pixels.foreach_set(pixels.ravel())
    return image


def breakup(size_px: int = 512) -> bpy.types.Image:
    """Blades of light that turn around the middle, as a sheet of metal throws them."""
    y, x = np.mgrid[0:size_px, 0:size_px] / size_px * 2.0 - 1.0
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    is_open = (np.sin(7.0 * angle + 5.0 * radius) > 0.15) & (radius > 0.12) & (radius < 0.95)
    pixels = np.ones((size_px, size_px, 4), np.float32)
    pixels[..., :3] = is_open[..., None]
    image = bpy.data.images.new("Breakup", size_px, size_px)
    image.pixels.foreach_set(pixels.ravel())
    return image


def throw_blades() -> None:
    """Put the same gobo into every spot."""
    image = breakup()
    for thing in bpy.context.scene.objects:
        if thing.type == "LIGHT" and thing.data.type == "SPOT":
            thing.data.tyndall.gobo_image = image


def throw_glass(size_m: float) -> None:
    """Have the sun throw panes of stained glass."""
    settings = sun().tyndall
    settings.gobo_image, settings.gobo_size_m, settings.gobo_extension = stained_glass(), size_m, "REPEAT"


#: Strokes over the hall: middle and radius, as shares of the frame's width from its lower left corner, and a colour.
STROKES = (
    ((0.10, 0.25), 0.07, (1.0, 0.12, 0.05)),
    ((0.30, 0.32), 0.05, (0.1, 0.9, 0.25)),
    ((0.42, 0.33), 0.04, (0.15, 0.35, 1.0)),
)


def paint_shafts() -> None:
    """Paint over the hall what its shafts shall be like, and have the sun's map fitted to it."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE_PX, 100
    bpy.context.view_layer.objects.active = next(thing for thing in scene.objects if thing.data == sun())
    bpy.ops.tyndall.paint_strokes()
    strokes = sun().tyndall.light_map_fit.views[0].strokes
    width, height = strokes.size
    pixels = np.zeros((height, width, 4), np.float32)
    places = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1) / width
    for middle, radius, colour in STROKES:
        pixels[np.hypot(*np.moveaxis(places - middle, -1, 0)) < radius] = (*colour, 1.0)
    strokes.pixels.foreach_set(pixels.ravel())
    strokes.update()
    bpy.ops.tyndall.fit_light_map()


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
    Picture("gobo_hall_glass", "window_hall", lambda: throw_glass(5.0)),
    Picture("gobo_stage_before", "stage_spots"),
    Picture("gobo_stage", "stage_spots", throw_blades),
    Picture("fit_hall", "window_hall", paint_shafts),
    Picture("colour_terrain_alarm", "terrain_sunrise", alarm_at_dawn),
    *(
        Picture(f"colour_sunrise_{frame}", "terrain_sunrise", partial(show_frame, frame))
        for frame in (1, 25, 50, 75, 100)
    ),
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
    scene.render.use_stamp_filename = False  # a picture does not say where its scene lay
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
