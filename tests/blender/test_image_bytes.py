# SPDX-License-Identifier: GPL-3.0-or-later
"""Images of bytes are read past Blender: the texels are those that Blender's own pixels give."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from addon.sync.image_files import read_bytes
from addon.sync.images import ImageReader, _as_read, _floats
from addon.sync.images_ahead import ImagesAhead
from addon.sync.reports import Reports
from tyndall._image_io import write_png
from tyndall.scene_description import Image

_SIZE_PX = (37, 21)
_KINDS = [
    ("PNG", "RGBA"),
    ("PNG", "RGB"),
    ("PNG", "BW"),
    ("TIFF", "RGBA"),
    ("TIFF", "RGB"),
    ("TARGA", "RGBA"),
    ("JPEG", "RGB"),
    ("JPEG", "BW"),
]


def _loaded(folder: Path, kind: str, channels: str, *, is_packed: bool) -> bpy.types.Image:
    """Noise, some of it clear, in a file that Blender has not read yet."""
    made = bpy.data.images.new("noise", *_SIZE_PX, alpha=True)
    made.alpha_mode = "STRAIGHT"
    made.pixels.foreach_set(np.random.default_rng(5).random(4 * _SIZE_PX[0] * _SIZE_PX[1], np.float32))
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = kind, channels, "8"
    path = folder / f"noise.{kind.lower()}"
    made.save_render(str(path))
    bpy.data.images.remove(made)
    image = bpy.data.images.load(str(path))
    if is_packed:
        image.pack()
        path.unlink()
    assert not image.has_data
    return image


def _read(image: bpy.types.Image, *, associated: bool) -> Image:
    reports = Reports()
    read = ImageReader().read(image, reports, "a material", associated=associated)
    assert read is not None
    assert not reports.lines()
    return read


def _by_blender(image: bpy.types.Image, *, associated: bool) -> Image:
    return _as_read(image, _floats(image), "", associated=associated, is_float=image.is_float)


@pytest.mark.parametrize("is_packed", [False, True])
@pytest.mark.parametrize(("kind", "channels"), _KINDS)
def test_texels_are_those_of_blenders_pixels(tmp_path: Path, kind: str, channels: str, *, is_packed: bool) -> None:
    image = _loaded(tmp_path, kind, channels, is_packed=is_packed)
    by_mode = {
        (mode, associated): _read(image, associated=associated)
        for mode in ("STRAIGHT", "CHANNEL_PACKED", "NONE", "PREMUL")
        for associated in (False, True)
        if not setattr(image, "alpha_mode", mode)
    }
    for (mode, associated), read in by_mode.items():
        image.alpha_mode = mode
        expected = _by_blender(image, associated=associated)
        assert (read.is_srgb, read.has_alpha) == (expected.is_srgb, expected.has_alpha), (mode, associated)
        np.testing.assert_array_equal(read.pixels, expected.pixels, err_msg=f"{mode} {associated}")
    assert len({read.pixels.tobytes() for read in by_mode.values()}) >= (2 if channels == "RGBA" else 1)


@pytest.mark.parametrize("is_packed", [False, True])
def test_blender_need_not_load_them(tmp_path: Path, *, is_packed: bool) -> None:
    image = _loaded(tmp_path, "PNG", "RGBA", is_packed=is_packed)
    _read(image, associated=False)
    assert not image.has_data


def test_of_a_torn_file_what_blender_makes_of_it_is_drawn(tmp_path: Path) -> None:
    image = _loaded(tmp_path, "JPEG", "RGB", is_packed=False)
    path = Path(image.filepath)
    path.write_bytes(path.read_bytes()[:-400])
    read = _read(image, associated=False)
    np.testing.assert_array_equal(read.pixels, _by_blender(image, associated=False).pixels)
    assert image.has_data


@pytest.mark.parametrize("budget_bytes", [0, 1 << 30, 1])
def test_what_other_threads_read_ahead_is_what_the_files_have(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, budget_bytes: int
) -> None:
    """In whatever order it is asked for; with room for all, for two and for none."""
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 1, 2})
    paths = [tmp_path / f"{index}.png" for index in range(7)]
    for index, path in enumerate(paths):
        write_png(path, np.full((3, 4, 3), index, np.uint8))
    paths[4].unlink()
    ahead = ImagesAhead()
    ahead.start(paths, budget_bytes)
    for index in (6, 0, 4, 1, 5, 0):
        pixels = ahead.take(paths[index])
        if index == 4:
            assert pixels is None
        else:
            np.testing.assert_array_equal(pixels, read_bytes(paths[index]))
            assert (pixels[..., :3] == index).all()
    ahead.stop()
    np.testing.assert_array_equal(ahead.take(paths[2]), read_bytes(paths[2]))


def test_no_more_is_begun_ahead_than_there_is_room_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 1})
    begun: list[Path] = []

    def read(path: Path, _: str) -> np.ndarray:
        begun.append(path)
        return np.zeros((4096, 4096, 4), np.uint8)

    monkeypatch.setattr("addon.sync.images_ahead.read_bytes", read)
    ahead = ImagesAhead()
    paths = [tmp_path / f"{index}.png" for index in range(9)]
    ahead.start(paths, 8 * (3 * 64 << 20))
    for count, path in enumerate(paths, start=1):
        assert len(begun) <= count + 2
        ahead.take(path)
    assert begun == paths
