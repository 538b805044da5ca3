# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as pixels, read once per change."""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from tyndall._native import shared_array
from tyndall.memory_estimate import require_room_for_image
from tyndall.scene_description import Image

from .image_files import frame_file, is_of_floats, read_file, tile_files
from .images_ahead import ImagesAhead
from .texture_budget import TextureBudget

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .reports import Reports

MAGENTA = (1.0, 0.0, 1.0)  #: What Cycles draws for a missing image.
_OPAQUE = 255
_ROWS_AT_ONCE = 1 << 20  #: Values of an image that are computed together.
_SRGB = {"sRGB"}
_LINEAR = {"Linear", "Linear Rec.709", "Non-Color", "Raw", "Generic Data"}


class ImageReader:
    """Keeps what it read: the same key in the next frame is the same image."""

    def __init__(self) -> None:
        self._kept: dict[str, Image] = {}
        self._by_blender_alone: set[str] = set()  #: Keys of files that are not of bytes.
        self._used: set[str] = set()
        self._budget = TextureBudget()
        self._held_files: dict[str, Path] | None = None
        self._ahead = ImagesAhead()

    def start_frame(self, budget_bytes: int = 0) -> None:
        """``budget_bytes``: of memory; what is beyond it goes to a file. 0: everything stays in memory."""
        self._ahead.stop()  # of a frame that was given up
        self._used.clear()
        if not self._budget.start_frame(budget_bytes):
            self._kept.clear()

    def read_ahead(self, images: Callable[[], Iterable[bpy.types.Image]], budget_bytes: int) -> None:
        """Of a frame that is the reader's first: other threads begin with the files of these, which it may use."""
        if not self._kept:
            self._ahead.start((source for image in images() for source in _sources(image)), budget_bytes)

    def end_frame(self) -> None:
        """Forgets the images that this frame did not use."""
        self._ahead.stop()
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
        stays_whole: bool = True,
    ) -> Image | None:
        """None for an image that cannot be had, with a report. ``associated``: colours are multiplied with alpha.

        ``user`` says which frame of a sequence. Without ``stays_whole`` it may lie in a file. Raises IoError where
        that has no room.
        """
        if image is None:
            reports.add(culprit, "an image node without an image is magenta")
            return None
        original = image.original
        if original.source == "SEQUENCE" and user is not None:
            path = self._frame_file(image, user)
            return self._read_file(original, path, reports, culprit, associated=associated, stays_whole=stays_whole)
        file_key = _file_key(original, associated=associated)
        key = file_key or _packed_key(original, associated=associated)
        found = self._kept.get(key or "") or self._bytes(original, key, associated=associated)
        if found is None:
            found = self._by_blender(original, file_key, reports, culprit, associated=associated)
            if found is None:
                return None
        _note_space(original, reports, culprit, is_float=found.is_float)
        return self._use(found, stays_whole=stays_whole)

    def _bytes(self, image: bpy.types.Image, key: str | None, *, associated: bool) -> Image | None:
        """Of a file of bytes, which Blender need not load."""
        if key is None or key in self._by_blender_alone:
            return None
        source = _source(image)
        pixels = None if source is None else self._ahead.take(source)
        if pixels is None:
            self._by_blender_alone.add(key)
            return None
        return _of_bytes(image, pixels, key, associated=associated)

    def _by_blender(
        self, image: bpy.types.Image, file_key: str | None, reports: Reports, culprit: str, *, associated: bool
    ) -> Image | None:
        """Of floats, and what was painted or generated; None, and a report, of one without pixels."""
        was_loaded = image.has_data  # all that follows makes Blender load it
        if image.size[0] * image.size[1] == 0:
            reports.add(culprit, f'image "{image.name}" is missing ({_place(image)}): magenta')
            return None
        if image.source in {"SEQUENCE", "MOVIE"}:
            reports.add(culprit, f'image "{image.name}" is a {image.source.lower()}: its first frame is drawn')
        elif image.source == "TILED":
            reports.add(culprit, f'image "{image.name}" has tiles: the first is drawn everywhere')
        key = file_key or _key(image, associated=associated)
        found = self._kept.get(key)
        if found is None:
            floats, is_float = _floats(image), image.is_float
            if file_key is not None and not was_loaded:
                image.buffers_free()  # Blender reads it again when it wants it
            found = _as_read(image, floats, key, associated=associated, is_float=is_float, is_shared=True)
        return found

    def read_tiles(
        self, image: bpy.types.Image, reports: Reports, culprit: str, *, associated: bool = False
    ) -> dict[tuple[int, int], Image]:
        """By column and row: those that can be had, with a report for each that cannot. Raises IoError as read."""
        tiles = {}
        for place, path in tile_files(image.original).items():
            tile = self._read_file(image.original, path, reports, culprit, associated=associated, stays_whole=False)
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
        self,
        image: bpy.types.Image,
        path: Path,
        reports: Reports,
        culprit: str,
        *,
        associated: bool,
        stays_whole: bool,
    ) -> Image | None:
        key = repr([image.name_full, str(path), image.colorspace_settings.name, image.alpha_mode, associated])
        try:
            key += f" {path.stat().st_mtime_ns}"
            found = self._kept.get(key) or self._from_file(image, path, key, associated=associated)
        except OSError:
            reports.add(culprit, f'image "{image.name}" is missing ({path.name}): magenta')
            return None
        _note_space(image, reports, culprit, is_float=found.is_float)
        return self._use(found, stays_whole=stays_whole)

    def _from_file(self, image: bpy.types.Image, path: Path, key: str, *, associated: bool) -> Image:
        """Raises OSError."""
        pixels = self._ahead.take(path)
        if pixels is not None:
            return _of_bytes(image, pixels, key, associated=associated)
        return _as_read(image, read_file(path), key, associated=associated, is_float=is_of_floats(path))

    def _use(self, image: Image, *, stays_whole: bool) -> Image:
        self._kept[image.key] = image
        self._used.add(image.key)
        self._budget.use(image, stays_whole=stays_whole)
        return image


