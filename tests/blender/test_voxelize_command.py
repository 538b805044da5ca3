# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m tyndall voxelize`` on a .blend: what a render would show of it, in the world's metres."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from support.small_scenes import CUBE_CORNERS, CUBE_FACES, add, cube, empty_scene, mesh
from tyndall.command_line import BAD_USAGE, SUCCESS, main
from tyndall.voxel_dag import Config, load, voxelize


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    """Cubes at x = 0 and 4 of a modifier, and one at y = 6 of an instance; one that renders do not show."""
    empty_scene()
    array = cube().modifiers.new("Array", "ARRAY")
    array.count, array.use_relative_offset, array.use_constant_offset = 2, False, True
    array.constant_offset_displace = (4, 0, 0)
    collection = bpy.data.collections.new("Instanced")
    collection.objects.link(bpy.data.objects.new("Inner", mesh("Inner", CUBE_CORNERS, CUBE_FACES)))
    instance = add("Instance", None, (0, 6, 0))
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    hidden = cube("Hidden")
    hidden.location, hidden.hide_render = (0, 0, 50), True
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def test_a_scene_becomes_voxels_with_its_modifiers_and_instances(blend: Path) -> None:
    out = blend.with_suffix(".tdag")
    assert main(["voxelize", str(blend), "--resolution", "128", "--rule", "conservative", "--out", str(out)]) == SUCCESS
    centres = ((0, 0, 0), (4, 0, 0), (0, 6, 0))
    positions_m = np.concatenate([np.add(CUBE_CORNERS, centre) for centre in centres])
    quads = np.concatenate([np.array(CUBE_FACES) + 8 * i for i in range(3)])
    triangles = np.concatenate([quads[:, :3], quads[:, (0, 2, 3)]])
    wanted, made = voxelize(positions_m, triangles, Config(resolution=128, rule="conservative")), load(out)
    np.testing.assert_allclose(made.bounds_m, wanted.bounds_m, atol=1e-6)
    assert np.array_equal(np.concatenate(list(made.coordinates())), np.concatenate(list(wanted.coordinates())))


def test_the_colours_of_materials_and_smooth_normals_go_along(blend: Path) -> None:
    red = bpy.data.materials.new("Red")
    red.use_nodes = True
    red.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (1, 0, 0, 1)
    bpy.data.objects["Cube"].data.materials.append(red)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
    out = blend.with_suffix(".tdag")
    arguments = ["voxelize", str(blend), "--resolution", "128", "--out", str(out)]
    assert main([*arguments, "--colors", "--normals", "--normal-bits", "16"]) == SUCCESS
    made = load(out)
    voxels = np.concatenate(list(made.coordinates()))
    (lower_m, upper_m), colors = np.array(made.bounds_m), made.colors_at(voxels)
    is_instance = voxels[:, 1] > 128 * (4 - lower_m[1]) / (upper_m - lower_m)[1]
    assert (colors[~is_instance] == [255, 0, 0]).all()
    assert (colors[is_instance] != [255, 0, 0]).any(axis=1).all()
    inner = ((voxels > 2) & (voxels < 30)).sum(axis=1) == 2  # of one side each, away from its edges
    assert inner.any()
    assert np.allclose(np.abs(made.normals_at(voxels[inner])).max(axis=1), 1, atol=1e-3)


def test_a_scene_that_is_not_there_is_named(blend: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = blend.with_suffix(".tdag")
    assert main(["voxelize", str(blend), "--resolution", "64", "--scene", "Attic", "--out", str(out)]) == BAD_USAGE
    assert 'no scene "Attic"' in capsys.readouterr().err
    assert not out.exists()
