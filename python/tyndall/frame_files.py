# SPDX-License-Identifier: GPL-3.0-or-later
"""Which frames a command line asks for, and the file that each is written to. Knows no Blender."""

from __future__ import annotations

import os
import re
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_RANGE = re.compile(r"(?P<first>-?\d+)(?:-(?P<last>-?\d+))?(?:x(?P<step>\d+))?")
_MOST_FRAMES = 1_000_000


def parse_frames(text: str) -> list[int]:
    """Frames of "7", "1-10", "1-10x2" or a list of these with commas, ascending, each once. Raises ValueError."""
    frames: set[int] = set()
    for part in text.split(","):
        match = _RANGE.fullmatch(part.strip())
        if match is None:
            raise ValueError(f'"{part.strip()}" is no frame and no range such as 1-10 or 1-100x5')
        first = int(match["first"])
        last = first if match["last"] is None else int(match["last"])
        step = int(match["step"] or 1)
        if last < first or step < 1:
            raise ValueError(f'"{part.strip()}" counts backwards')
        if (last - first) // step >= _MOST_FRAMES:
            raise ValueError(f'"{part.strip()}" has more than {_MOST_FRAMES:,} frames')
        frames.update(range(first, last + 1, step))
    return sorted(frames)


def frame_file(pattern: Path, frame: int, *, is_only: bool) -> Path:
    """The file of a frame: ``####`` becomes its number; without it the number goes before the suffix of several."""
    hashes = re.search(r"#+", pattern.name)
    if hashes is not None:
        return pattern.with_name(pattern.name.replace(hashes[0], f"{frame:0{len(hashes[0])}d}", 1))
    return pattern if is_only else pattern.with_stem(f"{pattern.stem}_{frame:04d}")


def require_writable(folder: Path) -> None:
    """Create the folder if need be, and try to write there: before an hour of rendering, not after. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        pass


@contextmanager
def completed(path: Path) -> Iterator[Path]:
    """A temporary name beside ``path`` that becomes it when the block ends well; nothing is left if it does not.

    Raises OSError if nothing was written.
    """
    # Several machines may write to one folder; one whose job was given to another may still be at work.
    temporary = path.with_name(f".{path.stem}.{socket.gethostname()}.{os.getpid()}.part{path.suffix}")
    try:
        yield temporary
        if not temporary.is_file() or temporary.stat().st_size == 0:
            raise OSError(f"{path} was not written")
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
