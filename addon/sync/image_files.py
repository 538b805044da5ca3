# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that Blender need not load: they are read from their files, or from the file that a .blend has packed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.memory_estimate import require_room_for_image

if TYPE_CHECKING:
    from numpy.typing import NDArray

_FIRST_TILE, _TILES_PER_ROW = 1001, 10
#: Formats of linear colours, that are multiplied with alpha.
_OF_FLOATS = {".exr", ".hdr", ".pfm"}


def frame_file(image: bpy.types.Image, user: bpy.types.ImageUser) -> Path:
    """Of a sequence, at the frame that its user shows now."""
    return Path(bpy.path.abspath(image.filepath_from_user(image_user=user), library=image.library))


def tile_files(image: bpy.types.Image) -> dict[tuple[int, int], Path]:
    """Column and row of each tile, and its file, which may be missing."""
    files = {}
    for tile in image.tiles:
        row, column = divmod(tile.number - _FIRST_TILE, _TILES_PER_ROW)
        name = image.filepath.replace("<UDIM>", str(tile.number)).replace("<UVTILE>", f"u{column + 1}_v{row + 1}")
        files[column, row] = Path(bpy.path.abspath(name, library=image.library))
    return files


def is_of_floats(path: Path) -> bool:
    return path.suffix.lower() in _OF_FLOATS


def read_bytes(source: Path | bytes, name: str = "packed") -> NDArray[np.uint8] | None:
    """(height, width, 4), shared: of a file, or of what it holds, if it has bytes; None: it has not, or is damaged.

    Raises InvalidInput where memory has no room for it.
    """
    from tyndall import _image_io

    def require_room(width: int, height: int) -> None:
        require_room_for_image(name, (width, height), 4)

    try:
        return _image_io.read_rgba(source, name, require_room)
    except OSError:
        return None


def read_file(path: Path) -> NDArray[np.float32]:
    """(height, width, channels) as the file has it. Raises OSError."""
    from tyndall import _image_io

    stored, names, _ = _image_io.read(path)
    return np.asarray(stored, np.float32).reshape(*stored.shape[:2], len(names))
