# SPDX-License-Identifier: GPL-3.0-or-later
"""The race on surfaces: full HD, 16 samples, direct light alone, against Cycles doing the same in the same run.

scripts/python benchmarks/surfaces_race_bench.py --context FILE --output FILE [--docs FOLDER] [--width PX] [SCENE...]
Times are medians of whole renders, from the press of F12 to the file, the engines by turns, a seed for each render: by
the clock, and of the processor, which other work beside it changes less.
Noise needs no converged picture: of two renders A and B with different seeds mean((A - B)^2) is twice the variance of
one. It is relative, per pixel and channel, to the mean of all renders of both engines, and leaves out the thousandth
of the pixels that is worst in each. Whether both draw the same light the ratio of their means says. Cycles draws one
light per sample, ours asks all; "at equal noise" divides times by what that bought: the ratio of time times variance.
Without names: all scenes; those of other people only where ../shared/data/blend lies beside the repository.
"""

from __future__ import annotations

import itertools
import math
import os
import resource
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

import tyndall.blender
from report import Row, argument_parser, row, write_page, write_report

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "tests"))

from support.cycles_reference import prepare_cycles, rendered_pixels  # noqa: E402  its path is set above
from support.real_scenes import REAL_SCENES  # noqa: E402

WIDTH_PX, HEIGHT_PX, SAMPLES = 1920, 1080, 16
#: An odd number: the median is one that was measured.
SEEDS = (1, 2, 3)
REAL_NAMES = ("bedroom", "scene", "vr_dino", "race_track")
#: Errors are relative to a pixel's value plus this share of the picture's mean: black pixels have no relative error.
FLOOR_SHARE = 0.01
TRIMMED_SHARE = 0.001

Picture = NDArray[np.float64]


def _material(name: str, colour: tuple[float, float, float], roughness: float, metallic: float) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value, shader.inputs["Metallic"].default_value = roughness, metallic
    return material


