# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise of many lamps at equal time: ours and Cycles' light tree.

10 and 10,000 point lights over matte surfaces; 33, 1,000 and 10,000 lamps with a size over a floor of metal, for 1,000
as sharp as 0.02 and as broad as 0.3, too. At 0.02 only ours is measured: it blurs a little more than Cycles does.

scripts/python benchmarks/many_lights_bench.py --context FILE --output FILE. Times are the process's CPU time, of a
render less that of the same render with one sample per pixel: what both need for the 10,000 objects. Error: RMS
over pixels of the relative error of a pixel's mean channel, against ours with many samples and another seed
(tests/blender/test_many_lights.py: both engines converge to one picture; Cycles would take half an hour). It falls
with the root of the time, which makes one figure of both: error times root of CPU seconds. Errors are relative to a
pixel's value and a twentieth of the picture's mean, the thousandth of the pixels that is worst left out.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from timed_render import timed_pixels

import tyndall.blender
from report import Row, argument_parser, row, write_report

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.cycles_reference import _prepare_tyndall, prepare_cycles
from support.many_light_scenes import build_lit_by, plates_over_gloss

SIZE_PX = 96, 54
REFERENCE_SAMPLES = 1024
FLOOR_SHARE, TRIMMED_SHARE = 0.05, 0.001
ENGINES = ("tyndall", "cycles")


@dataclass(frozen=True)
class Case:
    """What lights the room, and how many samples each engine takes of it."""

    lights: str | Callable[[], None]
    tyndall: int = 64
    cycles: int = 16
    engines: tuple[str, ...] = ENGINES


CASES = {
    "10 points": Case("10 points"),
    "10000 points": Case("10000 points"),
    "33 over gloss 0.1": Case(lambda: plates_over_gloss(33, 0.1)),
    "1000 over gloss 0.02": Case(lambda: plates_over_gloss(1000, 0.02), engines=("tyndall",)),
    "1000 over gloss 0.1": Case(lambda: plates_over_gloss(1000, 0.1)),
    "1000 over gloss 0.3": Case(lambda: plates_over_gloss(1000, 0.3)),
    "10000 over gloss 0.1": Case(lambda: plates_over_gloss(10_000, 0.1), cycles=4),
}


def _prepare(scene: bpy.types.Scene, engine: str, samples: int, seed: int) -> None:
    if engine == "cycles":
        prepare_cycles(scene, samples, seed)
        scene.cycles.use_light_tree = True
    else:
        _prepare_tyndall(scene, samples, seed)


def measured(scene: bpy.types.Scene, engine: str, samples: int, seed: int) -> tuple[np.ndarray, float]:
    """Render; the picture and the CPU seconds."""
    _prepare(scene, engine, samples, seed)
    return timed_pixels(scene)


def run(names: list[str]) -> list[Row]:
    """Measure both engines under the lights of each case."""
    rows = []
    for name in names or CASES:
        case = CASES[name]
        scene = build_lit_by(case.lights, *SIZE_PX)
        reference, _ = measured(scene, "tyndall", REFERENCE_SAMPLES, 99)
        level = reference.mean(axis=2)
        for engine in case.engines:
            samples: int = getattr(case, engine)
            # What reading the objects takes differs from run to run by as much as a few samples do.
            of_setup_s = min(measured(scene, engine, 1, 1)[1] for _ in range(2))
            picture, all_s = measured(scene, engine, samples, 1)
            cpu_s = max(all_s - of_setup_s, 1e-3) * samples / (samples - 1)
            squared = ((picture.mean(axis=2) - level) / (level + FLOOR_SHARE * level.mean())) ** 2
            rms = float(np.sqrt(squared[squared <= np.quantile(squared, 1.0 - TRIMMED_SHARE)].mean()))
            rows.append(
                row(
                    f"{name}, {engine}",
                    cpu_s,
                    samples=samples,
                    setup_cpu_s=of_setup_s,
                    rms_error=rms,
                    error_times_root_s=rms * cpu_s**0.5,
                    mean_beside_reference=float(picture.mean() / reference.mean() - 1.0),
                )
            )
            print(rows[-1], flush=True)
    return rows


if __name__ == "__main__":
    parser = argument_parser(__doc__)
    parser.add_argument("cases", nargs="*", help="names of cases; all without any")
    arguments = parser.parse_args()
    tyndall.blender.enable()
    write_report(run(arguments.cases), arguments)
