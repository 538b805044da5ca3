# SPDX-License-Identifier: GPL-3.0-or-later
"""MagicaVoxel files: written byte by byte here, those of the world where they are there, and back from voxels."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np
import pytest

import tyndall
from support.full_disk import largest_file
from tyndall.voxel_dag import Config, VoxelDag, from_array, from_coordinates, import_vox, load

DATA = Path(os.environ.get("TYNDALL_SHARED_DATA", Path(__file__).parents[3] / "shared" / "data"))


def chunk(name: bytes, content: bytes, children: bytes = b"") -> bytes:
    return name + struct.pack("<ii", len(content), len(children)) + content + children


def vox_file(chunks: bytes) -> bytes:
    return b"VOX " + struct.pack("<i", 150) + chunk(b"MAIN", b"", chunks)


def model(sides: tuple[int, int, int], voxels: np.ndarray) -> bytes:
    """Voxels: x, y, z and colour, (n, 4)."""
    size = chunk(b"SIZE", struct.pack("<iii", *sides))
    return size + chunk(b"XYZI", struct.pack("<i", len(voxels)) + voxels.astype(np.uint8).tobytes())


def all_of(dag: VoxelDag) -> np.ndarray:
    return np.concatenate([*dag.coordinates(), np.zeros((0, 3), np.uint32)])


def in_any_order(voxels: np.ndarray) -> np.ndarray:
    return np.unique(voxels.astype(np.int64), axis=0)


def test_a_model_comes_in_with_its_voxels_and_its_colours(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    places = in_any_order(random.integers(0, (20, 30, 200), (500, 3)))
    places = places[random.permutation(len(places))]
    colors = random.integers(1, 256, len(places))
    palette = random.integers(0, 256, (256, 4)).astype(np.uint8)
    (tmp_path / "a.vox").write_bytes(
        vox_file(model((20, 30, 200), np.column_stack([places, colors])) + chunk(b"RGBA", palette.tobytes()))
    )
    dag = import_vox(tmp_path / "a.vox", voxel_size_m=0.1)
    lowest = places.min(axis=0)
    assert np.array_equal(in_any_order(all_of(dag) + lowest), in_any_order(places))
    np.testing.assert_allclose(dag.bounds_m[0], lowest * 0.1)
    np.testing.assert_allclose(dag.bounds_m[1], lowest * 0.1 + dag.resolution * 0.1)
    assert np.array_equal(dag.colors_at(places - lowest), palette[colors - 1, :3])


@pytest.mark.parametrize("name", ["monu6", "monu8"])
def test_a_monument_comes_in_and_goes_out_as_it_is(name: str, tmp_path: Path) -> None:
    path = DATA / "voxel_models" / f"{name}.vox"
    if not path.exists():
        pytest.skip(f"{path} is not there: set TYNDALL_SHARED_DATA")
    content = path.read_bytes()
    at = content.index(b"XYZI") + 16
    count = struct.unpack("<i", content[at - 4 : at])[0]
    voxels = np.frombuffer(content, np.uint8, 4 * count, at).reshape(-1, 4)
    palette = np.frombuffer(content, np.uint8, 1024, content.index(b"RGBA") + 12).reshape(-1, 4)
    dag = import_vox(path)
    lowest = voxels[:, :3].min(axis=0)
    assert dag.voxel_count == count
    assert dag.contains(voxels[:, :3] - lowest).all()
    wanted = palette[voxels[:, 3].astype(int) - 1, :3]
    assert np.array_equal(dag.colors_at(voxels[:, :3] - lowest), wanted)
    dag.to_vox(tmp_path / "again.vox")
    again = import_vox(tmp_path / "again.vox")
    assert np.array_equal(again.bounds_m, dag.bounds_m)
    assert np.array_equal(again.colors_at(voxels[:, :3] - lowest), wanted)
    assert (again.voxel_count, again.node_count) == (dag.voxel_count, dag.node_count)


def test_voxels_beyond_256_a_side_go_into_several_models_and_come_back(tmp_path: Path) -> None:
    voxels = in_any_order(np.random.default_rng(2).integers(0, 700, (4000, 3)))
    bounds_m = np.array([[-3.5, 2.0, 10.0], [508.5, 514.0, 522.0]])
    dag = from_coordinates(voxels, Config(resolution=1024, bounds_m=bounds_m))
    dag.to_vox(tmp_path / "a.vox")
    assert (tmp_path / "a.vox").read_bytes().count(b"XYZI") == 27
    again = import_vox(tmp_path / "a.vox", voxel_size_m=0.5)
    moved = np.round((again.bounds_m[0] - bounds_m[0]) / 0.5).astype(int)
    assert np.array_equal(in_any_order(all_of(again) + moved), voxels)


def test_more_colours_than_a_palette_holds_are_refused_unless_they_may_be_quantized(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    is_set = random.random((16, 16, 16)) < 0.3
    colors = random.integers(0, 256, (16, 16, 16, 3)).astype(np.uint8)
    dag = from_array(is_set, colors=colors)
    places = np.argwhere(is_set)
    assert np.array_equal(dag.colors_at(places), colors[is_set])
    with pytest.raises(tyndall.InvalidInput, match=r"colours; a \.vox file has 255"):
        dag.to_vox(tmp_path / "a.vox")
    assert not (tmp_path / "a.vox").exists()
    dag.to_vox(tmp_path / "a.vox", quantize=True)
    again = import_vox(tmp_path / "a.vox")
    read = again.colors_at(places - places.min(axis=0)).astype(int)
    assert len(np.unique(read, axis=0)) == 255
    off = np.abs(read - colors[is_set]).max(axis=1)
    assert 0 < np.median(off) < 30
    assert off.max() < 120


def test_a_damaged_file_is_named_with_the_chunk_and_scenes_too_large_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.vox"
    good = vox_file(model((2, 2, 2), np.array([[0, 0, 0, 1]])))
    path.write_bytes(good[:-3])
    with pytest.raises(tyndall.IoError, match=r"a\.vox: chunk MAIN at byte 8"):
        import_vox(path)
    path.write_bytes(good[:-4] + bytes([0, 2, 0, 1]))
    with pytest.raises(tyndall.IoError, match=r"a\.vox: chunk XYZI at byte 44: voxel 0 lies outside"):
        import_vox(path)
    path.write_bytes(good)
    with pytest.raises(tyndall.InvalidInput, match=r"a\.vox: .*memory budget"):
        import_vox(path, Config(memory_budget_bytes=100))
    with pytest.raises(tyndall.InvalidInput, match="voxel_size_m"):
        import_vox(path, voxel_size_m=0.0)
    with pytest.raises(tyndall.IoError, match=r"missing\.vox"):
        import_vox(tmp_path / "missing.vox")
    with pytest.raises(tyndall.IoError, match="irectory"):
        import_vox(tmp_path)
    cancelled = tyndall.Progress()
    cancelled.cancel()
    with pytest.raises(tyndall.Cancelled):
        import_vox(path, progress=cancelled)


def test_a_full_disk_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    path = tmp_path / "a.vox"
    from_coordinates([[1, 2, 3]], Config(resolution=4)).to_vox(path)
    before = path.read_bytes()
    many = from_coordinates(np.random.default_rng(4).integers(0, 64, (20000, 3)), Config(resolution=64))
    with largest_file(1 << 14), pytest.raises(tyndall.IoError, match=r"a\.vox: .*room"):
        many.to_vox(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(tyndall.InvalidInput, match="no voxels"):
        from_coordinates(np.zeros((0, 3), np.int64), Config(resolution=4)).to_vox(path)
    with pytest.raises(tyndall.IoError, match=r"nowhere.*a\.vox"):
        many.to_vox("/nowhere/a.vox")
    many.save(tmp_path / "a.tdag")
    assert load(tmp_path / "a.tdag").voxel_count == many.voxel_count
