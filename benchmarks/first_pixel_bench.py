# SPDX-License-Identifier: GPL-3.0-or-later
"""From the press of F12 to the first pixels, sync included: a million triangles, and 100,000 instances.

scripts/python benchmarks/first_pixel_bench.py --context FILE --output FILE
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from unittest import mock

import bpy
import numpy as np

import tyndall.blender
from report import Row, argument_parser, row, write_report
from tyndall import Progress
from tyndall.renderer import Film, RenderConfig, Session
from tyndall.scene_description import Camera

REPETITIONS = 5
GRID_SIDE = 708  # vertices: 707 x 707 squares are a million triangles
INSTANCES = 100_000


def empty_scene() -> bpy.types.Scene:
    """A sun and a camera that looks down at the origin, in full HD."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -6.0, 4.0), (1.0, 0.0, 0.0)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    for member in (camera, sun):
        scene.collection.objects.link(member)
    scene.camera = camera
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 1920, 1080, 100
    scene.tyndall.pixel_samples = 1
    return scene


def a_million_triangles() -> None:
    """One mesh."""
    empty_scene()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=GRID_SIDE - 1, y_subdivisions=GRID_SIDE - 1, size=10.0)


def many_instances() -> None:
    """A small sphere on each of many random points."""
    scene = empty_scene()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.02)
    sphere = bpy.context.object
    points = bpy.data.meshes.new("Points")
    points.from_pydata(np.random.default_rng(1).uniform(-5.0, 5.0, (INSTANCES, 3)).tolist(), [], [])
    cloud = bpy.data.objects.new("Cloud", points)
    scene.collection.objects.link(cloud)
    sphere.parent, cloud.instance_type = cloud, "VERTS"


def first_pixel_s() -> float:
    """Seconds until the first picture is handed to Blender."""
    seen: list[float] = []
    render = Session.render

    def timed(
        self: Session,
        camera: Camera,
        config: RenderConfig,
        progress: Progress,
        on_update: Callable[[Film], None] | None = None,
    ) -> Film:
        def updated(film: Film) -> None:
            if on_update is not None:
                on_update(film)
            seen.append(time.perf_counter())

        return render(self, camera, config, progress, updated)

    start = time.perf_counter()
    with mock.patch.object(Session, "render", timed):
        bpy.ops.render.render()
    return seen[0] - start


def main() -> None:
    """Time both scenes and write the report."""
    arguments = argument_parser(__doc__).parse_args()
    tyndall.blender.enable()
    rows: list[Row] = []
    for make in (a_million_triangles, many_instances):
        make()
        seconds = statistics.median(first_pixel_s() for _ in range(REPETITIONS))
        rows.append(row(make.__name__, seconds))
        print(rows[-1], flush=True)
    tyndall.blender.disable()
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