def images_of(depsgraph: bpy.types.Depsgraph) -> Iterator[bpy.types.Image]:
    """Those that its materials, lights and world have among their nodes. It looks at every object."""
    if len(bpy.data.images) > 1:
        yield from (thing.original for thing in depsgraph.ids if isinstance(thing, bpy.types.Image))


def _note_space(image: bpy.types.Image, reports: Reports, culprit: str, *, is_float: bool) -> None:
    space = image.colorspace_settings.name
    if not is_float and space not in _SRGB | _LINEAR:
        reports.add(culprit, f'image "{image.name}": colour space {space} is read as sRGB')


def texel_of_missing(image: bpy.types.Image | None, *, associated: bool) -> Image:
    """What Cycles reads for no file, or a missing one: at a clipped border it, or its alpha alone, fades out."""
    is_srgb = image is not None and image.colorspace_settings.name not in _LINEAR
    pixels = np.array([[[*MAGENTA, 1.0]]], np.uint8) * np.uint8(255)
    key = f"missing {is_srgb} {associated}"
    name = "" if image is None else image.name
    return Image(key=key, name=name, pixels=pixels, is_srgb=is_srgb, has_alpha=not associated)


def without_pixels(image: bpy.types.Image) -> str | None:
    """What to say of an image that has none, because its file is missing or nothing was rendered; None: it has."""
    if image.size[0] * image.size[1] > 0:
        return None
    return f'image "{image.name}", is missing or has no pixels ({_place(image)})'


def _place(image: bpy.types.Image) -> str:
    return image.filepath or image.source.lower()


def _file_key(image: bpy.types.Image, *, associated: bool) -> str | None:
    """Of an image that is what its file has, found without loading it; None of any other."""
    if image.source != "FILE" or image.packed_file or image.is_dirty:
        return None
    path = _path(image)
    if not path.is_file():
        return None
    settings = (image.colorspace_settings.name, image.alpha_mode, associated)
    return repr([image.name_full, image.filepath, *settings, path.stat().st_mtime_ns])


def _packed_key(image: bpy.types.Image, *, associated: bool) -> str | None:
    """Of an image that is what its packed file has, found without loading it; None of any other."""
    if image.source != "FILE" or not image.packed_file or image.is_dirty:
        return None
    settings = (image.colorspace_settings.name, image.alpha_mode, associated)
    return repr([image.name_full, image.filepath, *settings, image.packed_file.size])


def _source(image: bpy.types.Image) -> Path | bpy.types.Image | None:
    """What has its bytes; None of one that Blender must read, which divides such colours by their alpha."""
    if image.source != "FILE" or image.is_dirty or image.alpha_mode == "PREMUL":
        return None
    return image if image.packed_file else _path(image)


def _sources(image: bpy.types.Image) -> Iterable[Path | bpy.types.Image]:
    """All that are to be read of it, at whatever frame."""
    if image.source == "TILED":
        return tile_files(image).values()
    source = _source(image)
    return () if source is None else (source,)


