# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the gallery, before and after, so that it shows what the code does; prints how long each picture took.

scripts/python examples/gallery.py [NAME...]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy

import tyndall.blender

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "gallery"
SIZE_PX = (960, 540)
PIXEL_SAMPLES = 12


def edits() -> Iterator[bpy.types.PropertyGroup]:
    """Of the occluders before all lights."""
    for thing in bpy.context.scene.objects:
        if thing.type == "LIGHT":
            yield from thing.data.tyndall.occluder_edits


def as_it_is() -> None:
    """Physical shafts in even air: every edit of theirs is off, nothing recolours them."""
    bpy.context.scene.tyndall.shafts.use_transfer_functions = False
    bpy.context.scene.tyndall.heterogeneity.is_enabled = False
    for edit in edits():
        edit.is_enabled = False
    for light in bpy.data.lights:
        light.tyndall.gobo_strength = 0.0


def as_saved() -> None:
    """What the file holds is the picture."""


def without_functions() -> None:
    """Occluders as edited, colours as they are."""
    bpy.context.scene.tyndall.shafts.use_transfer_functions = False


def without_paint() -> None:
    """The texture of the air as the sliders have it."""
    bpy.context.scene.tyndall.heterogeneity.painted = None


def show_state(index: int) -> None:
    """One of the scene's transfer functions alone."""
    bpy.context.scene.tyndall.shafts.transfer_state = index


def show_frame(frame: int) -> None:
    """Go to a frame of an animated example."""
    bpy.context.scene.frame_set(frame)


def look_through(camera: str) -> None:
    """Render what another camera sees."""
    bpy.context.scene.camera = bpy.data.objects[camera]


def physical_dawn() -> None:
    """The frame in which the terrain lends itself to another style, without any."""
    as_it_is()
    bpy.context.scene.frame_set(STYLE_FRAME)


def posterise() -> None:
    """Replace a scene's own style by one function that is the same in all."""
    physical_dawn()
    shafts = bpy.context.scene.tyndall.shafts
    shafts.transfer_states.clear()
    shafts.use_transfer_functions = True
    bpy.ops.tyndall.transfer_function_preset(preset="ALARM")
    shafts.transfer_states[0].function.tyndall.strength = STYLE_STRENGTH


#: Names of the pictures, and of the cameras.
CITADEL_VIEWS = (("road", "From the Road"), ("east", "From the East"), ("west", "From the West"))
STYLE_FRAME = 25  #: The sun stands behind the terrain's peaks there.
STYLE_STRENGTH = 1.0  #: The preset's is for the glare of a hall; these scenes are exposed for dusk.


@dataclass(frozen=True)
class Picture:
    """One of docs/gallery: an example, and what is done to it."""

    name: str
    scene: str
    show: Callable[[], None] = as_saved


PICTURES = (
    Picture("palm_tree_before", "palm_tree", as_it_is),
    Picture("palm_tree", "palm_tree"),
    Picture("scarecrow_before", "scarecrow", as_it_is),
    Picture("scarecrow", "scarecrow"),
    Picture("turtle_before", "turtle", as_it_is),
    Picture("turtle_filled", "turtle", without_functions),
    Picture("turtle_lifted", "turtle", partial(show_state, 0)),
    Picture("turtle", "turtle"),
    Picture("flower_bed_before", "flower_bed", as_it_is),
    *(Picture(f"flower_bed_{frame}", "flower_bed", partial(show_frame, frame)) for frame in (1, 5, 9)),
    Picture("citadel_before", "citadel", as_it_is),
    *(Picture(f"citadel_{name}", "citadel", partial(look_through, camera)) for name, camera in CITADEL_VIEWS),
    Picture("skeleton_hall_before", "skeleton_hall", as_it_is),
    Picture("skeleton_hall_textured", "skeleton_hall", without_paint),
    Picture("skeleton_hall", "skeleton_hall"),
    Picture("arbor_before", "arbor", as_it_is),
    Picture("arbor", "arbor"),
    Picture("village_dawn_before", "village_dawn", as_it_is),
    Picture("village_dawn", "village_dawn"),
    Picture("terrain_sunrise_before", "terrain_sunrise", physical_dawn),
    *(Picture(f"style_{scene}", scene, posterise) for scene in ("terrain_sunrise", "palm_tree", "scarecrow")),
)


def set_up_render(size_px: tuple[int, int], pixel_samples: int) -> None:
    """What all pictures share."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y = size_px
    scene.render.resolution_percentage = 100
    scene.tyndall.pixel_samples = pixel_samples
    scene.render.use_stamp_filename = False  # a picture does not say where its scene lay
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "JPEG", 90


def render(picture: Picture) -> None:
    """Write docs/gallery/NAME.jpg."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "examples" / f"{picture.scene}.blend"))
    set_up_render(SIZE_PX, PIXEL_SAMPLES)
    picture.show()
    bpy.context.scene.render.filepath = str(FOLDER / f"{picture.name}.jpg")
    begin = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    print(f"{picture.name}: {time.perf_counter() - begin:.1f} s", flush=True)


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
