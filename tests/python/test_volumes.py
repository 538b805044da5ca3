# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenVDB files: what is written is what is read, to the bit, and what is missing or damaged is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tyndall
from support.full_disk import largest_file
from tyndall import _volume_io
from tyndall.volumes import LEAF_VOXELS, SparseGrid, from_dense, grid_infos, read_vdb, to_dense, write_vdb

#: A turn, a shear, three scales and a shift: no two entries alike.
TURNED = np.array([[0.5, -1.25, 0.1, 3.0], [0.75, 0.3, 0.7, -20.0], [0.2, 0.4, 1.5, 0.125], [0.0, 0.0, 0.0, 1.0]])


def noise(shape: tuple[int, int, int], seed: int = 0) -> np.ndarray:
    """Values as a simulation has them: mostly nothing, else positive and negative numbers of all sizes."""
    random = np.random.default_rng(seed)
    values = random.normal(size=shape) * np.exp(random.normal(size=shape) * 10.0)
    return np.where(random.random(shape) < 0.6, 0.0, values).astype(np.float32)


def assert_same(read: SparseGrid, written: SparseGrid) -> None:
    """Bit for bit."""
    assert read.name == written.name
    np.testing.assert_array_equal(read.leaf_origins, written.leaf_origins)
    np.testing.assert_array_equal(read.leaf_values.view(np.uint32), written.leaf_values.view(np.uint32))
    np.testing.assert_array_equal(read.local_from_index.view(np.uint64), written.local_from_index.view(np.uint64))
    assert np.float32(read.background).tobytes() == np.float32(written.background).tobytes()


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("background", [0.0, 0.3, -1e30, np.inf, np.nan])
@pytest.mark.parametrize("first_index", [(0, 0, 0), (-13, 5, -8001), (2_000_000_000, -2_000_000_000, 0)])
def test_a_grid_comes_back_bit_by_bit(tmp_path: Path, background: float, first_index: tuple[int, int, int]) -> None:
    """Whatever surrounds it, and wherever it lies: also a -0 in a background of 0, which OpenVDB holds for the same."""
    values = noise((19, 8, 33))
    values[:2, 0, 0] = [-0.0, np.nan]
    written = from_dense("density", values, TURNED, first_index=first_index, background=background)
    write_vdb(tmp_path / "a.vdb", [written])
    (read,) = read_vdb(tmp_path / "a.vdb").values()
    assert_same(read, written)
    last_index = tuple(np.add(first_index, values.shape).tolist())
    dense, first = to_dense(read, (first_index, last_index))
    np.testing.assert_array_equal(dense.view(np.uint32), values.view(np.uint32))
    assert first == first_index


@pytest.mark.parametrize(
    "local_from_index",
    [
        np.eye(4),
        np.diag([0.1, 0.1, 0.1, 1.0]),
        np.diag([0.1, 0.1 + 1e-14, 0.1 - 1e-14, 1.0]),  # what differs by 1e-15 is the same to OpenVDB
        np.diag([0.1, -0.2, 1e-9, 1.0]),
        np.array([[1e7, 0, 0, 1 / 3], [0, 1e7, 0, -2e9], [0, 0, 1e7, 1e-12], [0, 0, 0, 1]]),
        TURNED,
    ],
)
def test_a_matrix_comes_back_bit_by_bit(tmp_path: Path, local_from_index: np.ndarray) -> None:
    """OpenVDB keeps a uniform scale, a scale, a shift each in a map of its own, and the rest as a matrix."""
    write_vdb(tmp_path / "a.vdb", [from_dense("density", noise((4, 4, 4)), local_from_index)])
    np.testing.assert_array_equal(read_vdb(tmp_path / "a.vdb")["density"].local_from_index, local_from_index)


def test_a_file_holds_several_grids_and_gives_those_that_are_asked_for(tmp_path: Path) -> None:
    written = [
        from_dense(name, noise((9, 9, 9), seed), np.eye(4)) for seed, name in enumerate(["level", "Žába 光", "c"])
    ]
    write_vdb(tmp_path / "Bühne 光.vdb", written)
    everything = read_vdb(tmp_path / "Bühne 光.vdb")
    assert list(everything) == ["level", "Žába 光", "c"]
    for grid in written:
        assert_same(everything[grid.name], grid)
    some = read_vdb(str(tmp_path / "Bühne 光.vdb"), ["c", "level"])
    assert list(some) == ["level", "c"]
    assert_same(some["c"], written[2])


