# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the pictures of the guide to light shafts, so that they show what the code does.

scripts/python examples/guide_pictures.py [NAME...]
"""

from __future__ import annotations

import colorsys
import sys
import tempfile
import time
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


#: Strokes over beams of the stage: the spot, its place and a place farther along it in the picture, as shares of its
#: width and height from the lower left corner.
BEAMS = (("Back 2", (0.327, 0.832), (0.13, 0.49)), ("Back 5", (0.697, 0.852), (0.83, 0.5)))


def paint_beams() -> None:
    """Paint two beams of the stage as fans of five blades, red and dark, and have the spots' maps fitted to that."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE_PX, 100
    for name, lamp, far in BEAMS:
        spot = scene.objects[name]
        bpy.context.view_layer.objects.active = spot
        bpy.ops.tyndall.paint_strokes()
        strokes = spot.data.tyndall.light_map_fit.views[0].strokes
        width, height = strokes.size
        columns, rows = np.meshgrid(np.arange(width), np.arange(height))
        across, up = columns - lamp[0] * width, rows - lamp[1] * height
        axis = np.array([(far[0] - lamp[0]) * width, (far[1] - lamp[1]) * height])
        along, beside = (across * axis[0] + up * axis[1]), (across * axis[1] - up * axis[0])
        blade = np.floor(beside / np.maximum(along, 1.0) / BLADE + 0.5)
        is_painted = (along > 0.0) & (np.abs(blade) <= 2.0)
        pixels = np.zeros((height, width, 4), np.float32)
        pixels[is_painted] = (0.0, 0.0, 0.0, 1.0)
        pixels[is_painted & (blade % 2.0 == 0.0)] = (4.0, 0.25, 0.05, 1.0)
        strokes.pixels.foreach_set(pixels.ravel())
        strokes.update()
        bpy.ops.tyndall.fit_light_map()


#: Tangent of the angle that a blade has in the picture.
BLADE = 0.06


def let_light_bounce(*, with_shafts: bool = False) -> None:
    """Have Cycles draw indirect light, too; with its own fog, or with light shafts over a picture without fog."""
    scene = bpy.context.scene
    scene.cycles.device, scene.cycles.samples = "CPU", 16
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 4
    if with_shafts:
        bpy.ops.tyndall.over_engine_set_up()
        bpy.ops.tyndall.leave_fog()


def paint_air(places_m: list[tuple[float, float, float]], volume: str, value: float, radius_m: float) -> None:
    """Paint one stroke, at full opacity, through places in the world."""
    brush = bpy.context.scene.tyndall.air_brush
    brush.volume, brush.mode, brush.opacity, brush.radius_m = volume, "PAINT", 1.0, radius_m
    setattr(brush, volume.lower(), value)
    dabs = [{"name": "", "location": place_m, "pressure": 1.0} for place_m in places_m]
    bpy.ops.tyndall.paint_air_stroke(dabs=dabs)


def paint_one_shaft() -> None:
    """Dim the hall's shafts but the one that falls on the table, with dust in it: by paint in the air."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    bpy.ops.tyndall.add_painted_box(voxels=128)
    scene.tyndall.heterogeneity.amount = 0.0
    scene.tyndall.heterogeneity.scale_m = 0.8
    shaft_m = [(-5.5, -3.7, 5.7), (-0.4, -6.5, 0.9)]
    scene.tyndall.air_brush.volume, scene.tyndall.air_brush.intensity = "INTENSITY", 0.12
    bpy.ops.tyndall.painted_air_fill()
    paint_air(shaft_m, "INTENSITY", 5.0, 1.6)
    paint_air(shaft_m, "AMOUNT", 1.0, 1.6)


def texture(preset: str, **settings: object) -> None:
    """Give the air a preset's texture, with some of its settings changed."""
    bpy.ops.tyndall.preset_apply(filepath=str(ROOT / "addon" / "presets" / "air" / f"{preset}.py"))
    for name, value in settings.items():
        setattr(bpy.context.scene.tyndall.heterogeneity, name, value)


@dataclass(frozen=True)
class Picture:
    """One of docs/pictures: an example, and what is done to it."""

    name: str
    scene: str
    edit: Callable[[], object] = lambda: None
    engine: str = "TYNDALL"