def _heads() -> bpy.types.Scene:
    """Two dozen subdivided heads of four materials on a floor, before a camera, at full HD; no light yet."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH_PX, HEIGHT_PX, 100
    bpy.ops.mesh.primitive_plane_add(size=60.0)
    bpy.context.object.data.materials.append(_material("floor", (0.5, 0.5, 0.5), 0.9, 0.0))
    kinds = [
        _material("clay", (0.7, 0.3, 0.2), 0.8, 0.0),
        _material("plastic", (0.1, 0.4, 0.7), 0.4, 0.0),
        _material("steel", (0.7, 0.7, 0.7), 0.35, 1.0),
        _material("leaf", (0.2, 0.5, 0.1), 0.6, 0.0),
    ]
    for column in range(6):
        for line in range(4):
            bpy.ops.mesh.primitive_monkey_add(
                size=1.6, location=(2.2 * column - 5.5, 2.4 * line - 3.0, 0.9), rotation=(-0.4, 0.0, 0.3 * column - 0.8)
            )
            bpy.ops.object.shade_smooth()
            head = bpy.context.object
            head.modifiers.new("smooth", "SUBSURF").render_levels = 2
            head.data.materials.append(kinds[(column + line) % len(kinds)])
    bpy.ops.object.camera_add(location=(0.0, -13.0, 6.5), rotation=(math.radians(64.0), 0.0, 0.0))
    scene.camera = bpy.context.object
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    return scene


def _lamp(kind: str, energy: float, place: tuple[float, float, float], size: float) -> None:
    bpy.ops.object.light_add(type=kind, location=place)
    lamp = bpy.context.object
    lamp.data.energy = energy
    lamp.rotation_euler = (-lamp.location).to_track_quat("-Z", "Y").to_euler()
    if kind == "AREA":
        lamp.data.size = size
    elif kind == "SUN":
        lamp.data.angle = size
    else:
        lamp.data.shadow_soft_size = size


def heads_in_sun() -> bpy.types.Scene:
    """One sun as wide as the real one."""
    scene = _heads()
    _lamp("SUN", 3.0, (4.0, -6.0, 8.0), math.radians(0.53))
    return scene


def heads_by_lamps() -> bpy.types.Scene:
    """Two area lights, two points and a spot."""
    scene = _heads()
    _lamp("AREA", 900.0, (-6.0, -6.0, 6.0), 2.0)
    _lamp("AREA", 600.0, (7.0, 2.0, 5.0), 1.0)
    _lamp("POINT", 300.0, (-2.0, 6.0, 4.0), 0.2)
    _lamp("POINT", 200.0, (2.0, -5.0, 3.0), 0.1)
    _lamp("SPOT", 1500.0, (0.0, 0.0, 9.0), 0.3)
    return scene


def heads_under_sky() -> bpy.types.Scene:
    """A picture of a sky, 1024 x 512: blue, white low down, with a bright cloud."""
    scene = _heads()
    width, height = 1024, 512
    across, up = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    cloud = 20.0 * np.exp(-(((across - 0.3) / 0.02) ** 2 + ((up - 0.75) / 0.03) ** 2))
    low = np.exp(-(((up - 0.5) / 0.15) ** 2))
    above = np.arange(height)[:, np.newaxis] >= height // 2
    pixels = np.ones((height, width, 4), np.float32)
    for channel, (zenith, horizon) in enumerate(((0.2, 0.8), (0.4, 0.9), (0.9, 1.0))):
        pixels[..., channel] = np.where(above, zenith + (horizon - zenith) * low, 0.1) + cloud
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    return scene


MADE: dict[str, Callable[[], bpy.types.Scene]] = {
    made.__name__: made for made in (heads_in_sun, heads_by_lamps, heads_under_sky)
}


def of_ours(scene: bpy.types.Scene, seed: int) -> None:
    """Every sample taken, as Cycles does."""
    scene.render.engine = "TYNDALL"
    settings = scene.tyndall
    settings.pixel_samples, settings.seed, settings.noise_threshold = SAMPLES, seed, 0.0
    settings.pixel_filter, settings.filter_width_px = "BOX", 1.0


def of_cycles(scene: bpy.types.Scene, seed: int) -> None:
    """The same light, with the light tree where this version has one."""
    prepare_cycles(scene, SAMPLES, seed)
    scene.cycles.pixel_filter_type = "BOX"
    if hasattr(scene.cycles, "use_light_tree"):
        scene.cycles.use_light_tree = True


@dataclass(frozen=True)
class Render:
    """What it shows, and what it took."""

    picture: Picture
    seconds: float
    processor_s: float


def timed(scene: bpy.types.Scene) -> Render:
    """One render."""
    start, processor = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF).ru_utime
    picture = rendered_pixels(scene)
    of_processor = resource.getrusage(resource.RUSAGE_SELF).ru_utime - processor
    return Render(picture, time.perf_counter() - start, of_processor)


def relative_variance(pictures: list[Picture], weight: Picture) -> float:
    """Of one render, by its neighbours in seed; without the worst pixels."""
    pairs = itertools.pairwise(pictures)
    squared = sum(((a - b) ** 2 for a, b in pairs), np.zeros_like(weight)) / (2 * (len(pictures) - 1)) * weight
    of_pixel = squared.sum(axis=2)
    return float(squared[of_pixel <= np.quantile(of_pixel, 1.0 - TRIMMED_SHARE)].mean())


def compare(name: str, scene: bpy.types.Scene) -> Row:
    """One row."""
    ours: list[Render] = []
    theirs: list[Render] = []
    for seed in SEEDS:
        for engine, renders in ((of_ours, ours), (of_cycles, theirs)):
            engine(scene, seed)
            renders.append(timed(scene))
    mean: Picture = np.mean([render.picture for render in ours + theirs], axis=0)
    weight = 1.0 / (mean + FLOOR_SHARE * mean.mean()) ** 2
    seconds, of_cycles_s = (statistics.median(render.seconds for render in renders) for renders in (ours, theirs))
    processor_s, of_cycles_processor_s = (
        statistics.median(render.processor_s for render in renders) for renders in (ours, theirs)
    )
    own, other = (relative_variance([render.picture for render in renders], weight) for renders in (ours, theirs))
    means = [float(np.mean([render.picture.mean() for render in renders])) for renders in (ours, theirs)]
    found = row(
        name,
        seconds,
        cycles_seconds=of_cycles_s,
        processor_seconds=processor_s,
        cycles_processor_seconds=of_cycles_processor_s,
        times_faster=of_cycles_processor_s / processor_s,
        rel_noise=math.sqrt(own),
        cycles_rel_noise=math.sqrt(other),
        times_faster_at_equal_noise=of_cycles_processor_s * other / (processor_s * own) if own > 0.0 else 0.0,
        mean_against_cycles=means[0] / means[1] - 1.0,
    )
    print(found, flush=True)
    return found


HEADER = """# The race on surfaces
{size}, {samples} samples, direct light alone, in Blender {blender}: whole renders from the press of F12 to the
file, medians of {seeds}, the engines by turns; Cycles at 0 bounces, with its light tree. Times are the processor's and,
in brackets, the clock's{beside}; "times faster" compares the processor's.
Noise is that of one render, relative to each pixel, measured between seeds. Cycles draws one light per sample, ours
asks lamps each, weak ones by turns, and the world with as many rays as its noise is worth; the last column is the ratio
of time times variance, what a picture of the same noise costs. `scripts/bench.sh surfaces_race_bench` makes this page
anew at full HD; scenes of other people are rendered where `../shared/data/blend` lies beside the repository.

