# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise of what glowing things light at equal time, ours and Cycles' with its light tree.

Times are the process's CPU time on one thread, of a render less that of the same render with one sample per pixel.
Noise: of two renders that differ in their seed, per pixel, relative to the picture's mean; as the root of its mean
square, which the worst pixels make, and as the median. It falls with the root of the time, which makes one figure of
both: noise times root of CPU seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import bpy
import numpy as np
from many_lights_bench import measured

from report import Row, row


def rows_of(
    name: str, scene: bpy.types.Scene, samples_of: Mapping[str, int], prepare: Callable[[str], None] = lambda _: None
) -> list[Row]:
    """A row per engine; ``prepare`` is told the engine before its renders."""
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    rows = []
    for engine, samples in samples_of.items():
        prepare(engine)
        _, of_setup_s = measured(scene, engine, 1, 1)
        (first, first_s), (second, second_s) = (measured(scene, engine, samples, seed) for seed in (1, 2))
        cpu_s = max(min(first_s, second_s) - of_setup_s, 1e-3) * samples / (samples - 1)
        level = (first.mean() + second.mean()) / 2
        noise = np.sqrt(((first - second) ** 2).mean(axis=2) / 2) / level
        rms, median = float(np.sqrt((noise**2).mean())), float(np.median(noise) / 0.6745)
        figures = {"samples": samples, "setup_cpu_s": of_setup_s, "mean": float(level)}
        for kind, value in (("rms", rms), ("median", median)):
            figures |= {f"{kind}_noise": value, f"{kind}_times_root_s": value * cpu_s**0.5}
        rows.append(row(f"{name}, {engine}", cpu_s, **figures))
        print(rows[-1], flush=True)
    return rows
