# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that stand for the voxels of a file: drawn in place of their mesh, instanced, said where they cannot be."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon import panels
from addon.engine.settings import frame_window, render_config
from addon.sync.cameras import read_camera
from addon.sync.reports import Reports
from support import small_scenes
from support.recording_layout import drawn
from tyndall import Progress, voxel_dag
from tyndall.renderer import Session
from tyndall.scene_description import SceneDescription


@pytest.fixture
def dag_file(tmp_path: Path) -> Path:
    path = tmp_path / "three.tdag"
    config = voxel_dag.Config(resolution=4, bounds_m=((-1, -1, -1), (1, 1, 1)))
    voxel_dag.from_coordinates(np.array([(0, 0, 0), (1, 2, 3), (3, 3, 3)]), config).save(path)
    return path


def standing_for(path: object, location: tuple[float, float, float] = (0, 0, 0)) -> bpy.types.Object:
    small_scenes.empty_scene()
    thing = small_scenes.cube("Ruin")
    thing.location = location
    thing.tyndall_voxels.path = str(path)
    return thing


def test_an_object_stands_for_the_voxels_and_its_mesh_is_not_drawn(dag_file: Path) -> None:
    standing_for(dag_file, (1, 2, 3))
    description = small_scenes.read()
    assert description.instances == ()
    (group,) = description.voxel_objects
    assert group.object_names == ("Ruin",)
    assert group.dag.voxel_count == 3
    assert group.world_from_object[0, :3, 3].tolist() == [1, 2, 3]


def test_a_path_may_begin_in_the_folder_of_the_blend_file(dag_file: Path) -> None:
    standing_for("//three.tdag")
    bpy.ops.wm.save_as_mainfile(filepath=str(dag_file.parent / "ruin.blend"))
    assert small_scenes.read().voxel_objects[0].dag.voxel_count == 3


def test_instances_of_the_object_share_its_voxels(dag_file: Path) -> None:
    thing = standing_for(dag_file)
    collection = bpy.data.collections.new("Ruins")
    collection.objects.link(thing)
    bpy.context.scene.collection.objects.unlink(thing)
    for x in range(5):
        empty = small_scenes.add(f"Place {x}", None, (x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    groups = small_scenes.read().voxel_objects
    places = np.concatenate([group.world_from_object for group in groups])
    assert sorted(places[:, 0, 3]) == [0, 1, 2, 3, 4]
    assert len({group.dag.key for group in groups}) == 1


def test_a_file_is_read_again_when_it_has_changed_and_only_then(dag_file: Path) -> None:
    standing_for(dag_file)
    reader = small_scenes.SceneReader()

    def read() -> SceneDescription:
        return small_scenes.read(reader)

    first, same = read(), read()
    assert same.voxel_objects[0].dag is first.voxel_objects[0].dag
    voxel_dag.from_coordinates([(0, 0, 0)], voxel_dag.Config(resolution=4)).save(dag_file)
    assert read().voxel_objects[0].dag.voxel_count == 1


@pytest.mark.parametrize("content", [None, b"no voxels at all"])
def test_a_file_that_is_missing_or_damaged_is_said_once_with_its_object(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "gone.tdag"
    if content is not None:
        path.write_bytes(content)
    standing_for(path)
    description = small_scenes.read()
    assert description.instances == description.voxel_objects == ()
    (line,) = description.reports
    assert line.startswith('Object "Ruin": its voxels are left out: ')
    assert str(path) in line


def test_far_voxels_are_seen_in_the_detail_that_the_scene_asks_for(tmp_path: Path) -> None:
    """A sheet of which each 64th voxel is there covers a 64th of the picture, in whatever detail."""
    path = tmp_path / "dots.tdag"
    dots = np.array([(8 * x, 0, 8 * z) for x in range(32) for z in range(32)])
    cube = voxel_dag.Config(resolution=256, bounds_m=((-8, -8, -8), (8, 8, 8)))
    voxel_dag.from_coordinates(dots, cube).save(path)
    standing_for(path)
    camera = small_scenes.add("Camera", bpy.data.cameras.new("Camera"), (0, -50, 0))
    camera.rotation_euler = (np.pi / 2, 0, 0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 14.0
    scene = bpy.context.scene
    scene.camera = camera
    scene.render.film_transparent, scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = True, 256, 0.0
    assert drawn(panels.sampling.TYNDALL_PT_voxel_sampling) == ["voxel_detail_px"]
    session = Session()
    session.update(small_scenes.read(), Progress())
    seen = read_camera(camera.evaluated_get(bpy.context.evaluated_depsgraph_get()), scene.render, (8, 8), Reports())
    deviations = []
    for detail_px in (0.0, 2.0):
        scene.tyndall.voxel_detail_px = detail_px
        config = render_config(scene, bpy.context.view_layer, frame_window(scene.render, (8, 8)))
        alpha = session.render(seen, config, Progress()).planes["Combined"][..., 3]
        assert abs(alpha.mean() - 1 / 64) < 1 / 256
        deviations.append(alpha.std())
    assert deviations[1] < deviations[0]
