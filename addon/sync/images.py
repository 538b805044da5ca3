# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as pixels, read once per change."""

from __future__ import annotations

import hashlib
import zlib
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from tyndall.scene_description import Image

from .image_files import frame_file, is_of_floats, read_file, tile_files

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .reports import Reports

MAGENTA = (1.0, 0.0, 1.0)  #: What Cycles draws for a missing image.
_SRGB = {"sRGB"}
_LINEAR = {"Linear", "Linear Rec.709", "Non-Color", "Raw", "Generic Data"}


class ImageReader:
    """Keeps what it read: the same key in the next frame is the same image."""

    def __init__(self) -> None:
        self._kept: dict[str, Image] = {}
        self._used: set[str] = set()
        self._held_files: dict[str, Path] | None = None

    def start_frame(self) -> None:
        self._used.clear()

    def end_frame(self) -> None:
        """Forgets the images that this frame did not use."""
        self._kept = {key: image for key, image in self._kept.items() if key in self._used}

    def hold_frames(self, *, is_held: bool) -> None:
        """Of sequences, the frame that is read first is theirs from now on: Cycles does not blur them either."""
        self._held_files = {} if is_held else None

    def read(
        self,
        image: bpy.types.Image | None,
        reports: Reports,
        culprit: str,
        *,
        associated: bool = False,
        user: bpy.types.ImageUser | None = None,
    ) -> Image | None:
        """None for an image that cannot be had, with a report. ``associated``: colours are multiplied with alpha.

        ``user`` says which frame of a sequence.
        """
        if image is None:
            reports.add(culprit, "an image node without an image is magenta")
            return None
        original = image.original
        if original.source == "SEQUENCE" and user is not None:
            return self._read_file(original, self._frame_file(image, user), reports, culprit, associated=associated)
        if original.size[0] * original.size[1] == 0:
            reports.add(culprit, f'image "{original.name}" is missing ({_place(original)}): magenta')
            return None
        if original.source in {"SEQUENCE", "MOVIE"}:
            reports.add(culprit, f'image "{original.name}" is a {original.source.lower()}: its first frame is drawn')
        elif original.source == "TILED":
            reports.add(culprit, f'image "{original.name}" has tiles: the first is drawn everywhere')
        _note_space(original, reports, culprit, is_float=original.is_float)
        key = _key(original, associated=associated)
        if key not in self._kept:
            pixels = _floats(original)
            self._kept[key] = _as_read(original, pixels, key, associated=associated, is_float=original.is_float)
        self._used.add(key)
        return self._kept[key]

    def read_tiles(
        self, image: bpy.types.Image, reports: Reports, culprit: str, *, associated: bool = False
    ) -> dict[tuple[int, int], Image]:
        """By column and row: those that can be had, with a report for each that cannot."""
        tiles = {}
        for place, path in tile_files(image.original).items():
            tile = self._read_file(image.original, path, reports, culprit, associated=associated)
            if tile is not None:
                tiles[place] = tile
        return tiles

    def _frame_file(self, image: bpy.types.Image, user: bpy.types.ImageUser) -> Path:
        if self._held_files is None:
            return frame_file(image, user)
        numbers = [user.frame_start, user.frame_offset, user.frame_duration, user.use_cyclic]
        key = repr([image.name_full, image.filepath, *numbers])
        if key not in self._held_files:
            self._held_files[key] = frame_file(image, user)
        return self._held_files[key]

    def _read_file(
        self, image: bpy.types.Image, path: Path, reports: Reports, culprit: str, *, associated: bool
    ) -> Image | None:
        key = repr([image.name_full, str(path), image.colorspace_settings.name, image.alpha_mode, associated])
        try:
            key += f" {path.stat().st_mtime_ns}"
            pixels = None if key in self._kept else read_file(path)
        except OSError:
            reports.add(culprit, f'image "{image.name}" is missing ({path.name}): magenta')
            return None
        _note_space(image, reports, culprit, is_float=is_of_floats(path))
        if pixels is not None:
            is_float = is_of_floats(path)
            self._kept[key] = _as_read(image, pixels, key, associated=associated, is_float=is_float)
        self._used.add(key)
        return self._kept[key]


def _note_space(image: bpy.types.Image, reports: Reports, culprit: str, *, is_float: bool) -> None:
    space = image.colorspace_settings.name
    if not is_float and space not in _SRGB | _LINEAR:
        reports.add(culprit, f'image "{image.name}": colour space {space} is read as sRGB')


def without_pixels(image: bpy.types.Image) -> str | None:
    """What to say of an image that has none, because its file is missing or nothing was rendered; None: it has."""
    if image.size[0] * image.size[1] > 0:
        return None
    return f'image "{image.name}", is missing or has no pixels ({_place(image)})'


def _place(image: bpy.types.Image) -> str:
    return image.filepath or image.source.lower()


def _key(image: bpy.types.Image, *, associated: bool) -> str:
    """Changes when the pixels do: files by their time, painted and generated images by their pixels."""
    parts: list[object] = [
        image.name_full,
        image.filepath,
        *image.size,
        image.colorspace_settings.name,
        image.alpha_mode,
        associated,
    ]
    if image.source == "GENERATED" or image.is_dirty:
        parts.append(hashlib.sha256(memoryview(_floats(image)).cast("B")).hexdigest())
    elif image.packed_file:
        parts.append(image.packed_file.size)
        if image.is_float:  # Blender packs them uncompressed: one that was fitted or painted anew has its old size
            parts.append(zlib.crc32(image.packed_file.data))
    else:
        path = Path(bpy.path.abspath(image.filepath, library=image.library))
        parts.append(path.stat().st_mtime_ns if path.is_file() else 0)
    return repr(parts)


def _floats(image: bpy.types.Image) -> NDArray[np.float32]:
    """(height, width, 4), whatever the channels; Blender loads the pixels if it must."""
    width, height, channels = image.size[0], image.size[1], image.channels
    flat = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(flat)
    stored = flat.reshape(height, width, channels)
    if channels == len("RGBA"):
        return stored
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = stored[..., :3] if channels == len("RGB") else stored[..., :1]
    if channels == len("YA"):
        pixels[..., 3] = stored[..., 1]
    return pixels


def _as_read(
    image: bpy.types.Image, floats: NDArray[np.float32], key: str, *, associated: bool, is_float: bool
) -> Image:
    """Blender keeps float pixels multiplied with alpha, others not; Cycles multiplies those while they are encoded."""
    alpha = floats[..., 3:]
    has_alpha = image.alpha_mode not in {"NONE", "CHANNEL_PACKED"} and bool((alpha < 1.0).any())
    if has_alpha and associated and not is_float:
        floats[..., :3] *= alpha
    if has_alpha and is_float and not associated:
        np.divide(floats[..., :3], alpha, out=floats[..., :3], where=alpha > 0.0)
    # Nothing reads the alpha of associated colours, and the core must not divide them by it.
    keeps_alpha = not associated and image.alpha_mode != "NONE" and bool((alpha < 1.0).any())
    if is_float:
        return Image(key=key, name=image.name, pixels=floats, is_srgb=False, has_alpha=keeps_alpha)
    return Image(
        key=key,
        name=image.name,
        pixels=np.rint(np.clip(floats, 0.0, 1.0) * 255.0).astype(np.uint8),
        is_srgb=image.colorspace_settings.name not in _LINEAR,
        has_alpha=keeps_alpha,
    )
