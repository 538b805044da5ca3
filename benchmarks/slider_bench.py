# SPDX-License-Identifier: GPL-3.0-or-later
"""From a slider to the picture in a rendered viewport of full HD: reading what changed, and rendering it.

Rows: a layer of a transfer function, an edit of the sun's occluders, the sun moved, the camera moved, the deer moved,
in the forest of a million triangles. real_time is the first picture of the new state, finished_s the finished one (one
sample per pixel), read_s what reading Blender's scene takes of both. stage_s:<name> are the first picture's stages,
kept:<name> tells what it found. Drawing (16 ms here by software) and the wait for a redraw are not in it.

scripts/python benchmarks/slider_bench.py --context FILE --output FILE [--simd NAME...]
With --simd the first three sliders alone, on each of these instruction sets in turn (AVX-512, AVX2, SSE4).
"""

from __future__ import annotations

import math
import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

import tyndall.blender
from report import Row, argument_parser, row, write_report
from tyndall.renderer import RenderConfig, ShaftConfig
from tyndall.scene_description import Camera, SceneDescription
from tyndall.transfer_functions import (
    Constraint,
    Layer,
    LayerKind,
    TransferFunction,
    Use,
    WeightedFunction,
)

Statistics = dict[str, Any]  #: As Film.statistics.

REPETITIONS = 7
SIZE_PX = (1920, 1080)
SCENE = Path(__file__).resolve().parent.parent / "examples" / "forest_clearing.blend"
#: As a fresh viewport has it: one sample of each pixel, by the depth map, few samples of lights.
CONFIG = RenderConfig(
    pixel_samples=1,
    shafts=ShaftConfig(method="SHADOW_MAP", error_target=0.01, light_samples=8, world_samples=16, adapts_strata=True),
)


def functions(step: int) -> tuple[WeightedFunction, ...]:
    """A gradient, and a diffusion of four constraints whose opacity is the slider."""
    colours = ((1.0, 0.4, 0.1, 1.0), (0.1, 0.2, 0.6, 1.0), (1.0, 0.9, 0.6, 1.0), (0.3, 0.0, 0.2, 1.0))
    places = ((0.1, 0.2), (0.9, 0.1), (0.5, 0.6), (0.2, 0.9))
    layers = (
        Layer(name="gradient", kind=LayerKind.GRADIENT, ramp=colours[:2]),
        Layer(
            name="diffusion",
            kind=LayerKind.DIFFUSION,
            opacity=0.5 + 0.01 * step,
            constraints=tuple(Constraint(position=p, colour=c) for p, c in zip(places, colours, strict=True)),
        ),
    )
    return (WeightedFunction(function=TransferFunction(name="slider", use=Use.TINT, layers=layers)),)


class Bench:
    """One rendered viewport, without the window around it."""

    def __init__(self) -> None:
        # The add-on is where enable() has put it.
        from tyndall.blender.addon.engine.sessions import viewport_session  # noqa: PLC0415
        from tyndall.blender.addon.engine.viewport_worker import View, ViewportWorker  # noqa: PLC0415
        from tyndall.blender.addon.sync.cameras import read_camera  # noqa: PLC0415
        from tyndall.blender.addon.sync.reports import Reports  # noqa: PLC0415
        from tyndall.blender.addon.sync.scene import SceneReader  # noqa: PLC0415

        self._view, self._reports = View, Reports
        self._reader = SceneReader()
        # What a viewport's engine hears of.
        bpy.app.handlers.depsgraph_update_post.append(lambda _, depsgraph: self._reader.note_updates(depsgraph))
        self._worker = ViewportWorker(viewport_session())
        scene = bpy.context.scene
        depsgraph = bpy.context.evaluated_depsgraph_get()
        camera = scene.camera.evaluated_get(depsgraph)
        world_from_camera = np.array(camera.matrix_world.normalized())
        self.camera: Camera = read_camera(
            camera, scene.render, SIZE_PX, Reports(), world_from_camera=world_from_camera, shift_x=camera.data.shift_x
        )
        self.show(functions(0), self.read())

    def read(self) -> SceneDescription:
        """Blender's scene as it is now."""
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return self._reader.read(depsgraph, self._reports(), lambda: None, is_live=True)

    def show(
        self, made: tuple[WeightedFunction, ...], description: SceneDescription | None = None
    ) -> tuple[float, float, Statistics]:
        """Seconds to the first picture and to the finished one, and what the first one tells of itself."""
        before = self._worker.picture
        start = time.perf_counter()
        self._worker.show(self._view(camera=self.camera, config=replace(CONFIG, transfer_functions=made)), description)
        first_s = 0.0
        work: Statistics = {}
        while True:
            time.sleep(0.0005)
            self._worker.poll()
            picture = self._worker.picture
            if picture is not before and first_s == 0.0:
                first_s = time.perf_counter() - start
                work = self._worker.work.statistics
            if first_s and self._worker.status == "":
                return first_s, time.perf_counter() - start, work

    def close(self) -> None:
        """End its thread."""
        self._worker.close()


