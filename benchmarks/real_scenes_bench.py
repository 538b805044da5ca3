# SPDX-License-Identifier: GPL-3.0-or-later
"""Real scenes of other people: ours beside Cycles, their difference, and what of it has a name; one row per scene.

scripts/python benchmarks/real_scenes_bench.py --context FILE --output FILE [--docs FOLDER] [SCENE...]
Both engines render direct light and emission alone, through a filter one pixel wide. The mean is that of the whole
picture; blocks are 8 x 8 pixels, their errors relative to Cycles' own, no less than a thousandth of its mean; Cycles'
noise is measured by two renders of different seeds. Times are of the processor, of whole renders, at the samples that
the row names: Cycles draws one light per sample, ours asks all. With --docs, writes real-scenes.md and its pictures.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray
from PIL import Image

import tyndall.blender
from report import Row, argument_parser, row, write_page, write_report

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "tests"))

from support.cycles_reference import block_means, prepare_cycles, rendered_pixels  # noqa: E402  its path is set above
from support.real_scenes import REAL_SCENES, RealScene  # noqa: E402

WIDTH_PX, BLOCK_PX = 320, 8
OUR_SAMPLES, CYCLES_SAMPLES = 128, 256
FLOOR_SHARE = 1e-3  #: Of the picture's mean: what is darker counts as so dark.
DIFFERENCE_GAIN = 10
LEAST_NOISE = 1e-4

Picture = NDArray[np.float64]


def ours(scene: bpy.types.Scene, seed: int) -> tuple[Picture, float]:
    """Direct light, every sample taken; the picture and the seconds of processor."""
    scene.render.engine = "TYNDALL"
    settings = scene.tyndall
    settings.pixel_samples, settings.noise_threshold, settings.seed = OUR_SAMPLES, 0.0, seed
    settings.pixel_filter, settings.filter_width_px = "BOX", 1.0
    start = time.process_time()
    return rendered_pixels(scene), time.process_time() - start


def of_cycles(scene: bpy.types.Scene, seed: int) -> tuple[Picture, float]:
    """The same light."""
    prepare_cycles(scene, CYCLES_SAMPLES, seed)
    scene.cycles.pixel_filter_type = "BOX"
    if hasattr(scene.cycles, "use_light_tree"):
        scene.cycles.use_light_tree = True
    start = time.process_time()
    return rendered_pixels(scene), time.process_time() - start


def reports_of(scene: bpy.types.Scene) -> list[str]:
    """What our render said that it left out."""
    last = sys.modules[type(scene.tyndall).__module__.rpartition(".properties")[0] + ".last_render"]
    statistics = last.statistics_of(scene.name) or {}
    return sorted(str(text) for text in statistics.get("reports", ()))


def encoded(picture: Picture, level: float) -> NDArray[np.uint8]:
    """For eyes, rows top to bottom."""
    shown: NDArray[np.uint8] = (255 * np.clip(picture[::-1] / level, 0, 1) ** (1 / 2.2) + 0.5).astype(np.uint8)
    return shown


def side_by_side(mine: Picture, reference: Picture) -> Image.Image:
    """Ours, Cycles', and their difference, ten times: red where ours is brighter, blue where darker."""
    level = max(float(np.percentile(reference, 99)), 1e-9)
    signed = (mine - reference).mean(axis=2) * DIFFERENCE_GAIN
    difference = np.stack([signed, np.zeros_like(signed), -signed], axis=2)
    return Image.fromarray(np.concatenate([encoded(each, level) for each in (mine, reference, difference)], axis=1))


