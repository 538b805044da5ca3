# SPDX-License-Identifier: GPL-3.0-or-later
"""One voxel model placed 10,000 times: bytes of memory per placement, and pictures beside those of one placement.

The Stanford dragon's surface, 16,384 voxels a side, by the thin rule, made out of core (--file keeps it, or reads it
where it is there already); placements stand 100 to a side, each turned its own way about the vertical. Sun and sky,
4 samples, 640 x 360 pixels:

  near    the camera is before the first one, which fills the picture's height; those behind it are seen past it
  field   from above a corner: all of them

Rows: placements/COUNT (seconds; bytes per placement of the process's memory, its description's among them), and
render/COUNT/VIEW (of three pictures the median: seconds; processor seconds of all threads; those of the first one,
which also makes what levels of detail need).
Without TYNDALL_SHARED_DATA there is nothing to measure. With scripts/python:

  benchmarks/voxel_instances_bench.py --context build/logs/bench-context.json --output instances.json
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray
from process_memory import memory_bytes, most_memory_bytes

from report import Row, argument_parser, row, write_report
from tyndall import Progress
from tyndall.mesh_files import read_mesh
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import (
    Camera,
    CameraKind,
    Light,
    LightKind,
    Material,
    SceneDescription,
    VoxelObjects,
    World,
)
from tyndall.voxel_dag import Config, VoxelDag, load, voxelize_to_file

_DATA = Path(os.environ.get("TYNDALL_SHARED_DATA", "../shared/data"))
_SIZE_PX, _PICTURES = (640, 360), 3
_SPACING = 1.3  #: Of the model's side.
_CONFIG = RenderConfig(pixel_samples=4)


def _dragon(path: Path, resolution: int) -> VoxelDag:
    if not path.exists():
        positions_m, triangles = read_mesh(_DATA / "dragon/dragon_vrip.ply.gz")
        voxelize_to_file(positions_m.astype(np.float32), triangles, path, Config(resolution=resolution))
    return load(path)


def _looking(eye: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """A place whose -Z goes from eye to at; Y is up."""
    back = (eye - at) / np.linalg.norm(eye - at)
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    place = np.eye(4)
    place[:3, :3] = np.stack([right, np.cross(back, right), back], -1)
    place[:3, 3] = eye
    return place


def _places(dag: VoxelDag, count: int) -> NDArray[np.float64]:
    """(count, 4, 4), from the origin towards -z and both sides, the first one as it is."""
    lower_m, upper_m = dag.bounds_m
    middle_m, side_m = (lower_m + upper_m) / 2, upper_m[0] - lower_m[0]
    a_side = int(np.ceil(np.sqrt(count)))
    turns = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, count)
    turns[0] = 0.0
    places = np.tile(np.eye(4), (count, 1, 1))
    cosine, sine = np.cos(turns), np.sin(turns)
    places[:, 0, 0], places[:, 0, 2], places[:, 2, 0], places[:, 2, 2] = cosine, sine, -sine, cosine
    column, along = np.arange(count) % a_side, np.arange(count) // a_side
    across = (column + 1) // 2 * np.where(column % 2 == 0, 1, -1)
    middles = middle_m + _SPACING * side_m * np.stack([across, 0 * along, -along], -1)
    places[:, :3, 3] = middles - np.einsum("nij,j->ni", places[:, :3, :3], middle_m)
    return places


def _camera(dag: VoxelDag, view: str, count: int) -> Camera:
    lower_m, upper_m = dag.bounds_m
    middle_m, side_m = (lower_m + upper_m) / 2, upper_m[0] - lower_m[0]
    if view == "near":
        eye, at = middle_m + side_m * np.array([0.2, 0.25, 1.6]), middle_m
    else:
        reach = _SPACING * side_m * np.sqrt(count)
        eye, at = middle_m + reach * np.array([0.45, 0.3, 0.35]), middle_m + reach * np.array([0.0, 0.0, -0.4])
    return Camera(
        kind=CameraKind.PERSPECTIVE,
        world_from_camera=_looking(eye, at),
        window=(-16 / 9 * 0.35, 16 / 9 * 0.35, -0.35, 0.35),
        clip_m=(0.01 * side_m, 1000.0 * side_m),
        size_px=_SIZE_PX,
    )


def _scene(dag: VoxelDag, count: int) -> SceneDescription:
    sun = _looking(np.array([0.5, 0.6, 0.7]), np.zeros(3))
    names = tuple(f"dragon.{index:05}" for index in range(count))
    return SceneDescription(
        voxel_objects=(VoxelObjects(dag=dag, world_from_object=_places(dag, count), object_names=names),),
        materials=(Material(name="white", diffuse=(0.8,) * 3),),
        lights=(Light(name="sun", kind=LightKind.SUN, strength=(3.0,) * 3, world_from_light=sun),),
        world=World(radiance=(0.3,) * 3),
    )


def _pictures(session: Session, dag: VoxelDag, view: str, count: int, pictures: Path | None) -> Row:
    walls, processors, film = [], [], None
    for _ in range(1 + _PICTURES):
        begun, begun_cpu = time.perf_counter(), time.process_time()
        film = session.render(_camera(dag, view, count), _CONFIG, Progress())
        walls.append(time.perf_counter() - begun)
        processors.append(time.process_time() - begun_cpu)
    if pictures is not None and film is not None:
        np.save(pictures / f"instances_{count}_{view}.npy", film.planes["Combined"])
    return row(
        f"render/{count}/{view}",
        median(walls[1:]),
        cpu_seconds=median(processors[1:]),
        first_seconds=walls[0],
        first_cpu_seconds=processors[0],
    )


def main() -> None:
    """Place one, then all, before anything is drawn, whose memory would be used again; draw; write the report."""
    parser = argument_parser(__doc__)
    parser.add_argument("--resolution", type=int, default=16384)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--file", type=Path, help="of the model")
    parser.add_argument("--pictures", type=Path, help="a folder: the last pictures, as .npy")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        dag = _dragon(chosen.file or Path(folder) / "dragon.tdag", chosen.resolution)
    rows, session = [], Session()

    def place(count: int) -> None:
        before, begun = memory_bytes(), time.perf_counter()
        scene = _scene(dag, count)
        described = memory_bytes()
        session.update(scene, Progress())
        rows.append(
            row(
                f"placements/{count}",
                time.perf_counter() - begun,
                bytes_per_placement=(memory_bytes() - before) / count,
                bytes_per_description=(described - before) / count,
                memory_bytes=memory_bytes(),
                geometry_bytes=dag.geometry_bytes,
                voxel_count=dag.voxel_count,
            )
        )
        print(rows[-1], flush=True)

    def render(count: int, view: str) -> None:
        rows.append(_pictures(session, dag, view, count, chosen.pictures))
        print(rows[-1], flush=True)

    place(1)  # all that one takes, so that the next have what they take beyond it
    place(chosen.count)
    for view in ("near", "field"):
        render(chosen.count, view)
    session.update(_scene(dag, 1), Progress())
    render(1, "near")
    rows[-1]["peak_bytes"] = most_memory_bytes()
    write_report(rows, chosen)


if __name__ == "__main__":
    main()
