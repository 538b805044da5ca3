# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise of 10,000 point lights at equal time: ours and Cycles' light tree, and what they cost beside 10.

scripts/python benchmarks/many_lights_bench.py --context FILE --output FILE. Times are the process's CPU time, of a
render less that of the same render with one sample per pixel: what both need for the 10,000 objects. Error: RMS
over pixels of the relative error of a pixel's mean channel, against ours with many samples and another seed
(tests/blender/test_many_lights.py: both engines converge to one picture; Cycles would take half an hour). It falls
with the root of the time, which makes one figure of both: error times root of CPU seconds.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import bpy
import numpy as np

import tyndall.blender
from report import Row, argument_parser, row, write_report

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.cycles_reference import _prepare_tyndall, prepare_cycles, rendered_pixels
from support.many_light_scenes import build_lit_by

SIZE_PX = 96, 54
REFERENCE_SAMPLES = 1024
SAMPLES = {"cycles": 16, "tyndall": 64}


def _prepare(scene: bpy.types.Scene, engine: str, samples: int, seed: int) -> None:
    if engine == "cycles":
        prepare_cycles(scene, samples, seed)
        scene.cycles.use_light_tree = True
    else:
        _prepare_tyndall(scene, samples, seed)


def measured(scene: bpy.types.Scene, engine: str, samples: int, seed: int) -> tuple[np.ndarray, float]:
    """Render; the picture and the CPU seconds."""
    _prepare(scene, engine, samples, seed)
    begin = time.process_time()
    picture = rendered_pixels(scene)
    return picture, time.process_time() - begin


def run() -> list[Row]:
    """Measure both engines with 10 and with 10,000 lights."""
    rows = []
    for lights in ("10 points", "10000 points"):
        scene = build_lit_by(lights, *SIZE_PX)
        reference, _ = measured(scene, "tyndall", REFERENCE_SAMPLES, 99)
        level = reference.mean(axis=2)
        is_lit = level > 0.01 * level.mean()
        for engine, samples in SAMPLES.items():
            _, of_setup_s = measured(scene, engine, 1, 1)
            picture, all_s = measured(scene, engine, samples, 1)
            cpu_s = max(all_s - of_setup_s, 1e-3) * samples / (samples - 1)
            error = (picture.mean(axis=2) - level)[is_lit] / level[is_lit]
            rms = float(np.sqrt((error**2).mean()))
            rows.append(
                row(
                    f"{lights}, {engine}",
                    cpu_s,
                    samples=samples,
                    setup_cpu_s=of_setup_s,
                    rms_error=rms,
                    median_error=float(np.median(np.abs(error))),
                    error_times_root_s=rms * cpu_s**0.5,
                )
            )
            print(rows[-1], flush=True)
    return rows


if __name__ == "__main__":
    arguments = argument_parser(__doc__).parse_args()
    tyndall.blender.enable()
    write_report(run(), arguments)