def test_leaves_in_any_order_come_back_ascending(tmp_path: Path) -> None:
    grid = from_dense("density", np.abs(noise((40, 24, 24))) + 1, np.eye(4), first_index=(-20, -8, 0))
    order = np.random.default_rng(2).permutation(len(grid.leaf_origins))
    shuffled = SparseGrid(
        name="density",
        leaf_origins=grid.leaf_origins[order],
        leaf_values=grid.leaf_values[order],
        local_from_index=np.eye(4),
    )
    write_vdb(tmp_path / "a.vdb", [shuffled])
    assert_same(read_vdb(tmp_path / "a.vdb")["density"], grid)


def test_half_floats_keep_eleven_bits_and_halve_the_file(tmp_path: Path) -> None:
    values = np.random.default_rng(3).normal(size=(40, 40, 40)).astype(np.float32)
    grid = from_dense("density", values, np.eye(4))
    write_vdb(tmp_path / "full.vdb", [grid])
    write_vdb(tmp_path / "half.vdb", [grid], is_half=True)
    read, _ = to_dense(read_vdb(tmp_path / "half.vdb")["density"])
    np.testing.assert_array_equal(read, values.astype(np.float16).astype(np.float32))
    assert [grid_infos(tmp_path / name)[0].is_half for name in ("full.vdb", "half.vdb")] == [False, True]
    assert (tmp_path / "half.vdb").stat().st_size < 0.7 * (tmp_path / "full.vdb").stat().st_size
    too_large = from_dense("density", np.full((1, 1, 1), 1e5, np.float32), np.eye(4))
    with pytest.raises(tyndall.InvalidInput, match='grid "density": a half float cannot hold 100000'):
        write_vdb(tmp_path / "half.vdb", [too_large], is_half=True)


def test_what_a_file_says_of_its_grids(tmp_path: Path) -> None:
    """Voxels with the background's value are not active, and do not count for the bounds."""
    values = np.zeros((20, 10, 10), np.float32)
    values[3, 4, 5] = values[17, 4, 9] = 1.0
    grids = [from_dense("density", values, TURNED, first_index=(-10, 0, 0)), from_dense("none", values * 0, np.eye(4))]
    write_vdb(tmp_path / "a.vdb", grids)
    density, none = grid_infos(tmp_path / "a.vdb")
    assert (density.name, density.value_type, density.grid_class) == ("density", "float", "fog volume")
    assert (density.active_voxel_count, density.bounds, density.refusal) == (2, ((-7, 4, 5), (7, 4, 9)), "")
    np.testing.assert_array_equal(density.local_from_index, TURNED)
    assert (none.active_voxel_count, none.bounds) == (0, None)
    assert to_dense(grids[0])[0].shape == (16, 8, 16)


def test_a_grid_without_leaves_is_a_grid(tmp_path: Path) -> None:
    """The first frames of a simulated fire have one."""
    written = from_dense("flame", np.zeros((8, 8, 8), np.float32), TURNED, background=0.0)
    assert written.leaf_values.shape == (0, LEAF_VOXELS, LEAF_VOXELS, LEAF_VOXELS)
    write_vdb(tmp_path / "a.vdb", [written])
    assert_same(read_vdb(tmp_path / "a.vdb", ["flame"])["flame"], written)
    with pytest.raises(ValueError, match='grid "flame" has no leaves'):
        to_dense(written)
    dense, _ = to_dense(written, ((0, 0, 0), (2, 3, 4)))
    np.testing.assert_array_equal(dense, np.zeros((2, 3, 4), np.float32))


def test_a_grid_of_15_million_voxels_comes_back(tmp_path: Path) -> None:
    values = np.random.default_rng(4).random((200, 300, 250), np.float32)
    written = from_dense("density", values, TURNED, first_index=(-104, -304, 0))
    write_vdb(tmp_path / "big.vdb", [written])
    read = read_vdb(tmp_path / "big.vdb")["density"]
    assert_same(read, written)
    np.testing.assert_array_equal(to_dense(read, ((-104, -304, 0), (96, -4, 250)))[0], values)


