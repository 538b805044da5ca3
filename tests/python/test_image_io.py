# SPDX-License-Identifier: GPL-3.0-or-later
"""Image files: what is written is what is read, to the bit, and a failure leaves no file behind and names the path."""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np
import pytest

from support.full_disk import largest_file
from tyndall import _image_io

HEIGHT, WIDTH = 5, 7


def plane(channel_count: int, seed: int = 0) -> np.ndarray:
    """Values of a render: bright, dark, negative, and a lone one in the lower left corner."""
    pixels = np.random.default_rng(seed).normal(0.0, 10.0, (HEIGHT, WIDTH, channel_count)).astype(np.float32)
    pixels[0, 0] = 12345.0
    return pixels


def names_in(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir()]


def test_an_exr_holds_every_plane_bit_by_bit_under_its_name(tmp_path: Path) -> None:
    planes = [("ViewLayer.Combined", "RGBA", plane(4)), ("ViewLayer.Depth", "Z", plane(1, 1)), ("", "XYZ", plane(3, 2))]
    _image_io.write_exr(tmp_path / "all.exr", planes, metadata={"tyndall:frame": "7"})
    pixels, names, metadata = _image_io.read(tmp_path / "all.exr")
    assert metadata["tyndall:frame"] == "7"
    for name, letters, values in planes:
        channels = [names.index(f"{name}.{letter}" if name else letter) for letter in letters]
        np.testing.assert_array_equal(pixels[:, :, channels], values)


def test_half_floats_halve_colours_but_neither_depth_nor_position(tmp_path: Path) -> None:
    depth = np.full((HEIGHT, WIDTH, 1), 100000.5, np.float32)  # infinite as a half float
    colour = plane(3)
    _image_io.write_exr(tmp_path / "half.exr", [("C", "RGB", colour), ("Depth", "Z", depth)], is_half=True)
    pixels, names, _ = _image_io.read(tmp_path / "half.exr")
    np.testing.assert_array_equal(pixels[:, :, [names.index("Depth.Z")]], depth)
    written = pixels[:, :, [names.index(f"C.{letter}") for letter in "RGB"]]
    np.testing.assert_array_equal(written, colour.astype(np.float16).astype(np.float32))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channel_count", [1, 3, 4])
def test_a_png_keeps_colours_under_zero_alpha(tmp_path: Path, dtype: type, channel_count: int) -> None:
    top = np.iinfo(dtype).max
    pixels = np.random.default_rng(1).integers(0, top, (HEIGHT, WIDTH, channel_count), dtype, endpoint=True)
    pixels[2, 2, -1] = 0
    _image_io.write_png(tmp_path / "a.png", pixels)
    read, _, _ = _image_io.read(tmp_path / "a.png")
    np.testing.assert_array_equal(np.rint(read.astype(np.float64) * top).astype(dtype), pixels)


def test_rows_run_bottom_to_top(tmp_path: Path) -> None:
    """A PNG begins with its top row: a filter's number, then a pixel, which no filter changes in the first row."""
    pixels = np.zeros((2, 1, 1), np.uint8)
    pixels[1] = 255  # the upper row
    _image_io.write_png(tmp_path / "rows.png", pixels)
    file = (tmp_path / "rows.png").read_bytes()
    compressed = file.index(b"IDAT") + 4
    assert zlib.decompressobj().decompress(file[compressed:])[1] == 255


@pytest.mark.parametrize("channel_count", [1, 2, 3, 4])
def test_bytes_are_read_as_colours_and_alpha(tmp_path: Path, channel_count: int) -> None:
    pixels = np.random.default_rng(2).integers(0, 255, (HEIGHT, WIDTH, channel_count), np.uint8, endpoint=True)
    path = tmp_path / "a.png"
    _image_io.write_png(path, pixels)
    expected = np.full((HEIGHT, WIDTH, 4), 255, np.uint8)
    expected[..., :3] = pixels[..., :3] if channel_count >= 3 else pixels[..., :1]
    if channel_count % 2 == 0:
        expected[..., 3] = pixels[..., -1]
    for source in (path, path.read_bytes()):
        np.testing.assert_array_equal(_image_io.read_rgba(source), expected)


