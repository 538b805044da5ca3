# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise and time of default settings, ours and Cycles', as one figure."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray
from timed_render import timed_pixels

from report import Row, row

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.cycles_reference import prepare_cycles


def _measured(scene: bpy.types.Scene, engine: str, samples: int, seed: int) -> tuple[NDArray[np.float64], float]:
    if engine == "cycles":
        prepare_cycles(scene, samples, seed)
        scene.cycles.use_light_tree, scene.cycles.filter_width = True, 1.5
    else:
        scene.render.engine, scene.tyndall.seed, scene.tyndall.pixel_samples = "TYNDALL", seed, samples
    return timed_pixels(scene)


def both_engines(scenes: Mapping[str, Callable[[], bpy.types.Scene]], samples: int) -> list[Row]:
    """Two renders of each that differ in their seed. Seconds are the processor's, reading and preparing included."""
    rows = []
    for name, build in scenes.items():
        scene = build()
        for engine in ("tyndall", "cycles"):
            (first, first_s), (second, second_s) = (_measured(scene, engine, samples, seed) for seed in (1, 2))
            cpu_s, level = min(first_s, second_s), (first.mean() + second.mean()) / 2
            noise = np.sqrt(((first - second) ** 2).mean(axis=2) / 2) / level
            rms, median = float(np.sqrt((noise**2).mean())), float(np.median(noise))
            rows.append(
                row(
                    f"{name}, {engine}",
                    cpu_s,
                    samples=samples,
                    mean=float(level),
                    rms_noise=rms,
                    median_noise=median,
                    variance_times_s=rms**2 * cpu_s,
                )
            )
            print(rows[-1], flush=True)
    return rows
