# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours, normals and channels of voxels, from Python: as given, on average, through files, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tyndall
from tyndall.voxel_dag import Config, VoxelDag, from_coordinates, load

COUNT = 4000
VOXELS = np.unique(np.random.default_rng(1).integers(0, 64, (COUNT, 3)), axis=0)
RANDOM = np.random.default_rng(2)
COLORS = RANDOM.integers(0, 256, (len(VOXELS), 3)).astype(np.uint8)
NORMALS = RANDOM.normal(size=(len(VOXELS), 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
WET = RANDOM.integers(0, 256, len(VOXELS))


def all_kinds(**changes: object) -> VoxelDag:
    given = {"resolution": 64, "colors": COLORS, "normals": NORMALS, "channels": {"wet": WET}}
    return from_coordinates(VOXELS, Config(**given | changes))


def degrees(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=1) / 2, 0, 1)))


@pytest.mark.parametrize("symmetry", ["none", "reflections", "cube"])
def test_every_voxel_has_what_was_given_through_a_file_too(symmetry: str, tmp_path: Path) -> None:
    dag = all_kinds(symmetry=symmetry)
    dag.save(tmp_path / "a.tdag")
    again = load(tmp_path / "a.tdag")
    for kept in (dag, again):
        assert kept.has_colors
        assert kept.has_normals
        assert kept.channels == ["wet"]
        assert np.array_equal(kept.colors_at(VOXELS), COLORS)
        assert degrees(kept.normals_at(VOXELS), NORMALS).max() < 0.0026
        assert np.array_equal(kept.channel_at("wet", VOXELS), WET)
        assert kept.attribute_errors == dict.fromkeys(kept.attribute_errors, 0.0)
    assert again.bytes_by_part == dag.bytes_by_part
    assert sum(dag.bytes_by_part.values()) == dag.geometry_bytes + dag.attribute_bytes
    assert (tmp_path / "a.tdag").stat().st_size < dag.geometry_bytes + dag.attribute_bytes + 4096


def test_colors_from_0_to_1_are_those_of_bytes_and_arrays_may_lie_in_memory_as_they_like() -> None:
    dag = all_kinds(colors=(COLORS / 255).astype(np.float32))
    assert np.array_equal(dag.colors_at(VOXELS), COLORS)
    columns = {"colors": np.asfortranarray(COLORS / 255), "normals": np.asfortranarray(NORMALS)}
    dag = all_kinds(**columns, channels={"wet": np.repeat(WET, 2)[::2]})
    assert np.array_equal(dag.colors_at(np.asfortranarray(VOXELS)), COLORS)
    assert np.array_equal(dag.channel_at("wet", VOXELS), WET)


def test_of_a_voxel_that_repeats_the_last_row_counts() -> None:
    dag = from_coordinates([[1, 2, 3], [0, 0, 0], [1, 2, 3]], Config(resolution=4, colors=np.eye(3)))
    assert dag.colors_at([[1, 2, 3], [0, 0, 0]]).tolist() == [[0, 0, 255], [0, 255, 0]]


def linear(encoded: np.ndarray) -> np.ndarray:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("level", [0, 1, 2, 3, 4, 5])
def test_a_level_has_means_in_linear_light(level: int) -> None:
    dag = all_kinds()
    _, cube = np.unique(VOXELS >> (6 - level), axis=0, return_inverse=True)
    cube = cube.reshape(-1)
    counts = np.bincount(cube)
    light = np.stack([np.bincount(cube, linear(COLORS[:, i] / 255)) / counts for i in range(3)], -1)[cube]
    found = dag.colors_at(VOXELS, level=level)
    below, above = (linear(np.clip((found + side) / 255, 0, 1)) for side in (-0.52, 0.52))
    assert ((below <= light) & (light <= above)).all()
    sums = np.stack([np.bincount(cube, NORMALS[:, i]) for i in range(3)], -1)[cube]
    means = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    assert degrees(dag.normals_at(VOXELS, level=level), means).max() < 0.7
    wet = (np.bincount(cube, WET) / counts)[cube]
    assert np.abs(dag.channel_at("wet", VOXELS, level=level) - wet).max() <= 0.5


def test_fewer_colors_and_bits_are_smaller_and_say_what_was_lost() -> None:
    lossless = all_kinds()
    few = all_kinds(color_count=16, normal_bits=8)
    assert len(np.unique(few.colors_at(VOXELS), axis=0)) <= 16
    assert few.attribute_bytes < lossless.attribute_bytes
    lost = degrees(few.normals_at(VOXELS), NORMALS)
    np.testing.assert_allclose(few.attribute_errors["most_degrees"], lost.max(), atol=0.01)
    np.testing.assert_allclose(few.attribute_errors["mean_degrees"], lost.mean(), atol=0.01)
    near = all_kinds(most_color_difference=2.0)
    assert 0 < near.attribute_errors["mean_cie94"] <= near.attribute_errors["most_cie94"] <= 2.0


def test_without_attributes_there_are_none() -> None:
    dag = from_coordinates(VOXELS, Config(resolution=64))
    assert (dag.attribute_bytes, dag.channels, dag.has_colors, dag.has_normals) == (0, [], False, False)
    assert sum(dag.bytes_by_part.values()) == dag.geometry_bytes
    with pytest.raises(tyndall.InvalidInput, match="no attributes"):
        dag.colors_at(VOXELS)
    with pytest.raises(tyndall.InvalidInput, match="no normals"):
        all_kinds(normals=None).normals_at(VOXELS)
    with pytest.raises(tyndall.InvalidInput, match="no channel 'dry'"):
        all_kinds().channel_at("dry", VOXELS)


def test_the_first_voxel_that_is_not_set_is_named() -> None:
    with pytest.raises(tyndall.InvalidInput, match=r"voxel 1 .*\(64, 0, 0\), is not set"):
        all_kinds().colors_at([VOXELS[0], [64, 0, 0], [65, 0, 0]])


@pytest.mark.parametrize(
    ("changes", "culprit"),
    [
        ({"colors": COLORS[:-1]}, "colors have the shape"),
        ({"colors": COLORS.astype(np.int32)}, "colors are int32"),
        ({"colors": np.where(np.arange(len(VOXELS))[:, None] == 7, 1.5, 0.5) * [1, 1, 1]}, "colors: row 7"),
        ({"colors": np.full((len(VOXELS), 3), np.nan)}, "colors: row 0"),
        ({"normals": NORMALS[1:]}, "normals have the shape"),
        ({"normals": np.where(np.arange(len(VOXELS))[:, None] == 3, 0, NORMALS)}, "normal 3"),
        ({"channels": {"wet": WET[1:]}}, "'wet'"),
        ({"channels": {"wet": WET + 1}}, "beyond"),
        ({"channels": {"wet": WET / 255}}, "float64"),
        ({"channels": {str(i): WET for i in range(5)}}, "5 channels"),
        ({"channels": {"": WET}}, "no name"),
        ({"color_count": 0}, "color_count"),
        ({"color_count": 2, "most_color_difference": 1.0}, "one of them"),
        ({"most_color_difference": 1000.0}, "1000"),
        ({"normal_bits": 7}, "normal_bits is 7"),
    ],
)
def test_a_wrong_array_or_setting_is_named(changes: dict[str, object], culprit: str) -> None:
    with pytest.raises(tyndall.InvalidInput, match=culprit):
        all_kinds(**changes)
