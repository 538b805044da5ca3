# SPDX-License-Identifier: GPL-3.0-or-later
"""What is read of a file that may be large: what it says of itself, and as much as a coarse picture takes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tyndall
from tyndall.voxel_dag import (
    Config,
    FileHeader,
    VoxelDag,
    checked_header,
    from_coordinates,
    load,
    load_coarse,
    read_header,
)

NOISE = np.random.default_rng(7).integers(0, 256, (50_000, 3))
KINDS = {
    "bare": Config(resolution=256),
    "all": Config(
        resolution=256,
        bounds_m=((1, 2, 3), (5, 6, 7)),
        colors=NOISE.astype(np.uint8),
        normals=NOISE - 127.5,
        normal_bits=12,
        channels={"wet": NOISE[:, 0] // 64, "\u00e9": NOISE[:, 1] // 64},
    ),
    "normals": Config(resolution=256, normals=NOISE - 127.5, normal_bits=8),
}


def saved(tmp_path: Path, kind: str = "all") -> tuple[VoxelDag, Path]:
    dag, path = from_coordinates(NOISE, KINDS[kind]), tmp_path / "noise.tdag"
    dag.save(path)
    return dag, path


def same(header: FileHeader, dag: VoxelDag) -> bool:
    names = ("resolution", "voxel_count", "node_count", "bytes_by_part", "geometry_bytes", "attribute_bytes")
    names += ("has_colors", "has_normals", "channels")
    return {name: getattr(header, name) for name in names} == {name: getattr(dag, name) for name in names} and (
        np.array_equal(header.bounds_m, dag.bounds_m)
    )


@pytest.mark.parametrize("kind", KINDS)
def test_a_header_says_what_the_whole_file_says(tmp_path: Path, kind: str) -> None:
    """And how many cubes the topmost levels have."""
    dag, path = saved(tmp_path, kind)
    for header in (read_header(path), checked_header(path)):
        assert same(header, dag)
        counts = [len(np.unique(NOISE >> (8 - level), axis=0)) for level in range(1, 9)]
        assert 3 <= len(header.top_cube_counts) < 7
        assert header.top_cube_counts == counts[: len(header.top_cube_counts)]


@pytest.mark.parametrize("resolution", [4, 8, 131_072])
@pytest.mark.parametrize("count", [0, 1])
def test_headers_of_next_to_nothing(tmp_path: Path, resolution: int, count: int) -> None:
    dag = from_coordinates(np.zeros((count, 3), np.uint32), Config(resolution=resolution))
    dag.save(tmp_path / "a.tdag")
    assert same(read_header(tmp_path / "a.tdag"), dag)


def test_geometry_is_read_alone(tmp_path: Path) -> None:
    """The same voxels, and nothing that they carry."""
    dag, path = saved(tmp_path)
    bare = load(path, attributes=False)
    assert all(np.array_equal(*parts) for parts in zip(bare.coordinates(), dag.coordinates(), strict=True))
    assert (bare.geometry_bytes, bare.attribute_bytes) == (dag.geometry_bytes, 0)
    assert not bare.has_colors


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("level", [2, 3, 5, 6, 7, 12])
@pytest.mark.parametrize("most_cubes", [100, 5_000, 10**6])
def test_what_is_read_for_a_picture_has_its_cubes_and_colours(
    tmp_path: Path, kind: str, level: int, most_cubes: int
) -> None:
    """Those of the whole file, whichever of its parts they come from."""
    dag, path = saved(tmp_path, kind)
    coarse = load_coarse(path, level, most_cubes)
    cubes, found = dag.coarse_cubes(level, most_cubes)
    its_cubes, its_level = coarse.coarse_cubes(level, most_cubes)
    assert its_level == found
    assert np.array_equal(its_cubes, cubes)
    assert coarse.has_colors == dag.has_colors
    if dag.has_colors:
        doublings = coarse.resolution.bit_length() - 1 - found
        its_colors = coarse.colors_at(its_cubes << np.uint32(doublings), found)
        assert np.array_equal(its_colors, dag.colors_at(cubes << np.uint32(8 - found), found))


@pytest.mark.parametrize("level", [0, 1])
def test_the_coarsest_levels_have_about_their_colours(tmp_path: Path, level: int) -> None:
    dag, path = saved(tmp_path)
    coarse = load_coarse(path, level, 100)
    cubes, found = coarse.coarse_cubes(level, 100)
    assert found == level
    colors = coarse.colors_at(cubes << np.uint32(coarse.resolution.bit_length() - 1 - level), level)
    assert np.abs(colors.astype(int) - dag.colors_at(cubes << np.uint32(8 - level), level)).max() <= 4


def test_what_is_not_needed_is_not_read(tmp_path: Path) -> None:
    """With zeros behind the geometry, its topmost levels and the geometry are read; a checked header is refused."""
    dag, path = saved(tmp_path)
    content = path.read_bytes()
    path.write_bytes(content[: -dag.attribute_bytes // 2] + bytes(dag.attribute_bytes // 2))
    assert same(read_header(path), dag)
    assert load_coarse(path, 3, 10**6).voxel_count == 8**3
    assert load(path, attributes=False).voxel_count == dag.voxel_count
    for refused in (load, checked_header, lambda path: load_coarse(path, 8, 10**6)):
        with pytest.raises(tyndall.IoError, match=r"noise\.tdag.*damaged"):
            refused(path)


@pytest.mark.parametrize("at", [0, 8, 12, 50, 60, 100, 103, 104, 120, 200])
def test_a_damaged_header_is_refused(tmp_path: Path, at: int) -> None:
    """Whichever byte it is; and one that ends too soon, or goes on."""
    _dag, path = saved(tmp_path)
    content = bytearray(path.read_bytes())
    content[at] ^= 1
    path.write_bytes(content)
    with pytest.raises(tyndall.IoError, match=r"noise\.tdag: it"):
        read_header(path)
    content[at] ^= 1
    for other in (content[:at], content + b"1"):
        path.write_bytes(other)
        with pytest.raises(tyndall.IoError, match=r"noise\.tdag: it"):
            read_header(path)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(tyndall.IoError, match=r"gone\.tdag: No such file"):
        read_header(tmp_path / "gone.tdag")


def test_checking_stops_when_it_is_cancelled(tmp_path: Path) -> None:
    progress = tyndall.Progress()
    progress.cancel()
    with pytest.raises(tyndall.Cancelled):
        checked_header(saved(tmp_path)[1], progress)
