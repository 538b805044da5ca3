# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps with a size that stand in fog: error against time, ours and Cycles'.

scripts/python benchmarks/lamps_in_fog_bench.py --context FILE --output FILE. Times are the process's CPU time of a
whole render. Errors are root mean squares over pixels, relative to the picture's mean, beside the mean of several
renders of Cycles, of whose own noise they are freed; mean_error is of the whole picture. Variance times time is one
figure of both.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray
from timed_render import timed_pixels

from report import Row, row, run_scenes

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.cycles_reference import prepare_cycles
from support.small_scenes import cube, empty_scene, light, material, node

SIZE_PX, CYCLES_SAMPLES, CYCLES_RENDERS = 160, 64, 8
HAS_DISCS = bpy.app.version >= (4, 2, 0)


def _lamp(kind: str, radius_m: float, *, is_disc: bool = True) -> bpy.types.Object:
    lamp = light(kind, (0.2, 0.1, 2.1), energy=500.0, shadow_soft_size=radius_m)
    if HAS_DISCS:
        lamp.data.use_soft_falloff = is_disc
    # In spots that are spheres it loses up to half of the light in Cycles 4.5.
    lamp.data.cycles.use_multiple_importance_sampling = kind != "SPOT" or is_disc
    return lamp


def _panel(shape: str, size_m: float = 3.0, spread_deg: float = 180.0) -> bpy.types.Object:
    lamp = light("AREA", (0.2, 0.1, 2.1), energy=500.0, size=size_m)
    lamp.data.shape, lamp.data.spread = shape, math.radians(spread_deg)
    return lamp


#: How high the camera is, and the lamp. The panels shine down; from above they are seen from behind.
SCENES: dict[str, tuple[float, Callable[[], bpy.types.Object]]] = {
    "panel of 3 m, from behind": (2.6, lambda: _panel("SQUARE")),
    "panel of 3 m": (1.2, lambda: _panel("SQUARE")),
    "round panel of 3 m": (1.2, lambda: _panel("DISK")),
    "lamp of 0.5 m": (2.3, lambda: _lamp("POINT", 0.5)),
    "ball of 0.5 m": (2.3, lambda: _lamp("POINT", 0.5, is_disc=False)),
    "spot of 0.1 m": (1.2, lambda: _lamp("SPOT", 0.1)),
    "spot of 0.3 m, a ball": (1.2, lambda: _lamp("SPOT", 0.3, is_disc=False)),
    "panel of 0.6 m, 30 degrees": (1.2, lambda: _panel("SQUARE", 0.6, 30.0)),
}


def build(name: str) -> bpy.types.Scene:
    """A camera in a box of fog that looks at the lamp."""
    height_m, add_lamp = SCENES[name]
    scene = empty_scene(SIZE_PX)
    camera = scene.camera
    camera.data.type, camera.location = "PERSP", (4.8, 4.0, height_m)
    camera.rotation_euler = (Vector((0.0, 0.0, 1.5)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    fog = material(
        "Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.1, Anisotropy=0.4).outputs[0]
    )
    box = cube("Fog", fog)
    box.location, box.scale = (0.3, 0.2, 1.5), (8.0, 8.0, 3.8)
    add_lamp()
    return scene


def _measured(scene: bpy.types.Scene, samples: int, seed: int, *, by_cycles: bool) -> tuple[NDArray[np.float64], float]:
    settings = scene.tyndall
    if by_cycles:
        prepare_cycles(scene, samples, seed)
        scene.cycles.pixel_filter_type = "BOX"
    else:
        scene.render.engine, settings.seed, settings.pixel_samples = "TYNDALL", seed, samples
        settings.noise_threshold, settings.pixel_filter, settings.filter_width_px = 0.0, "BOX", 1.0
    return timed_pixels(scene)


def run(names: list[str]) -> list[Row]:
    """Measure both engines in all scenes."""
    rows = []
    for name in names or SCENES:
        scene = build(name)
        theirs = [_measured(scene, CYCLES_SAMPLES, seed, by_cycles=True) for seed in range(CYCLES_RENDERS)]
        reference = np.mean([picture for picture, _ in theirs], axis=0)
        level, cycles_s = reference.mean(), float(np.median([cpu_s for _, cpu_s in theirs]))
        noise2 = np.mean([((picture - reference) ** 2).mean() for picture, _ in theirs])
        noise2 *= CYCLES_RENDERS / (CYCLES_RENDERS - 1) / level**2
        rows.append(
            row(
                f"{name}, cycles/{CYCLES_SAMPLES}",
                cycles_s,
                rms_error=float(np.sqrt(noise2)),
                mean=float(level),
                variance_times_s=float(noise2 * cycles_s),
            )
        )
        print(rows[-1], flush=True)
        for samples in (1, 4, 16, 64):
            ours = [_measured(scene, samples, seed, by_cycles=False) for seed in (1, 2)]
            cpu_s = min(seconds for _, seconds in ours)
            error2 = np.mean([((picture - reference) ** 2).mean() for picture, _ in ours]) / level**2
            error2 = max(0.0, error2 - noise2 / CYCLES_RENDERS)
            rows.append(
                row(
                    f"{name}, tyndall/{samples}",
                    cpu_s,
                    rms_error=float(np.sqrt(error2)),
                    mean_error=float(np.mean([picture.mean() for picture, _ in ours]) / level - 1.0),
                    variance_times_s=float(error2 * cpu_s),
                )
            )
            print(rows[-1], flush=True)
    return rows


if __name__ == "__main__":
    run_scenes(run, __doc__)