PICTURES = (
    Picture("edits_forest_before", "forest_clearing"),
    Picture("edits_forest_close", "forest_clearing", lambda: add_edit("CLOSE", size_m=0.35)),
    Picture(
        "edits_forest_close_floor", "forest_clearing", lambda: add_edit("CLOSE", size_m=0.35, affects_surfaces=True)
    ),
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
    Picture("fit_stage", "stage_spots", paint_beams),
    Picture("paint_hall", "window_hall", paint_one_shaft),
    Picture("over_hall_cycles", "window_hall", let_light_bounce, engine="CYCLES"),
    Picture("over_hall_shafts", "window_hall", partial(let_light_bounce, with_shafts=True), engine="CYCLES"),
    Picture("air_hall_smoke", "window_hall", lambda: texture("Drifting_Smoke", scale_m=4.0)),
    Picture("air_hall_mist", "window_hall", lambda: texture("Mist_Banks")),
    Picture("air_stage_smoke", "stage_spots", lambda: texture("Drifting_Smoke")),
    Picture("colour_terrain_alarm", "terrain_sunrise", alarm_at_dawn),
    *(
        Picture(f"colour_sunrise_{frame}", "terrain_sunrise", partial(show_frame, frame))
        for frame in (1, 25, 50, 75, 100)
    ),
)
#: Not a render but a comparison.
EDGES = "over_forest_edges"


def render(picture: Picture) -> None:
    """Write docs/pictures/NAME.jpg."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "examples" / f"{picture.scene}.blend"))
    scene = bpy.context.scene
    scene.render.engine = picture.engine
    picture.edit()
    scene.render.resolution_x, scene.render.resolution_y = SIZE_PX
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "JPEG", 88
    scene.render.use_stamp_filename = False  # a picture does not say where its scene lay
    scene.render.filepath = str(ROOT / "docs" / "pictures" / f"{picture.name}.jpg")
    started = time.process_time()
    bpy.ops.render.render(write_still=True)
    print(f"{picture.name}: {time.process_time() - started:.0f} s of CPU time, both cores summed")


def rendered_crop(folder: str) -> np.ndarray:
    """What a render of the scene has inside its border: scene-linear, (height, width, 4)."""
    scene = bpy.context.scene
    scene.render.filepath = str(Path(folder) / "crop.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)


def render_edges(name: str) -> None:
    """Trunks before the sky: all of it ours, Cycles with light shafts, and their difference four times as bright."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "examples" / "forest_clearing.blend"))
    scene, render = bpy.context.scene, bpy.context.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = *SIZE_PX, 100
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.34, 0.44, 0.44, 0.6
    render.image_settings.file_format, render.image_settings.color_mode = "OPEN_EXR", "RGBA"
    render.image_settings.color_depth = "32"
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 64, 0.0
    scene.cycles.device, scene.cycles.samples = "CPU", 256
    with tempfile.TemporaryDirectory() as folder:
        render.engine = "TYNDALL"
        own = rendered_crop(folder)
        render.engine = "CYCLES"
        bpy.ops.tyndall.over_engine_set_up()
        bpy.ops.tyndall.leave_fog()
        over = rendered_crop(folder)
    difference = np.abs(over - own)[..., :3]
    print(f"{name}: mean {own[..., :3].mean():.4f}, differs by {difference.mean():.4f}, at most {difference.max():.4f}")
    shown = np.ones_like(own)
    shown[..., :3] = 4.0 * difference
    row = np.concatenate([own, over, shown], axis=1).repeat(3, axis=0).repeat(3, axis=1)
    image = bpy.data.images.new(name, row.shape[1], row.shape[0], float_buffer=True)
    image.pixels.foreach_set(np.ascontiguousarray(row).ravel())
    render.image_settings.file_format, render.image_settings.color_mode = "JPEG", "RGB"
    image.save_render(str(ROOT / "docs" / "pictures" / f"{name}.jpg"), scene=scene)


def main() -> None:
    """Render all, or those that are named."""
    wanted = sys.argv[1:] or [EDGES, *(picture.name for picture in PICTURES)]
    tyndall.blender.enable()
    try:
        for picture in PICTURES:
            if picture.name in wanted:
                render(picture)
        if EDGES in wanted:
            render_edges(EDGES)
    finally:
        tyndall.blender.disable()


if __name__ == "__main__":
    main()