def compare(real: RealScene, pictures: Path | None) -> tuple[Row, list[str]]:
    """One row, and what ours reported."""
    scene = real.open(WIDTH_PX)
    (own_first, own_seconds), (own_second, _) = ours(scene, 1), ours(scene, 2)
    reports = reports_of(scene)
    (first, seconds), (second, _) = of_cycles(scene, 1), of_cycles(scene, 2)
    mine, reference = (own_first + own_second) / 2, (first + second) / 2
    blocks = block_means(reference, BLOCK_PX)
    scale = np.maximum(blocks, FLOOR_SHARE * blocks.mean())
    error = np.abs(block_means(mine, BLOCK_PX) - blocks) / scale

    def noise(one: Picture, other: Picture) -> float:
        """Of a block of one render, of both of which the difference is."""
        return float(np.median(np.abs(block_means(one, BLOCK_PX) - block_means(other, BLOCK_PX)) / scale)) / np.sqrt(2)

    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        side_by_side(mine, reference).save(pictures / f"{real.name}.jpg", quality=88)
    found = row(
        real.name,
        own_seconds,
        cycles_seconds=seconds,
        our_samples=OUR_SAMPLES,
        cycles_samples=CYCLES_SAMPLES,
        mean_error=float(mine.sum() / reference.sum() - 1),
        median_block=float(np.median(error)),
        own_noise=noise(own_first, own_second),
        median_noise=noise(first, second),
        block_90=float(np.percentile(error, 90)),
    )
    print(real.name, found, flush=True)
    return found, reports


HEADER = """# Real scenes
Files that other people made, with their oddities; none was made for Tyndall. Direct light and emission alone, in
Blender {blender}, {width} pixels wide, a filter of one pixel: ours at {ours} samples, Cycles at {cycles} and 0 bounces,
each twice, with another seed: their means are compared; noise and time are those of one, of the median block of 8 x 8
pixels. The last column is the ratio of time times variance: how many times faster ours is at equal noise.
`scripts/bench.sh real_scenes_bench` makes this page anew where `../shared/data/blend` lies beside the repository; each
row of pictures is ours, Cycles', and ten times their difference, red where ours is brighter.

| scene | mean | median block | 9 of 10 blocks | noise, ours / Cycles | processor, ours / Cycles | equal noise |
|---|---|---|---|---|---|---|
"""


def _times_faster(own_noise: float, noise: float, own_seconds: float, seconds: float) -> str:
    """Where there is noise to speak of."""
    if min(own_noise, noise) < LEAST_NOISE:
        return "-"
    return f"{noise**2 * seconds / (own_noise**2 * own_seconds):.1f}"


def page(compared: list[tuple[RealScene, Row, list[str]]]) -> str:
    """docs/real-scenes.md."""
    text = HEADER.format(blender=bpy.app.version_string, width=WIDTH_PX, ours=OUR_SAMPLES, cycles=CYCLES_SAMPLES)
    for real, found, _ in compared:
        names = ("mean_error", "median_block", "block_90", "own_noise", "median_noise", "real_time", "cycles_seconds")
        mean, median, most, own_noise, noise, own_seconds, seconds = (float(found[name]) for name in names)
        text += f"| {real.name} | {mean:+.2%} | {median:.2%} | {most:.1%} | {own_noise:.2%} / {noise:.2%} "
        text += f"| {own_seconds:.1f} / {seconds:.1f} s | {_times_faster(own_noise, noise, own_seconds, seconds)} |\n"
    for real, _, reports in compared:
        text += f"\n## {real.name}\n![{real.name}: ours, Cycles, difference](pictures/real_scenes/{real.name}.jpg)\n\n"
        text += f"{real.credit}; rendered {real.changes}.{' ' + real.differences if real.differences else ''}\n"
        if reports:
            text += "\nReported by the render:\n" + "".join(f"- {line}\n" for line in reports)
    return text


def main() -> None:
    """Of all scenes, or of those named."""
    parser = argument_parser(__doc__, has_page=True)
    parser.add_argument("scenes", nargs="*")
    arguments = parser.parse_args()
    tyndall.blender.enable()
    compared = []
    for real in REAL_SCENES:
        if arguments.scenes and real.name not in arguments.scenes:
            continue
        if real.found() is None:
            print(f"{real.name}: ../shared/data/blend/{real.path} is not there, left out", flush=True)
            continue
        found, reports = compare(real, arguments.docs / "pictures/real_scenes" if arguments.docs else None)
        compared.append((real, found, reports))
    write_report([found for _, found, _ in compared], arguments)
    if compared:
        write_page("real-scenes.md", page(compared), arguments)


if __name__ == "__main__":
    main()
