# SPDX-License-Identifier: GPL-3.0-or-later
"""Which frames, and which files: a file has its name only when it is complete."""

from __future__ import annotations

from pathlib import Path

import pytest

from tyndall.frame_files import completed, frame_file, parse_frames, require_writable


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("7", [7]),
        ("1-4", [1, 2, 3, 4]),
        ("1-10x4", [1, 5, 9]),
        ("3, 1-2,2", [1, 2, 3]),
        ("-3--1", [-3, -2, -1]),
        ("-1-1", [-1, 0, 1]),
    ],
)
def test_frames_are_ascending_and_each_once(text: str, frames: list[int]) -> None:
    assert parse_frames(text) == frames


@pytest.mark.parametrize("text", ["", "a", "4-1", "1-", "1-10x0", "1,,2", "1-9999999999"])
def test_what_is_no_frame_is_named(text: str) -> None:
    with pytest.raises(ValueError, match='"'):
        parse_frames(text)


def test_files_carry_their_frame() -> None:
    assert frame_file(Path("a/b.exr"), 7, is_only=True) == Path("a/b.exr")
    assert frame_file(Path("a/b.exr"), 7, is_only=False) == Path("a/b_0007.exr")
    assert frame_file(Path("a#/b_###.exr"), 7, is_only=True) == Path("a#/b_007.exr")
    assert frame_file(Path("b##.exr"), 12345, is_only=False) == Path("b12345.exr")


def test_a_file_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    """An error, or nothing written, leaves the old file and no temporary one."""
    target = tmp_path / "picture.exr"
    target.write_text("old")
    with pytest.raises(UnicodeEncodeError), completed(target) as temporary:
        temporary.write_text("half\udcff", encoding="utf-8")
    with pytest.raises(OSError, match="was not written"), completed(target):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["picture.exr"]
    assert target.read_text() == "old"
    with completed(target) as temporary:
        temporary.write_text("new")
        assert temporary.suffix == ".exr", "Blender picks nothing by it, but people do"
    assert target.read_text() == "new"


def test_a_folder_that_cannot_be_written_is_known_before(tmp_path: Path) -> None:
    """Root may write anywhere, but no one below a file."""
    require_writable(tmp_path / "new" / "folder")
    assert (tmp_path / "new" / "folder").is_dir()
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="file"):
        require_writable(tmp_path / "file" / "folder")