| scene | ours | Cycles | times faster | noise, ours / Cycles | mean | times faster at equal noise |
|---|---|---|---|---|---|---|
"""
#: Processes that want the processors, per processor: more than this is other work, which the page then names.
CALM_LOAD = 1.3


def page(rows: list[Row], width_px: int, load: float) -> str:
    """docs/surfaces-race.md."""
    size = "Full HD" if width_px == WIDTH_PX else f"{width_px} x {width_px * HEIGHT_PX // WIDTH_PX} pixels"
    beside = f", beside other work (a load of {load:.1f} a processor)" if load > CALM_LOAD else ""
    text = HEADER.format(size=size, samples=SAMPLES, blender=bpy.app.version_string, seeds=len(SEEDS), beside=beside)
    for found in rows:
        text += f"| {found['name']} | {found['processor_seconds']:.1f} s ({found['real_time']:.1f}) "
        text += f"| {found['cycles_processor_seconds']:.1f} s ({found['cycles_seconds']:.1f}) "
        text += f"| {found['times_faster']:.2f} | {found['rel_noise']:.1%} / {found['cycles_rel_noise']:.1%} "
        text += f"| {found['mean_against_cycles']:+.2%} | {found['times_faster_at_equal_noise']:.2f} |\n"
    return text


def main() -> None:
    """Of all scenes, or of those named."""
    parser = argument_parser(__doc__, has_page=True)
    parser.add_argument("scenes", nargs="*", default=(*MADE, *REAL_NAMES))
    parser.add_argument("--width", type=int, default=WIDTH_PX, help="of the pictures, in pixels")
    arguments = parser.parse_args()
    real = {each.name: each for each in REAL_SCENES}
    if unknown := [name for name in arguments.scenes if name not in MADE and name not in real]:
        parser.error(f"there is no scene named {', '.join(unknown)}")
    tyndall.blender.enable()
    rows = []
    for name in arguments.scenes:
        if name in MADE:
            scene = MADE[name]()
            scene.render.resolution_x = arguments.width
            scene.render.resolution_y = arguments.width * HEIGHT_PX // WIDTH_PX
            rows.append(compare(name, scene))
        elif real[name].found() is None:
            print(f"{name}: ../shared/data/blend/{real[name].path} is not there, left out", flush=True)
        else:
            rows.append(compare(name, real[name].open(arguments.width)))
    write_report(rows, arguments)
    load = os.getloadavg()[1] / (os.cpu_count() or 1)
    write_page("surfaces-race.md", page(rows, arguments.width, load), arguments)


if __name__ == "__main__":
    main()