def test_what_is_not_of_bytes_is_no_image_of_bytes(tmp_path: Path) -> None:
    _image_io.write_png(tmp_path / "wide.png", np.zeros((2, 2, 3), np.uint16))
    _image_io.write_exr(tmp_path / "a.exr", [("", "RGB", plane(3))])
    assert _image_io.read_rgba(tmp_path / "wide.png") is None
    assert _image_io.read_rgba((tmp_path / "a.exr").read_bytes()) is None
    assert _image_io.read_rgba(b"") is None


def test_damaged_bytes_are_an_error_that_names_their_file(tmp_path: Path) -> None:
    path = tmp_path / "torn.png"
    _image_io.write_png(path, np.random.default_rng(3).integers(0, 255, (64, 64, 4), np.uint8))
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(OSError, match=r"torn\.png"):
        _image_io.read_rgba(path)
    with pytest.raises(OSError, match="packed one"):
        _image_io.read_rgba(path.read_bytes(), "packed one")


@pytest.mark.parametrize("size", [1 << 16, 1 << 20])
def test_a_full_disk_is_an_error_that_names_the_path_and_leaves_the_old_file(tmp_path: Path, size: int) -> None:
    path = tmp_path / "frame.exr"
    _image_io.write_exr(path, [("", "RGB", plane(3))])
    before = path.read_bytes()
    noise = np.random.default_rng(3).random((600, 600, 4), np.float32)
    with largest_file(size), pytest.raises(OSError, match=r"frame\.exr"):
        _image_io.write_exr(path, [("", "RGBA", noise)])
    assert path.read_bytes() == before
    assert names_in(tmp_path) == ["frame.exr"]


def test_a_folder_that_does_not_exist_is_an_error_that_names_the_path(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"no such folder/a\.exr"):
        _image_io.write_exr(tmp_path / "no such folder/a.exr", [("", "RGB", plane(3))])
    with pytest.raises(OSError, match=r"missing\.png"):
        _image_io.read(tmp_path / "missing.png")
    (tmp_path / "broken.exr").write_bytes(b"v/1\x01 and then nothing")
    with pytest.raises(OSError, match=r"broken\.exr"):
        _image_io.read(tmp_path / "broken.exr")


def test_a_name_that_is_a_folder_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "taken.png").mkdir()
    with pytest.raises(OSError, match=r"taken\.png"):
        _image_io.write_png(tmp_path / "taken.png", np.zeros((2, 2, 3), np.uint8))
    assert names_in(tmp_path) == ["taken.png"]


def test_wrong_arrays_are_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="plane 'Depth'"):
        _image_io.write_exr(tmp_path / "a.exr", [("Depth", "Z", plane(1).astype(np.float64))])
    with pytest.raises(TypeError, match="another size"):
        _image_io.write_exr(tmp_path / "a.exr", [("A", "Z", plane(1)), ("B", "Z", plane(1)[:2].copy())])
    with pytest.raises(ValueError, match="plane 'A' has 105 values for 2 channels"):
        _image_io.write_exr(tmp_path / "a.exr", [("A", "XY", plane(3))])
    with pytest.raises(TypeError, match="uint8"):
        _image_io.write_png(tmp_path / "a.png", plane(3))
    assert names_in(tmp_path) == []


def test_paths_of_other_alphabets_work(tmp_path: Path) -> None:
    path = tmp_path / "Bühne Žába 光.exr"
    _image_io.write_exr(path, [("", "RGB", plane(3))])
    np.testing.assert_array_equal(_image_io.read(str(path))[0], plane(3))


def test_the_loaded_library_is_the_one_it_was_built_for() -> None:
    assert _image_io.openimageio_version == "3.2.2"