def _path(image: bpy.types.Image) -> Path:
    return Path(bpy.path.abspath(image.filepath, library=image.library))


def _key(image: bpy.types.Image, *, associated: bool) -> str:
    """Of any other, which changes when the pixels do: of painted and generated images it is made of them."""
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
    return repr(parts)


def _floats(image: bpy.types.Image) -> NDArray[np.float32]:
    """(height, width, channels), shared; Blender loads the pixels if it must. Raises InvalidInput without room."""
    width, height, channels = image.size[0], image.size[1], image.channels
    require_room_for_image(image.name, (width, height), 4 * channels)
    stored: NDArray[np.float32] = shared_array((height, width, channels), np.dtype(np.float32))
    image.pixels.foreach_get(stored.reshape(-1))
    return stored


def _rgba(stored: NDArray[np.float32]) -> NDArray[np.float32]:
    """Of any number of channels: grey, grey and alpha, colour, colour and alpha. A copy."""
    channels = stored.shape[2]
    pixels = np.ones((*stored.shape[:2], 4), np.float32)
    pixels[..., :3] = stored[..., :3] if channels >= len("RGB") else stored[..., :1]
    if channels in {len("YA"), len("RGBA")}:
        pixels[..., 3] = stored[..., -1]
    return pixels


def _blocks(shape: tuple[int, ...]) -> list[slice]:
    """Rows that are computed together."""
    height, width, channels = shape
    step = max(1, _ROWS_AT_ONCE // (width * channels))
    return [slice(first, first + step) for first in range(0, height, step)]


def _of_bytes(image: bpy.types.Image, pixels: NDArray[np.uint8], key: str, *, associated: bool) -> Image:
    """Of (height, width, 4), which becomes the image's own. As _as_read, but that Cycles' alpha that is off is 1."""
    blocks = _blocks(pixels.shape)
    is_seen_through = image.alpha_mode != "NONE" and any((pixels[rows, :, 3] < _OPAQUE).any() for rows in blocks)
    if not is_seen_through:
        pixels[..., 3] = _OPAQUE
    elif associated and image.alpha_mode != "CHANNEL_PACKED":
        for rows in blocks:
            encoded = pixels[rows] * np.float32(1.0 / _OPAQUE)
            pixels[rows, :, :3] = np.rint(encoded[..., :3] * encoded[..., 3:] * np.float32(_OPAQUE))
    return Image(
        key=key,
        name=image.name,
        pixels=pixels,
        is_srgb=image.colorspace_settings.name not in _LINEAR,
        has_alpha=is_seen_through and not associated,
    )


def _as_read(
    image: bpy.types.Image,
    stored: NDArray[np.float32],
    key: str,
    *,
    associated: bool,
    is_float: bool,
    is_shared: bool = False,
) -> Image:
    """Blender keeps float pixels multiplied with alpha, others not; Cycles multiplies those while they are encoded.

    A few rows at a time: of a large image nothing but ``stored`` and the texels is in memory; of floats that are
    ``is_shared``, ``stored`` alone.
    """
    height, width, channels = stored.shape
    blocks = _blocks(stored.shape)
    is_seen_through = channels in {len("YA"), len("RGBA")} and any((stored[rows, :, -1] < 1.0).any() for rows in blocks)
    has_alpha = is_seen_through and image.alpha_mode not in {"NONE", "CHANNEL_PACKED"}
    is_kept = is_shared and is_float and channels == len("RGBA")
    texels: NDArray[Any] = (
        stored if is_kept else shared_array((height, width, 4), np.dtype(np.float32 if is_float else np.uint8))
    )
    for rows in [] if is_kept and (associated or not has_alpha) else blocks:
        pixels = _rgba(stored[rows])
        alpha = pixels[..., 3:]
        if has_alpha and associated and not is_float:
            pixels[..., :3] *= alpha
        if has_alpha and is_float and not associated:
            np.divide(pixels[..., :3], alpha, out=pixels[..., :3], where=alpha > 0.0)
        texels[rows] = pixels if is_float else np.rint(np.clip(pixels, 0.0, 1.0) * 255.0)
    return Image(
        key=key,
        name=image.name,
        pixels=texels,
        is_srgb=not is_float and image.colorspace_settings.name not in _LINEAR,
        # Nothing reads the alpha of associated colours, and the core must not divide them by it.
        has_alpha=is_seen_through and not associated and image.alpha_mode != "NONE",
    )
