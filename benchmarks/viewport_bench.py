# SPDX-License-Identifier: GPL-3.0-or-later
"""A rendered viewport of full HD: from nothing, from a moved camera and from a moved object to its first picture.

Rows: *first start* and *camera moved* with a million triangles, plain and in fog under a sun that casts shafts; *object
moved* out of 100,000 objects, once all of one mesh and once of 1,000. real_time is the first, coarse picture; sync_s is
what brings the native scene up to date before it, reading Blender's scene (read_s) and sending what changed (update_s),
but for Embree's tree over what moved (tree_s).
Drawing and the wait for a redraw are not in it. pixel_error of a moved object: the largest difference of its finished
picture to that of a session that has seen nothing before.

scripts/python benchmarks/viewport_bench.py --context FILE --output FILE
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import bpy
import numpy as np

import tyndall.blender
from report import Row, argument_parser, row, write_report
from tyndall import Progress
from tyndall.renderer import RenderConfig, Session, ShaftConfig
from tyndall.scene_description import Camera, SceneDescription

REPETITIONS = 9
SIZE_PX = 1920, 1080
GRID_SIDE = 708  #: Vertices: 707 x 707 squares are a million triangles.
OBJECTS = 100_000
#: As a fresh viewport has it: one sample of each pixel, by the depth map, few samples of lights.
CONFIG = RenderConfig(
    pixel_samples=1,
    shafts=ShaftConfig(method="SHADOW_MAP", error_target=0.01, light_samples=8, world_samples=16, adapts_strata=True),
)


def empty_scene() -> bpy.types.Scene:
    """A sun and a camera that looks down at the origin."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -6.0, 4.0), (1.0, 0.0, 0.0)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    for member in (camera, sun):
        scene.collection.objects.link(member)
    scene.camera = camera
    scene.render.engine = "TYNDALL"
    return scene


def a_million_triangles() -> None:
    """One mesh, with waves that shade one another."""
    scene = empty_scene()
    side = np.linspace(-5.0, 5.0, GRID_SIDE)
    x, y = np.meshgrid(side, side, indexing="ij")
    vertices = np.stack([x, y, 0.3 * np.sin(9.0 * x) * np.cos(7.0 * y)], axis=2).reshape(-1, 3)
    first = (np.arange(GRID_SIDE - 1)[:, None] * GRID_SIDE + np.arange(GRID_SIDE - 1)[None, :]).ravel()
    faces = np.stack([first, first + GRID_SIDE, first + GRID_SIDE + 1, first + 1], axis=1)
    mesh = bpy.data.meshes.new("Waves")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    scene.collection.objects.link(bpy.data.objects.new("Waves", mesh))


def a_million_triangles_in_fog() -> None:
    """The same, and a box of fog around it."""
    a_million_triangles()
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    box = bpy.context.object
    box.scale = (10.0, 10.0, 3.0)
    fog = bpy.data.materials.new("Fog")
    fog.use_nodes = True
    fog.node_tree.nodes.clear()
    scatter = fog.node_tree.nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Density"].default_value = 0.05
    output = fog.node_tree.nodes.new("ShaderNodeOutputMaterial")
    fog.node_tree.links.new(scatter.outputs["Volume"], output.inputs["Volume"])
    box.data.materials.append(fog)
    bpy.data.objects["Sun"].rotation_euler = (0.9, 0.3, 0.0)


