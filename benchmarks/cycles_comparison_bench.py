# SPDX-License-Identifier: GPL-3.0-or-later
"""The race: whole renders of the examples to the error that Cycles reaches at 256 and at 4,096 samples.

scripts/python benchmarks/cycles_comparison_bench.py --context FILE --output FILE [--cycles-samples FEW MANY] [SCENE...]
Both engines render direct light and single scattering at 960x540 through the same pixel filter; the time is that of
Blender's render operator, from the press of F12 to the file. Errors are relative, per pixel and channel, against the
converged picture: of two renders A and B of Cycles with different seeds, mean((ours - A)(ours - B)) is our squared
error without their noise, and mean((A - B)^2) twice theirs. Cycles' error at other numbers of samples follows the
slope that the two numbers of the same run fit, its time their proportion; such rows say "scaled". The thousandth of the
pixels that is worst is left out on both sides, as is common for relative errors (pixels at a lamp's very centre, and
fireflies, would decide alone); rel_error_of_all has them.
"""

from __future__ import annotations

import math
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

import tyndall.blender
from report import Row, argument_parser, row, write_report

ROOT = Path(__file__).resolve().parent.parent
SCENES = ("window_hall", "stage_spots", "forest_clearing")
TARGET_SAMPLES = (256, 4096)
#: Errors are relative to a pixel's value plus this share of the picture's mean: black pixels have no relative error.
FLOOR_SHARE = 0.01


@dataclass(frozen=True)
class Setting:
    """What a Tyndall user would turn: a row of the ladder from draft to final."""

    samples: int
    error_target: float
    noise_threshold: float = 0.0
    repetitions: int = 3

    @property
    def name(self) -> str:
        """Short enough for a plot."""
        return f"{self.samples} samples, {100 * self.error_target:g} %"


LADDER = (
    Setting(1, 0.1),
    Setting(1, 0.05),
    Setting(1, 0.03),
    Setting(1, 0.01),
    Setting(2, 0.05),
    Setting(2, 0.02),
    Setting(4, 0.05),
    Setting(4, 0.01),
    Setting(8, 0.01, 0.01, repetitions=1),
    Setting(16, 0.01, 0.005, repetitions=1),
    Setting(32, 0.005, 0.003, repetitions=1),
)
#: Of the pixels: how many of the worst are left out.
TRIMMED_SHARE = 0.001

Picture = NDArray[np.float64]


def rendered(scene: bpy.types.Scene) -> tuple[Picture, float]:
    """Render as F12 does; the picture, scene-linear (height, width, 3), and the seconds that it took."""
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame.exr")
        start = time.perf_counter()
        bpy.ops.render.render(write_still=True)
        seconds = time.perf_counter() - start
        image = bpy.data.images.load(scene.render.filepath)
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        channels = image.channels
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, channels)[..., :3].astype(np.float64), seconds


def open_scene(name: str) -> bpy.types.Scene:
    """Open an example as both engines render it."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "examples" / f"{name}.blend"))
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 960, 540, 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode = "RGB"
    scene.tyndall.pixel_filter = scene.cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    scene.tyndall.filter_width_px = scene.cycles.filter_width = 1.5
    return scene


def cycles_render(scene: bpy.types.Scene, samples: int, seed: int) -> tuple[Picture, float]:
    """Direct light and single scattering, every sample taken."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed = "CPU", samples, seed
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 0
    cycles.transmission_bounces = cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 1024
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    picture, seconds = rendered(scene)
    print(f"Cycles, {samples} samples: {seconds:.1f} s", flush=True)
    return picture, seconds


def tyndall_render(scene: bpy.types.Scene, setting: Setting) -> tuple[Picture, float]:
    """The median time of a few renders."""
    scene.render.engine = "TYNDALL"
    ours, shafts = scene.tyndall, scene.tyndall.shafts
    ours.pixel_samples, ours.noise_threshold = setting.samples, setting.noise_threshold
    shafts.method, shafts.resolution, shafts.error_target = "EPIPOLAR", 0, setting.error_target
    shafts.light_samples, shafts.world_samples, shafts.adapts_strata = 64, 256, True
    renders = [rendered(scene) for _ in range(setting.repetitions)]
    return renders[0][0], statistics.median(seconds for _, seconds in renders)