def test_metadata_and_who_wrote_it(tmp_path: Path) -> None:
    write_vdb(tmp_path / "a.vdb", [from_dense("d", noise((4, 4, 4)), np.eye(4))], metadata={"tyndall:frame": "7"})
    _, metadata = _volume_io.list_grids(tmp_path / "a.vdb", tyndall.Progress())
    assert metadata == {"creator": f"Tyndall {tyndall.__version__}", "tyndall:frame": "7"}


def test_a_missing_grid_is_an_error_that_names_those_it_has(tmp_path: Path) -> None:
    write_vdb(tmp_path / "smoke.vdb", [from_dense(name, noise((4, 4, 4)), np.eye(4)) for name in ("density", "flame")])
    with pytest.raises(tyndall.InvalidInput, match=r'smoke\.vdb: it has no grid "heat"; it has: "density", "flame"'):
        read_vdb(tmp_path / "smoke.vdb", ["density", "heat"])
    write_vdb(tmp_path / "nothing.vdb", [])
    assert read_vdb(tmp_path / "nothing.vdb") == {}
    with pytest.raises(tyndall.InvalidInput, match=r'nothing\.vdb: it has no grid "density"; it has: none'):
        read_vdb(tmp_path / "nothing.vdb", ["density"])


def test_a_file_that_ends_early_is_an_error_wherever_it_ends(tmp_path: Path) -> None:
    """OpenVDB's own reader gives zeros, or what lay in memory before, for what is missing."""
    write_vdb(tmp_path / "a.vdb", [from_dense("density", noise((30, 30, 30)), np.eye(4))])
    whole = (tmp_path / "a.vdb").read_bytes()
    broken = tmp_path / "broken.vdb"
    for length in [*range(0, 1000, 7), *range(1000, len(whole), 997), len(whole) - 1]:
        broken.write_bytes(whole[:length])
        with pytest.raises(tyndall.IoError, match=r"broken\.vdb: .*; write it again"):
            read_vdb(broken)
        if length < 100:
            with pytest.raises(tyndall.IoError, match=r"broken\.vdb: .*; write it again"):
                grid_infos(broken)


def test_what_is_no_file_of_openvdb_is_an_error_that_names_the_path(tmp_path: Path) -> None:
    with pytest.raises(tyndall.IoError, match=r"missing\.vdb: No such file"):
        read_vdb(tmp_path / "missing.vdb")
    with pytest.raises(tyndall.IoError, match="Is a directory"):
        grid_infos(tmp_path)
    (tmp_path / "text.vdb").write_text("not a volume, but a text of more than a few letters", encoding="utf-8")
    with pytest.raises(tyndall.IoError, match=r"text\.vdb: .*not a VDB file"):
        read_vdb(tmp_path / "text.vdb")


@pytest.mark.parametrize("size", [1000, 1 << 16, 1 << 20])
def test_a_full_disk_is_an_error_that_leaves_the_old_file(tmp_path: Path, size: int) -> None:
    path = tmp_path / "fog.vdb"
    write_vdb(path, [from_dense("density", noise((4, 4, 4)), np.eye(4))])
    before = path.read_bytes()
    large = from_dense("density", np.random.default_rng(5).random((100, 100, 100), np.float32), np.eye(4))
    with largest_file(size), pytest.raises(tyndall.IoError, match=r"fog\.vdb: .*has room"):
        write_vdb(path, [large])
    assert path.read_bytes() == before
    assert names_in(tmp_path) == ["fog.vdb"]


def test_a_folder_that_cannot_be_written_to_is_an_error(tmp_path: Path) -> None:
    grid = from_dense("density", noise((4, 4, 4)), np.eye(4))
    with pytest.raises(tyndall.IoError, match=r"no such folder/a\.vdb: No such file or directory; see that the folder"):
        write_vdb(tmp_path / "no such folder/a.vdb", [grid])
    (tmp_path / "taken.vdb").mkdir()
    with pytest.raises(tyndall.IoError, match=r"taken\.vdb"):
        write_vdb(tmp_path / "taken.vdb", [grid])
    assert names_in(tmp_path) == ["taken.vdb"]