def measure(bench: Bench, name: str, change: Callable[[int], tuple[WeightedFunction, ...]], *, rebuilds: bool) -> Row:
    """Medians over some steps of one slider."""
    reads, firsts, finishes, works = [], [], [], []
    for step in range(1, REPETITIONS + 1):
        start = time.perf_counter()
        made = change(step)
        description = bench.read() if rebuilds else None
        reads.append(time.perf_counter() - start)
        first_s, finished_s, work = bench.show(made, description)
        works.append(work)
        firsts.append(reads[-1] + first_s)
        finishes.append(reads[-1] + finished_s)
    return row(
        name,
        statistics.median(firsts),
        finished_s=statistics.median(finishes),
        read_s=statistics.median(reads),
        **stages(works),
    )


def stages(works: list[Statistics]) -> dict[str, float]:
    """Medians of the stages' seconds over some pictures, and what the last of them had kept."""
    seconds: dict[str, list[float]] = {}
    for work in works:
        of_work: dict[str, float] = {}
        for stage in work["stages"]:
            of_work[stage["name"]] = of_work.get(stage["name"], 0.0) + stage["seconds"]
        for name, value in of_work.items():
            seconds.setdefault(name, []).append(value)
    kept = {name: value for name, value in works[-1]["counts"].items() if "kept" in name or "reused" in name}
    return {f"stage_s:{name}": statistics.median(values) for name, values in seconds.items()} | {
        f"kept:{name}": value for name, value in kept.items()
    }


def main() -> None:
    """Time the sliders and write the report."""
    parser = argument_parser(__doc__)
    parser.add_argument("--simd", nargs="+", default=(), metavar="NAME")
    arguments = parser.parse_args()
    tyndall.blender.enable()
    bpy.ops.wm.open_mainfile(filepath=str(SCENE))
    bpy.context.scene.render.engine = "TYNDALL"
    sun = next(thing for thing in bpy.context.scene.objects if thing.type == "LIGHT" and thing.data.type == "SUN")
    edit = sun.data.tyndall.occluder_edits.add()
    edit.name, edit.kind, edit.shape = "slider", "CLOSE", "SQUARE"
    bench = Bench()

    def edited(step: int) -> tuple[WeightedFunction, ...]:
        edit.size_m = 0.3 + 0.01 * step
        return functions(0)

    def moved(step: int) -> tuple[WeightedFunction, ...]:
        sun.rotation_euler[2] += math.radians(1.0 + 0.01 * step)
        return functions(0)

    deer = bpy.context.scene.objects["Deer"]

    def object_moved(_step: int) -> tuple[WeightedFunction, ...]:
        deer.location.x += 0.02
        return functions(0)

    def camera_moved(_step: int) -> tuple[WeightedFunction, ...]:
        place = bench.camera.world_from_camera.copy()
        place[0, 3] += 0.02
        bench.camera = replace(bench.camera, world_from_camera=place)
        return functions(0)

    def light_sliders(suffix: str = "") -> list[Row]:
        if not edit.is_enabled:  # a picture of what is shown already would never come
            edit.is_enabled = True
            bench.show(functions(0), bench.read())
        rows = [
            measure(bench, "transfer function" + suffix, functions, rebuilds=True),
            measure(bench, "occluder edit" + suffix, edited, rebuilds=True),
        ]
        edit.is_enabled = False
        bench.show(functions(0), bench.read())
        return [*rows, measure(bench, "sun moved" + suffix, moved, rebuilds=True)]

    rows: list[Row] = []
    if arguments.simd:
        from tyndall import _native  # noqa: PLC0415 (where enable() has put it)

        for name in arguments.simd:
            forced = _native.ForcedSimdTarget(name)
            rows += light_sliders(f"/{name}")
            del forced
    else:
        rows = light_sliders()
        rows.append(measure(bench, "camera moved", camera_moved, rebuilds=False))
        rows.append(measure(bench, "object moved", object_moved, rebuilds=True))
    bench.close()
    tyndall.blender.disable()
    for made in rows:
        print(made, flush=True)
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # bpy 4.5 waits for ever at its exit: it destroys a condition that its thread for closing files waits on.
    os._exit(0)
