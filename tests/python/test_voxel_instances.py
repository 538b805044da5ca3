# SPDX-License-Identifier: GPL-3.0-or-later
"""Many placements of one voxel model: each is seen where and how it stands, and the voxels are in memory once."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
import pytest

from tyndall import Progress, voxel_dag
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import Camera, CameraKind, Material, SceneDescription, VoxelObjects

A_SIDE = 100  #: Placements.
SIDE = 8  #: Voxels of a model.


def places(lift_m: np.ndarray, quarters: np.ndarray) -> np.ndarray:
    """A grid of models, SIDE m apart, each lifted and turned about the vertical through its middle."""
    count = len(lift_m)
    angle = np.pi / 2 * quarters
    found = np.tile(np.eye(4), (count, 1, 1))
    found[:, 0, 0], found[:, 0, 1] = np.cos(angle), -np.sin(angle)
    found[:, 1, 0], found[:, 1, 1] = np.sin(angle), np.cos(angle)
    index = np.arange(count)
    middles = SIDE * np.stack([index % A_SIDE + 0.5, index // A_SIDE + 0.5, 0 * index], -1) + lift_m[:, None] * [
        0,
        0,
        1,
    ]
    found[:, :3, 3] = middles - found[:, :3, :3] @ np.array([SIDE / 2, SIDE / 2, 0.0])
    return found


def test_each_of_10000_placements_is_seen_where_it_stands() -> None:
    """From above a pixel is a column of voxels of one placement: its depth says which voxel, lifted and turned how."""
    random = np.random.default_rng(4)
    heights = random.integers(0, SIDE, (SIDE, SIDE))  # [x, y], all different enough for turns to show
    voxels = [(x, y, heights[x, y]) for x in range(SIDE) for y in range(SIDE)]
    cube = voxel_dag.Config(resolution=SIDE, bounds_m=((0, 0, 0), (SIDE, SIDE, SIDE)))
    lift_m, quarters = random.uniform(0.0, 50.0, A_SIDE**2), random.integers(0, 4, A_SIDE**2)
    session = Session()
    session.update(
        SceneDescription(
            voxel_objects=(
                VoxelObjects(
                    dag=voxel_dag.from_coordinates(voxels, cube),
                    world_from_object=places(lift_m, quarters),
                    object_names=tuple(f"thing {index}" for index in range(A_SIDE**2)),
                    material=0,
                ),
            ),
            materials=(Material(name="grey"),),
        ),
        Progress(),
    )
    top_m, reach = 100.0, A_SIDE * SIDE / 2
    above = np.eye(4)
    above[:3, 3] = (reach, reach, top_m)
    camera = Camera(
        kind=CameraKind.ORTHOGRAPHIC,
        world_from_camera=above,
        window=(-reach, reach, -reach, reach),
        clip_m=(0.1, 1000.0),
        size_px=(A_SIDE * SIDE, A_SIDE * SIDE),
    )
    film = session.render(camera, RenderConfig(pixel_samples=1, passes=frozenset({"Depth"})), Progress())
    depth = film.planes["Depth"].reshape(
        A_SIDE, SIDE, A_SIDE, SIDE
    )  # rows from below: y and x of placements, of pixels
    for index in range(A_SIDE**2):
        turned = np.rot90(heights.T, -quarters[index])  # [y, x]; y goes up, which rot90 takes for down
        expected = top_m - lift_m[index] - turned - 1
        assert np.allclose(depth[index // A_SIDE, :, index % A_SIDE], expected, atol=1e-3), index


def test_a_placement_takes_a_kilobyte_and_not_a_model() -> None:
    """Of a model of some 150 KB, 20,000 placements; what the description takes is counted."""
    if not Path("/proc/self/statm").exists():
        pytest.skip("the system does not say what a process takes")

    def memory_bytes() -> int:
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize()

    dag = voxel_dag.from_coordinates(
        np.random.default_rng(5).integers(0, 256, (100_000, 3)), voxel_dag.Config(resolution=256)
    )
    assert dag.geometry_bytes > 100_000
    session = Session()

    def place(count: int) -> None:
        objects = VoxelObjects(
            dag=dag,
            world_from_object=places(np.zeros(count), np.zeros(count)),
            object_names=tuple(f"thing {index}" for index in range(count)),
            material=0,
        )
        session.update(SceneDescription(voxel_objects=(objects,), materials=(Material(name="grey"),)), Progress())

    place(1)
    before = memory_bytes()
    place(20_000)
    assert memory_bytes() - before < 20_000 * 1024
    assert session.statistics["counts"]["voxels reused"] == 1
