# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the pictures of the guide to light shafts, so that they show what the code does.

scripts/python examples/guide_pictures.py [NAME...]
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy
import numpy as np
from guide_edits import (
    ROOT,
    SIZE_PX,
    add_edit,
    alarm_at_dawn,
    become_voxels,
    colour,
    draft,
    focus,
    hang_a_ring,
    lay_banks,
    let_light_bounce,
    paint_beams,
    paint_one_shaft,
    paint_shafts,
    paint_stage,
    polish_floor,
    show_frame,
    show_pass,
    smoke,
    texture,
    throw_blades,
    throw_cells,
    throw_glass,
    turn_medium,
    use_function,
)
from guide_fire import show_fire
from guide_glass import show_still_life
from guide_patterns import show_patterns
from guide_street import show_street
from guide_voxels import show_ambient_pass, show_courtyard

import tyndall.blender


@dataclass(frozen=True)
class Picture:
    """One of docs/pictures: an example, and what is done to it."""

    name: str
    scene: str  #: "": what is done to it makes the scene.
    edit: Callable[[], object] = lambda: None
    engine: str = "TYNDALL"
    size_px: tuple[int, int] = SIZE_PX


USES = ("REPLACE", "MULTIPLY", "TINT")
PASSES = ("Shafts", "Shafts Visibility", "Transmittance")
WIND = {"wind_m_per_s": (0.6, 0.0, 0.0)}
#: One or both ends of the texture's sliders, beside smoke that lies between.
AIR_ENDS: dict[str, dict[str, float]] = {
    "amount": {"low": 0.5},
    "intensity": {"high": 2.0},
    "scale_m": {"low": 0.25, "high": 2.0},
    "contrast": {"low": 1.0, "high": 4.0},
    "level": {"high": 3.0},
    "octaves": {"low": 1},
    "persistence": {"high": 0.75},
}
#: Of pictures of single controls, three of which stand side by side.
CONTROL_PX = (400, 225)
#: Of two side by side.
FIRE_PX = (480, 360)


def control(name: str, scene: str, edit: Callable[[], object] = lambda: None) -> Picture:
    """What one control does to an example."""
    return Picture(f"control_{name}".replace(" ", "_"), scene, edit, size_px=CONTROL_PX)


CONTROLS = (
    control("hall", "window_hall"),
    control("medium_thin", "window_hall", lambda: turn_medium(density_factor=0.3)),
    control("medium_thick", "window_hall", lambda: turn_medium(density_factor=3.0)),
    control("medium_even", "window_hall", lambda: turn_medium(asymmetry_g=0.0)),
    control("medium_forward", "window_hall", lambda: turn_medium(asymmetry_g=0.8)),
    control("medium_unattenuated", "window_hall", lambda: turn_medium(density_factor=3.0, attenuates=False)),
    control("medium_banks", "stage_spots", lay_banks),
    *(control(f"use_{use.lower()}", "window_hall", partial(use_function, "SUNRISE", use)) for use in USES),
    control("air_even", "stage_spots"),
    control("air", "stage_spots", smoke),
    *(
        control(f"air_{name}_{end}", "stage_spots", partial(smoke, **{name: value}))
        for name, ends in AIR_ENDS.items()
        for end, value in ends.items()
    ),
    control("air_whole_ray", "stage_spots", lambda: smoke(weighting="WHOLE_RAY")),
    *(control(f"air_wind_{frame}", "stage_spots", partial(smoke, frame, **WIND)) for frame in (25, 49)),
    control("paint_intensity", "stage_spots", lambda: paint_stage("INTENSITY", 0.0)),
    control("paint_amount", "stage_spots", lambda: paint_stage("AMOUNT", -1.0)),
    control("paint_level", "stage_spots", lambda: paint_stage("LEVEL", 4.0)),
    *(
        control(f"pass_{name.lower().replace(' ', '_')}", "forest_clearing", partial(show_pass, name))
        for name in PASSES
    ),
)
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
    Picture("gobo_stage_nodes", "stage_spots", throw_cells),
    Picture("fit_hall", "window_hall", paint_shafts),
    Picture("fit_stage", "stage_spots", paint_beams),
    Picture("paint_hall", "window_hall", paint_one_shaft),
    Picture("over_hall_cycles", "window_hall", let_light_bounce, engine="CYCLES"),
    Picture("over_hall_shafts", "window_hall", partial(let_light_bounce, with_shafts=True), engine="CYCLES"),
    Picture("lens_hall_sharp_air", "window_hall", partial(focus, 2.0, 1)),
    Picture("lens_hall", "window_hall", partial(focus, 2.0, 32)),
    Picture("mirror_hall", "window_hall", polish_floor),
    Picture("air_hall_smoke", "window_hall", lambda: texture("Drifting_Smoke", scale_m=4.0)),
    Picture("air_hall_mist", "window_hall", lambda: texture("Mist_Banks")),
    Picture("air_stage_smoke", "stage_spots", lambda: texture("Drifting_Smoke")),
    Picture("glow_hall", "window_hall", hang_a_ring),
    Picture("voxel_village", "village_dawn", partial(become_voxels, 1024)),
    Picture("voxel_courtyard_direct", "", partial(show_courtyard, is_lit_by_others=False)),
    Picture("voxel_courtyard", "", partial(show_courtyard, is_lit_by_others=True)),
    Picture("voxel_courtyard_ao", "", show_ambient_pass),
    Picture("voxel_patterns_mesh", "", partial(show_patterns, are_voxels=False)),
    Picture("voxel_patterns", "", partial(show_patterns, are_voxels=True)),
    Picture("voxel_street", "", show_street),
    Picture("fire", "", show_fire, size_px=FIRE_PX),
    Picture("fire_cycles", "", partial(show_fire, "CYCLES"), size_px=FIRE_PX),
    Picture("glass_straight", "", partial(show_still_life, bends=False)),
    Picture("glass_bent", "", partial(show_still_life, bends=True)),
    Picture("colour_terrain_alarm", "terrain_sunrise", alarm_at_dawn),
    *CONTROLS,
    *(
        Picture(f"colour_sunrise_{frame}", "terrain_sunrise", partial(show_frame, frame))
        for frame in (1, 25, 50, 75, 100)
    ),
)
#: Not a render but a comparison.
EDGES = "over_forest_edges"


def render(picture: Picture) -> None:
    """Write docs/pictures/NAME.jpg."""
    if picture.scene:
        bpy.ops.wm.open_mainfile(filepath=str(ROOT / "examples" / f"{picture.scene}.blend"))
        bpy.context.scene.render.engine = picture.engine
    picture.edit()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = picture.size_px
    if picture in CONTROLS:
        draft()
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