def many_objects(mesh_count: int) -> None:
    """Small spheres at random places, each an object of its own."""
    scene = empty_scene()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=0.02)
    first = bpy.context.object
    meshes = [first.data] + [first.data.copy() for _ in range(mesh_count - 1)]
    places = np.random.default_rng(1).uniform(-5.0, 5.0, (OBJECTS, 3))
    for index, place in enumerate(places):
        thing = bpy.data.objects.new(f"Sphere {index}", meshes[index % mesh_count])
        thing.location = place
        scene.collection.objects.link(thing)


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
        self._worker = ViewportWorker(viewport_session())
        scene = bpy.context.scene
        camera = scene.camera.evaluated_get(bpy.context.evaluated_depsgraph_get())
        self.camera: Camera = read_camera(camera, scene.render, SIZE_PX, Reports())
        self._noting_s = 0.0
        # What a viewport's engine hears of.
        bpy.app.handlers.depsgraph_update_post.append(self._note_updates)

    def _note_updates(self, _scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        start = time.perf_counter()
        self._reader.note_updates(depsgraph)
        self._noting_s += time.perf_counter() - start

    def read(self) -> tuple[SceneDescription, float]:
        """Blender's scene as it is now, and what that took since the last read: noting updates, too."""
        start = time.perf_counter()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        description = self._reader.read(depsgraph, self._reports(), lambda: None, is_live=True)
        seconds, self._noting_s = time.perf_counter() - start + self._noting_s, 0.0
        return description, seconds

    def show(self, description: SceneDescription | None = None) -> tuple[float, float, dict[str, float]]:
        """Seconds to the first picture and to the finished one, and the stages of the first one."""
        worker = self._worker
        before = worker.picture
        start = time.perf_counter()
        worker.show(self._view(camera=self.camera, config=CONFIG), description)
        first_s, stages = 0.0, {}
        while True:
            time.sleep(0.0005)
            worker.poll()
            if worker.picture is not before and not first_s:
                first_s = time.perf_counter() - start
                for stage in worker.work.statistics["stages"]:
                    stages[stage["name"]] = stages.get(stage["name"], 0.0) + stage["seconds"]
            if first_s and not worker.status:
                return first_s, time.perf_counter() - start, stages

    def pixels(self) -> np.ndarray[Any, Any]:
        """The finished picture."""
        return np.asarray(self._worker.picture.rgba)

    def close(self) -> None:
        """End its thread."""
        bpy.app.handlers.depsgraph_update_post.remove(self._note_updates)
        self._worker.close()


def first_start(make: Callable[[], None]) -> Row:
    """Everything is new: the first time that rendered shading is chosen."""
    firsts, finishes, reads, works = [], [], [], []
    for _ in range(REPETITIONS):
        bench = Bench()
        description, read_s = bench.read()
        reads.append(read_s)
        first_s, finished_s, stages = bench.show(description)
        firsts.append(reads[-1] + first_s)
        finishes.append(reads[-1] + finished_s)
        works.append(stages)
        bench.close()
    return timed(f"first start, {make.__name__}", firsts, finishes, works, read_s=statistics.median(reads))


def camera_moved(make: Callable[[], None]) -> Row:
    """The whole picture is another one."""
    bench = Bench()
    bench.show(bench.read()[0])
    firsts, finishes, works = [], [], []
    for step in range(REPETITIONS):
        place = bench.camera.world_from_camera.copy()
        place[:3, 3] += (0.2, 0.1 * step, 0.05)
        bench.camera = replace(bench.camera, world_from_camera=place)
        first_s, finished_s, stages = bench.show()
        firsts.append(first_s)
        finishes.append(finished_s)
        works.append(stages)
    bench.close()
    return timed(f"camera moved, {make.__name__}", firsts, finishes, works)


def object_moved(mesh_count: int) -> Row:
    """Moved by a script or by hand: Blender tells of it by its update of the scene."""
    bench = Bench()
    bench.show(bench.read()[0])
    chosen = [bpy.data.objects[f"Sphere {index}"] for index in range(7, OBJECTS, OBJECTS // REPETITIONS)][:REPETITIONS]
    firsts, finishes, reads, works = [], [], [], []
    for thing in chosen:
        thing.location.z += 0.5
        bpy.context.view_layer.update()  # Blender's own work, which every engine waits for
        description, read_s = bench.read()
        reads.append(read_s)
        first_s, finished_s, stages = bench.show(description)
        firsts.append(reads[-1] + first_s)
        finishes.append(reads[-1] + finished_s)
        works.append(stages)
    fresh = Session()
    fresh.update(bench.read()[0], Progress())
    error = float(np.abs(fresh.render(bench.camera, CONFIG, Progress()).planes["Combined"] - bench.pixels()).max())
    bench.close()
    tree_s = statistics.median(stages["scene: tree"] for stages in works)
    update_s = statistics.median(stages["scene update"] - stages["scene: tree"] for stages in works)
    read_s = statistics.median(reads)
    name = f"object moved, {OBJECTS} objects of {mesh_count} meshes"
    return timed(
        name,
        firsts,
        finishes,
        works,
        read_s=read_s,
        update_s=update_s,
        sync_s=read_s + update_s,
        tree_s=tree_s,
        pixel_error=error,
    )


def timed(name: str, firsts: list[float], finishes: list[float], works: list[dict[str, float]], **more: float) -> Row:
    """Medians, and the stages of the first picture."""
    stages = {
        f"stage_s:{stage}": statistics.median(work.get(stage, 0.0) for work in works) for stage in sorted(works[-1])
    }
    made = row(name, statistics.median(firsts), worst_s=max(firsts), finished_s=statistics.median(finishes), **more)
    print(made | stages, flush=True)
    return made | stages


def main() -> None:
    """Time all of them and write the report."""
    arguments = argument_parser(__doc__).parse_args()
    tyndall.blender.enable()
    rows: list[Row] = []
    for make in (a_million_triangles, a_million_triangles_in_fog):
        make()
        rows += [first_start(make), camera_moved(make)]
    for mesh_count in (1, 1000):
        many_objects(mesh_count)
        rows.append(object_moved(mesh_count))
    tyndall.blender.disable()
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # bpy 4.5 waits for ever at its exit: it destroys a condition that its thread for closing files waits on.
    os._exit(0)