def test_wrong_grids_are_refused_by_name(tmp_path: Path) -> None:
    leaf = np.ones((1, LEAF_VOXELS, LEAF_VOXELS, LEAF_VOXELS), np.float32)

    def refused(match: str, error: type[Exception] = tyndall.InvalidInput, **changed: object) -> None:
        fields = {"leaf_origins": np.zeros((1, 3), np.int32), "leaf_values": leaf, "local_from_index": np.eye(4)}
        with pytest.raises(error, match=match):
            write_vdb(tmp_path / "a.vdb", [SparseGrid(**{"name": "smoke", **fields, **changed})])

    refused("it has no name", name="")
    refused(
        r'"smoke": a leaf begins at \(0, 4, 0\), which is no multiple of 8',
        leaf_origins=np.array([[0, 4, 0]], np.int32),
    )
    twice = {"leaf_origins": np.full((2, 3), -8, np.int32), "leaf_values": np.repeat(leaf, 2, axis=0)}
    refused(r'"smoke": two leaves begin at \(-8, -8, -8\)', **twice)
    refused('"smoke": its matrix is not affine', local_from_index=np.diag([1.0, 1.0, 0.0, 1.0]))
    refused('"smoke": its matrix is not finite', local_from_index=np.diag([1.0, np.nan, 1.0, 1.0]))
    refused('grid "smoke": leaf_values must be', TypeError, leaf_values=leaf.astype(np.float64))
    refused('grid "smoke": leaf_values must be', TypeError, leaf_values=np.repeat(leaf, 2, axis=0))
    grid = from_dense("smoke", noise((4, 4, 4)), np.eye(4))
    with pytest.raises(tyndall.InvalidInput, match='"smoke": there are two of this name'):
        write_vdb(tmp_path / "a.vdb", [grid, grid])
    assert names_in(tmp_path) == []


def test_leaves_beyond_the_memory_limit_are_refused_before_they_are_made(tmp_path: Path) -> None:
    """The limit is for all grids of a call together."""
    grids = [from_dense(name, np.ones((16, 16, 16), np.float32), np.eye(4)) for name in "ab"]
    write_vdb(tmp_path / "a.vdb", grids)
    needed = 2 * grids[0].leaf_values.nbytes
    assert len(read_vdb(tmp_path / "a.vdb", memory_limit_bytes=needed)) == 2
    with pytest.raises(tyndall.InvalidInput, match=r'grid "b": it would take .* GB in memory, beyond the limit'):
        read_vdb(tmp_path / "a.vdb", memory_limit_bytes=needed - 1)


def test_a_cancelled_call_stops_and_writes_nothing(tmp_path: Path) -> None:
    grid = from_dense("density", noise((20, 20, 20)), np.eye(4))
    write_vdb(tmp_path / "a.vdb", [grid])
    progress = tyndall.Progress()
    progress.cancel()
    with pytest.raises(tyndall.Cancelled):
        read_vdb(tmp_path / "a.vdb", progress=progress)
    with pytest.raises(tyndall.Cancelled):
        grid_infos(tmp_path / "a.vdb", progress)
    with pytest.raises(tyndall.Cancelled):
        write_vdb(tmp_path / "b.vdb", [grid], progress=progress)
    assert names_in(tmp_path) == ["a.vdb"]


def test_dense_values_keep_their_indices() -> None:
    """A voxel of a dense array lies in the leaf, and at the place in it, that OpenVDB finds it at."""
    values = np.arange(1, 1 + 20 * 3 * 11, dtype=np.float32).reshape(20, 3, 11)
    grid = from_dense("density", values, np.eye(4), first_index=(-5, 7, 100))
    assert (grid.leaf_origins % LEAF_VOXELS == 0).all()
    for offset in [(0, 0, 0), (19, 2, 10), (4, 1, 3), (5, 0, 4)]:
        index = np.add(offset, (-5, 7, 100))
        (leaf,) = np.flatnonzero((grid.leaf_origins == index // LEAF_VOXELS * LEAF_VOXELS).all(axis=1))
        assert grid.leaf_values[(leaf, *(index % LEAF_VOXELS))] == values[offset]
    part, _ = to_dense(grid, ((-7, 8, 104), (0, 9, 130)))
    np.testing.assert_array_equal(part[2:, :, :7], values[:5, 1:2, 4:])
    assert not part[:2].any()
    assert not part[:, :, 7:].any()
