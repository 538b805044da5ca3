# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenVDB files between Blender and us: each reads what the other wrote, at the same place."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np
import pytest

from addon.shader_nodes import use_nodes
from support.cycles_reference import prepare_cycles, rendered_pixels
from support.small_scenes import add, empty_scene
from tyndall.volumes import from_dense, grid_infos, read_vdb, to_dense, write_vdb

#: A quarter turn about z, voxels of 5 cm, and a shift.
TURNED = np.array([[0.0, -0.05, 0.0, 0.3], [0.05, 0.0, 0.0, -0.2], [0.0, 0.0, 0.05, 0.1], [0.0, 0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def openvdb() -> ModuleType:
    """Blender's own module, with its own OpenVDB beside ours in this process."""
    folder = Path(bpy.utils.resource_path("LOCAL")) / "python/lib/python3.11/site-packages"
    if not list(folder.glob("openvdb.*.so")):
        pytest.skip("this Blender has no module openvdb")
    sys.path.append(str(folder))
    try:
        import openvdb as module  # noqa: PLC0415 - Blender's folder is on the path now
    finally:
        sys.path.remove(str(folder))
    return module


def blenders_volume(path: Path) -> bpy.types.Object:
    """An object of the file, at (1, 2, 3)."""
    volume = bpy.data.volumes.new("Fog")
    volume.filepath = str(path)
    assert volume.grids.load()
    thing = add("Fog", volume, (1.0, 2.0, 3.0))
    bpy.context.view_layer.update()
    return thing


@pytest.mark.parametrize("is_half", [False, True])
def test_we_read_what_blenders_openvdb_wrote(openvdb: ModuleType, tmp_path: Path, is_half: bool) -> None:  # noqa: FBT001
    """Voxels, a constant tile, the background and the transform; OpenVDB multiplies matrices from the left."""
    values = np.random.default_rng(1).random((5, 6, 7), np.float32).astype(np.float16).astype(np.float32)
    grid = openvdb.FloatGrid(0.25)
    grid.name = "density"
    grid.fill((0, 0, 0), (47, 15, 7), 2.0)
    grid.copyFromArray(values, ijk=(-20, 3, -30))
    grid.transform = openvdb.createLinearTransform(TURNED.T.tolist())
    grid.saveFloatAsHalf = is_half
    velocity = openvdb.Vec3SGrid((0.0, 0.0, 0.0))
    velocity.name = "velocity"
    velocity.fill((0, 0, 0), (0, 0, 0), (1.0, 2.0, 3.0))
    openvdb.write(str(tmp_path / "a.vdb"), grids=[grid, velocity])

    read = read_vdb(tmp_path / "a.vdb")
    assert list(read) == ["density", "velocity.x", "velocity.y", "velocity.z"]
    density = read["density"]
    assert density.background == 0.25
    np.testing.assert_array_equal(density.local_from_index, TURNED)
    np.testing.assert_array_equal(to_dense(density, ((-20, 3, -30), (-15, 9, -23)))[0], values)
    assert (to_dense(density, ((0, 0, 0), (48, 16, 8)))[0] == 2.0).all()
    assert (to_dense(density, ((0, 16, 0), (48, 24, 8)))[0] == 0.25).all()
    assert to_dense(read["velocity.y"], ((0, 0, 0), (1, 1, 2)))[0].ravel().tolist() == [2.0, 0.0]
    assert [info.is_half for info in grid_infos(tmp_path / "a.vdb")] == [is_half, is_half and False]


def test_blenders_openvdb_reads_what_we_wrote(openvdb: ModuleType, tmp_path: Path) -> None:
    values = np.random.default_rng(2).normal(size=(20, 9, 13)).astype(np.float32)
    written = from_dense("density", values, TURNED, first_index=(-11, 4, -100), background=0.5)
    write_vdb(tmp_path / "a.vdb", [written])
    grid = openvdb.read(str(tmp_path / "a.vdb"), "density")
    found = np.empty_like(values)
    grid.copyToArray(found, ijk=(-11, 4, -100))
    np.testing.assert_array_equal(found, values)
    assert grid.background == 0.5
    assert grid.gridClass == openvdb.GridClass.FOG_VOLUME
    assert grid.evalActiveVoxelBoundingBox() == ((-11, 4, -100), (8, 12, -88))
    np.testing.assert_allclose(grid.transform.indexToWorld((3, 5, 7)), (TURNED @ [3, 5, 7, 1])[:3], rtol=1e-15)


def test_blender_shows_our_grids_by_name_and_in_their_place(tmp_path: Path) -> None:
    """Its bounding box holds the centres of the active voxels, and no more than their leaves."""
    empty_scene()
    values = np.ones((10, 20, 30), np.float32)
    write_vdb(
        tmp_path / "a.vdb",
        [from_dense("density", values, TURNED, first_index=(-5, 0, 3)), from_dense("level", values[:1], TURNED)],
    )
    thing = blenders_volume(tmp_path / "a.vdb")
    grids = thing.data.grids
    assert [(grid.name, grid.data_type, grid.channels) for grid in grids] == [
        ("density", "FLOAT", 1),
        ("level", "FLOAT", 1),
    ]
    np.testing.assert_allclose(np.array(grids["density"].matrix_object), TURNED, atol=1e-7)
    found = np.array(thing.bound_box).T

    def bounds(first: tuple[float, ...], last: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        corners = np.array(np.meshgrid(*zip(first, last, strict=True))).reshape(3, 8)
        points = (TURNED @ np.vstack([corners, np.ones(8)]))[:3]
        return points.min(axis=1), points.max(axis=1)

    lowest, highest = bounds((-5, 0, 3), (4, 19, 32))
    lowest_of_leaves, highest_of_leaves = bounds((-8.5, -0.5, -0.5), (8, 24, 40))
    assert (found.min(axis=1) <= lowest + 1e-6).all()
    assert (found.min(axis=1) >= lowest_of_leaves - 1e-6).all()
    assert (found.max(axis=1) >= highest - 1e-6).all()
    assert (found.max(axis=1) <= highest_of_leaves + 1e-6).all()


@pytest.mark.dealt
def test_cycles_renders_our_grid_where_it_should_be(tmp_path: Path) -> None:
    """A block that swallows light, 20 cm by 40 cm, seen from above before a white world."""
    scene = empty_scene(size_px=32)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.camera.location = (1.0, 2.0, 8.0)
    scene.camera.data.ortho_scale = 1.6
    write_vdb(tmp_path / "a.vdb", [from_dense("density", np.ones((8, 4, 4), np.float32), TURNED)])
    material = bpy.data.materials.new("Soot")
    use_nodes(material)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    soot = nodes.new("ShaderNodeVolumePrincipled")
    soot.inputs["Color"].default_value = (0, 0, 0, 1)
    soot.inputs["Density"].default_value = 500.0
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    for link in list(output.inputs["Surface"].links):
        links.remove(link)
    links.new(soot.outputs["Volume"], output.inputs["Volume"])
    thing = blenders_volume(tmp_path / "a.vdb")
    thing.data.materials.append(material)
    prepare_cycles(scene, samples=8, seed=1)
    picture = rendered_pixels(scene)[..., 0]

    centres = (np.arange(32) + 0.5) / 32 * 1.6 - 0.8

    # In the object's space x falls with the index y, from 0.3 by 4 voxels of 5 cm, and y rises with x, from -0.2 by 8.
    def distance_inside(at: np.ndarray, begin: float, end: float) -> np.ndarray:
        return np.minimum(at - begin, end - at)

    across, up = distance_inside(centres, 0.125, 0.325), distance_inside(centres, -0.225, 0.175)
    inside = np.minimum(across[None, :], up[:, None])
    # Density fades over half a voxel around the block, and a pixel is 5 cm wide.
    assert (picture[inside > 0.06] < 0.01).all()
    assert (picture[inside < -0.06] > 0.99).all()
    assert (inside > 0.06).sum() == 5
