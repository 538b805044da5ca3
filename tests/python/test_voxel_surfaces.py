# SPDX-License-Identifier: GPL-3.0-or-later
"""What voxels of meshes carry, and solids, from Python: closed forms, files of pictures, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tyndall
from tyndall import _image_io
from tyndall.voxel_dag import Config, Material, Textures, VoxelDag, load, voxelize

#: The floor of a cube of 64 voxels, and 16 voxels more around it: two triangles.
FLOOR = np.array([[-16, -16, 20.5], [80, -16, 20.5], [80, 80, 20.5], [-16, 80, 20.5]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
UVS = (FLOOR[:, :2] / 64)[TWO]
CUBE = 10.0 + 30.0 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
CUBE_TRIANGLES = np.array(
    [
        corners
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        for corners in ((a, b, c), (a, c, d))
    ]
)
BOUNDS = ((0, 0, 0), (64, 64, 64))


def floor(**settings: Any) -> VoxelDag:
    return voxelize(FLOOR, TWO, Config(resolution=64, bounds_m=BOUNDS, **settings))


def voxels_of(dag: VoxelDag) -> np.ndarray:
    return np.concatenate(list(dag.coordinates()))


def light(encoded: np.ndarray) -> np.ndarray:
    values = encoded / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def test_colours_of_vertices_are_mixed_as_light_and_kept_in_the_file(tmp_path: Path) -> None:
    for colors in (np.array([[0, 0, 0], [255, 0, 0]], np.uint8), np.array([[0, 0, 0], [1.0, 0, 0]])):
        dag = floor(colors=colors[[0, 1, 1, 0]], channels={"roughness": [255, 0, 0, 255]})
        dag.save(tmp_path / "floor.tdag")
        for kept in (dag, load(tmp_path / "floor.tdag")):
            voxels = voxels_of(kept)
            assert len(voxels) == 64 * 64
            along = (voxels[:, 0] + 16.5) / 96
            assert np.abs(light(kept.colors_at(voxels)[:, 0]) - along).max() < 0.0045
            assert (kept.colors_at(voxels)[:, 1:] == 0).all()
            assert np.abs(kept.channel_at("roughness", voxels) / 255 - (1 - along)).max() <= 0.5 / 255 + 1e-6


def test_normals_are_those_of_vertices_or_of_faces() -> None:
    def at(dag: VoxelDag, *voxel: int) -> list[float]:
        return dag.normals_at(np.array([voxel]))[0].tolist()

    cube = voxelize(CUBE, CUBE_TRIANGLES, Config(resolution=64, bounds_m=BOUNDS, normals="faces"))
    assert at(cube, 40, 20, 20) == [1, 0, 0]
    assert at(cube, 10, 20, 20) == [-1, 0, 0]
    assert at(cube, 20, 20, 10) == [0, 0, -1]
    leaning = floor(normals=[[0, 3, 4]] * 4)
    assert np.allclose(leaning.normals_at(voxels_of(leaning)), [0, 0.6, 0.8], atol=1e-4)


@pytest.mark.parametrize("kind", ["bytes", "floats", "png", "exr", "grey"])
def test_a_picture_is_laid_on_by_the_corners(kind: str, tmp_path: Path) -> None:
    """Of 64 x 64 texels, so that each voxel has one: as bytes and files encode them, or linear as floats."""
    encoded = np.random.default_rng(1).integers(0, 256, (64, 64, 3), np.uint8)
    if kind == "grey":
        encoded[:] = encoded[:, :, :1]
    linear = light(encoded).astype(np.float32)
    picture: Any = {"bytes": encoded, "floats": linear, "grey": encoded[:, :, 0]}.get(kind, tmp_path / f"a.{kind}")
    if kind == "png":
        _image_io.write_png(picture, encoded)
    if kind == "exr":
        _image_io.write_exr(picture, [("", "RGB", linear)])
    dag = floor(textures=Textures(materials=[Material(picture=picture)], corner_uvs=UVS))
    voxels = voxels_of(dag)
    colors = dag.colors_at(voxels).astype(int)
    assert np.abs(colors - encoded[voxels[:, 1], voxels[:, 0]].astype(int)).max() <= 1


def test_each_triangle_has_its_material() -> None:
    materials = [Material(color=(1, 0, 0)), Material(picture=np.full((2, 2, 4), [0, 255, 0, 7], np.uint8))]
    dag = floor(textures=Textures(materials=materials, corner_uvs=UVS, material_of_triangle=[1, 0]))
    voxels = voxels_of(dag)
    colors = dag.colors_at(voxels)
    assert (colors[voxels[:, 0] > voxels[:, 1] + 1] == [0, 255, 0]).all()
    assert (colors[voxels[:, 0] + 1 < voxels[:, 1]] == [255, 0, 0]).all()


def test_colours_and_channels_of_vertices_are_multiplied_with_those_of_materials() -> None:
    """As light, and as numbers; a picture of one, a number of the other; what neither says is 0."""
    encoded = np.random.default_rng(1).integers(0, 256, (64, 64, 3), np.uint8)
    grey = np.random.default_rng(2).integers(0, 256, (64, 64), np.uint8)
    materials = [
        Material(picture=encoded, channels={"roughness": 0.5, "wet": grey}),
        Material(color=(0.5, 1.0, 0.0), channels={"wet": 0.25}),
    ]
    black_to_red = np.array([[0, 0, 0], [1.0, 0.5, 0.25], [1.0, 0.5, 0.25], [0, 0, 0]])
    dag = floor(
        textures=Textures(materials=materials, corner_uvs=UVS, material_of_triangle=[0, 1]),
        colors=black_to_red,
        channels={"roughness": [0, 200, 200, 0]},
    )
    voxels = voxels_of(dag)
    along = (voxels[:, :1] + 16.5) / 96
    first, second = voxels[:, 0] > voxels[:, 1] + 1, voxels[:, 0] + 1 < voxels[:, 1]
    of_vertices = along * light(255 * black_to_red[1])
    of_pictures = light(encoded[voxels[:, 1], voxels[:, 0]])
    colors = light(dag.colors_at(voxels))
    assert np.abs(colors - of_vertices * of_pictures)[first].max() < 0.005
    assert np.abs(colors - of_vertices * light(255 * np.array([0.5, 1.0, 0.0])))[second].max() < 0.005
    assert dag.channels == ["roughness", "wet"]
    roughness, wet = (dag.channel_at(name, voxels).astype(float) for name in dag.channels)
    assert np.abs(roughness - 100 * along[:, 0])[first].max() < 0.51
    assert np.abs(roughness - 200 * along[:, 0])[second].max() < 0.51
    assert np.abs(wet - grey[voxels[:, 1], voxels[:, 0]])[first].max() < 0.51
    assert (wet[second] == 64).all()


def test_materials_may_give_channels_and_no_colours() -> None:
    dag = floor(
        textures=Textures(materials=[Material(channels={"metallic": 1.0}), Material()], material_of_triangle=[0, 1])
    )
    voxels = voxels_of(dag)
    assert not dag.has_colors
    metallic = dag.channel_at("metallic", voxels)
    assert (metallic[voxels[:, 0] > voxels[:, 1] + 1] == 255).all()
    assert (metallic[voxels[:, 0] + 1 < voxels[:, 1]] == 0).all()


def test_beyond_a_clipped_picture_all_is_black() -> None:
    white = np.full((8, 8, 3), 255, np.uint8)
    for outside, wanted in (("clip", 0), ("repeat", 255), ("extend", 255), ("mirror", 255)):
        dag = floor(textures=Textures(materials=[Material(picture=white, outside=outside)], corner_uvs=2 * UVS))
        assert (dag.colors_at([[50, 50, 20], [50, 5, 20]]) == wanted).all()
        assert (dag.colors_at([[5, 5, 20]]) == 255).all()


def test_a_solid_cube_has_all_its_voxels() -> None:
    solid = voxelize(CUBE, CUBE_TRIANGLES, Config(resolution=64, bounds_m=BOUNDS, solid=True))
    assert solid.voxel_count == 31**3
    assert solid.contains([[25, 25, 25], [10, 10, 10], [40, 40, 40]]).all()
    assert not solid.contains([[9, 25, 25], [41, 25, 25]]).any()
    whole = voxelize(CUBE, CUBE_TRIANGLES, Config(resolution=512, solid=True))
    assert whole.voxel_count == 512**3
    assert whole.node_count < 20


def test_what_is_wrong_is_named(tmp_path: Path) -> None:
    refused = [
        ({"colors": [[0, 0, 0]] * 3}, r"colors have the shape \(3, 3\), not 4 rows"),
        ({"normals": [[0, 0, 1], [0, 0, 1], [0, float("nan"), 1], [0, 0, 1]]}, r"normals: vertex 2 has \(0, nan, 1\)"),
        ({"normals": "vertices"}, "normals is 'vertices', neither \"faces\""),
        ({"channels": {name: [0] * 4 for name in "abcde"}}, "there are 5 channels; at most 4 are possible"),
        (
            {"textures": Textures(materials=[Material(color=(1, 1, 1), channels={"wet": 2.0})])},
            'material 0 has 2 for channel "wet", outside',
        ),
        (
            {"textures": Textures(materials=[Material(channels={"wet": np.zeros((2, 2, 3))})])},
            'material 0: channel "wet" is float64 \\(2, 2, 3\\), neither a number nor a picture',
        ),
        (
            {"textures": Textures(materials=[Material(channels={"wet": [[0.0, 1.5]]})], corner_uvs=UVS)},
            'material 0: channel "wet" has values outside',
        ),
        ({"colors": [[0, 0, 0]] * 4, "solid": True}, "voxels inside of a solid have no surface"),
        ({"solid": True}, r"does not close.*edge of triangle 0 from \(-16, -16, 20.5\) m to \(80, -16, 20.5\) m"),
        ({"textures": Textures(materials=[Material()])}, "material 0 has to have either a color or a picture"),
        ({"textures": Textures(materials=[])}, "no materials"),
        (
            {"textures": Textures(materials=[Material(picture=np.zeros((2, 2), np.uint8), outside="mirrored")])},
            "outside is 'mirrored', not one of repeat, extend, clip, mirror",
        ),
        ({"textures": Textures(materials=[Material(picture=np.zeros((2, 2, 5), np.uint8))])}, r"shape \(2, 2, 5\)"),
        (
            {"textures": Textures(materials=[Material(picture=[[0.0, float("nan")]])], corner_uvs=UVS)},
            "material 0: the picture is not finite in row 0, column 1",
        ),
        (
            {"textures": Textures(materials=[Material(picture=np.zeros((2, 2), np.uint8))])},
            "corner_uvs: 0 for 6 corners of triangles",
        ),
        (
            {"textures": Textures(materials=[Material(color=(1, 1, 1))], corner_uvs=UVS[:, :2])},
            r"not numbers \(m, 3, 2\)",
        ),
        (
            {"textures": Textures(materials=[Material(color=(1, 1, 1))], material_of_triangle=[0, 3])},
            "triangle 1 has material 3; there are 1",
        ),
    ]
    for settings, message in refused:
        with pytest.raises(tyndall.InvalidInput, match=message):
            floor(**settings)
    with pytest.raises(tyndall.IoError, match=r"missing\.png"):
        floor(textures=Textures(materials=[Material(picture=tmp_path / "missing.png")], corner_uvs=UVS))
    with pytest.raises(tyndall.InvalidInput, match="for meshes"):
        tyndall.voxel_dag.from_coordinates([[0, 0, 0]], Config(resolution=4, solid=True))
    with pytest.raises(tyndall.InvalidInput, match="does not close"):
        tyndall.voxel_dag.voxelize_to_file(FLOOR, TWO, tmp_path / "floor.tdag", Config(resolution=64, solid=True))