def root(squared_error: float) -> float:
    """Of an estimate that chance may bring below 0."""
    return math.sqrt(max(squared_error, 0.0))


def trimmed_mean(squared: Picture, badness: Picture) -> float:
    """Mean of squared errors (height, width, 3) over all but the worst pixels by another measure of the same shape."""
    of_pixel = badness.sum(axis=2)
    return float(squared[of_pixel <= np.quantile(of_pixel, 1.0 - TRIMMED_SHARE)].mean())


def first_time(ladder: list[tuple[float, float]], error: float) -> float | None:
    """Time at which the ladder of (seconds, error) has come down to an error; between rungs by their powers.

    None: it never does.
    """
    best: list[tuple[float, float]] = []
    for seconds, at in sorted(ladder):
        if at <= error:
            if not best:
                return seconds
            (t0, e0), (t1, e1) = best[-1], (seconds, at)
            share = math.log(e0 / error) / math.log(e0 / e1)
            return t0 * (t1 / t0) ** share
        if not best or at < best[-1][1]:
            best.append((seconds, at))
    return None


def compare(name: str, few: int, many: int) -> list[Row]:
    """Rows of one scene."""
    scene = open_scene(name)
    ours = [(setting, *tyndall_render(scene, setting)) for setting in LADDER]
    a, few_seconds = cycles_render(scene, few, seed=1)
    b, _ = cycles_render(scene, few, seed=2)
    c, many_seconds = cycles_render(scene, many, seed=3)
    finest = ours[-1][1]
    weight = 1.0 / (finest + FLOOR_SHARE * finest.mean()) ** 2
    few_squared, mixed_squared = weight * (a - b) ** 2, weight * (a - c) ** 2
    few_variance = trimmed_mean(few_squared, few_squared) / 2
    many_variance = trimmed_mean(mixed_squared, mixed_squared) - few_variance
    slope = math.log(few_variance / many_variance) / math.log(many / few)
    rows = [
        row(f"{name}, Cycles/{few} samples", few_seconds, rel_error=root(few_variance)),
        row(f"{name}, Cycles/{many} samples", many_seconds, rel_error=root(many_variance), variance_slope=slope),
    ]
    ladder = []
    for setting, picture, seconds in ours:
        squared = weight * (picture - (a + b) / 2) * (picture - c)
        error = root(trimmed_mean(squared, weight * (picture - finest) ** 2))
        bias = float(picture.mean() / ((a + b + c) / 3).mean()) - 1.0
        if error > 0.0:
            ladder.append((seconds, error))
        rows.append(
            row(
                f"{name}, Tyndall/{setting.name}",
                seconds,
                rel_error=error,
                rel_error_of_all=root(float(squared.mean())),
                bias_of_mean=bias,
            )
        )
        print(rows[-1], flush=True)
    for samples in TARGET_SAMPLES:
        error = root(many_variance * (many / samples) ** slope)
        cycles_seconds = many_seconds * samples / many
        ours_seconds = first_time(ladder, error)
        rows.append(
            row(
                f"{name}: to the error of Cycles at {samples}",
                cycles_seconds,
                target=error,
                scaled=samples != many,
                tyndall_seconds=ours_seconds or 0.0,
                times_faster=cycles_seconds / ours_seconds if ours_seconds else 0.0,
            )
        )
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Compare the examples and write the report."""
    parser = argument_parser(__doc__)
    parser.add_argument("--cycles-samples", type=int, nargs=2, default=(256, 1024), metavar=("FEW", "MANY"))
    parser.add_argument("scenes", nargs="*", default=SCENES)
    arguments = parser.parse_args(sys.argv[1:])
    tyndall.blender.enable()
    try:
        rows = [line for name in arguments.scenes for line in compare(name, *arguments.cycles_samples)]
    finally:
        tyndall.blender.disable()
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
