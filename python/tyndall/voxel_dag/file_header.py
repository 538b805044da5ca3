# SPDX-License-Identifier: GPL-3.0-or-later
"""What a ``.tdag`` file says of itself, some KB of it, however large it is: docs/tdag.md describes each byte."""

from __future__ import annotations

import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import BinaryIO

from tyndall._native import IoError, Progress

_MAGIC, _VERSION = b"TDAG\r\n\x1a\n", 3
_HEADER, _SECTION, _NAMES = struct.Struct("<8s4I4Q4d4I"), struct.Struct("<IIQQII"), struct.Struct("<II4dQQI")
_MOST_SECTIONS, _LEAF_LEVEL, _MOST_LEVEL = 4096, 2, 17
_FORMAT_BYTES, _OTHER_BYTES = 400, 24  #: Of a level, and of no section: what memory has.
_PIECE_BYTES = 1 << 22


class _Kind(IntEnum):
    FORMATS = 1
    DIRECTORY = 2
    RECORDS = 3
    PAIRS = 4
    LEAVES = 5
    NAMES = 6
    COUNT_DIRECTORY = 7
    COUNTS = 8
    MATERIALS = 9
    INDICES = 10
    MEAN_MATERIALS = 11
    MEAN_INDICES = 12
    TOP_MASKS = 13


#: Which sections each part of the attributes is, in the order of VoxelDag.bytes_by_part.
_ATTRIBUTES = {
    "counts": (_Kind.COUNT_DIRECTORY, _Kind.COUNTS),
    "materials": (_Kind.MATERIALS,),
    "indices": (_Kind.INDICES,),
    "mean_materials": (_Kind.MEAN_MATERIALS,),
    "mean_indices": (_Kind.MEAN_INDICES,),
}


@dataclass(frozen=True, kw_only=True)
class FileHeader:
    """Names and numbers are those of VoxelDag."""

    resolution: int
    voxel_count: int
    node_count: int
    bounds_m: tuple[tuple[float, float, float], tuple[float, float, float]]
    bytes_by_part: dict[str, int]
    has_colors: bool
    has_normals: bool
    channels: list[str]
    #: Of the topmost levels that lie apart, 2, 4, 8 cubes and so on along a side: how many have voxels.
    top_cube_counts: list[int]

    @property
    def geometry_bytes(self) -> int:
        """Of all nodes."""
        return sum(self.bytes_by_part.values()) - self.attribute_bytes

    @property
    def attribute_bytes(self) -> int:
        """Of colours, normals, channels and what finds them."""
        return sum(self.bytes_by_part.get(name, 0) for name in _ATTRIBUTES)


def read_header(path: str | os.PathLike[str]) -> FileHeader:
    """Raises IoError, which names the path and what is wrong; what else the file holds is not read."""
    return _read(Path(path), None)


def checked_header(path: str | os.PathLike[str], progress: Progress | None = None) -> FileHeader:
    """As read_header(), after every section was seen to have its checksum, some MB at a time. Also raises Cancelled."""
    return _read(Path(path), progress or Progress())


@dataclass(frozen=True, kw_only=True)
class _Section:
    kind: int
    level: int
    offset: int
    byte_count: int
    checksum: int


def _read(path: Path, progress: Progress | None) -> FileHeader:
    try:
        with path.open("rb") as file:
            return _header(file, progress)
    except (OSError, ValueError, struct.error) as error:
        what = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise IoError(f"{path}: {what}") from None


def _header(file: BinaryIO, progress: Progress | None) -> FileHeader:
    fields = file.read(_HEADER.size)
    if fields[: len(_MAGIC)] != _MAGIC:
        raise ValueError("it is no .tdag file")
    if len(fields) < _HEADER.size:
        raise ValueError("it ends within its header: copy or save it again")
    _, version, level, _, _, _, voxel_count, node_count, byte_count, *place, section_count, table_sum, _, checksum = (
        _HEADER.unpack(fields)
    )
    if version > _VERSION:
        raise ValueError(f"it is of version {version}, this Tyndall reads up to {_VERSION}: install a newer one")
    if checksum != zlib.crc32(fields[:-4]) or not _LEAF_LEVEL <= level <= _MOST_LEVEL or section_count > _MOST_SECTIONS:
        raise ValueError("its header is damaged: copy or save the file again")
    size = os.fstat(file.fileno()).st_size
    if byte_count != size:
        raise ValueError(f"it has {size} bytes instead of {byte_count}: copy or save it again")
    table = file.read(_SECTION.size * section_count)
    if zlib.crc32(table) != table_sum:
        raise ValueError("its table of sections is damaged: copy or save the file again")
    sections = [
        _Section(kind=kind, level=of_level, offset=offset, byte_count=count, checksum=found)
        for kind, of_level, offset, count, found, _ in _SECTION.iter_unpack(table)
    ]
    if progress is not None:
        for section in sections:
            for _ in _pieces(file, section, progress):
                pass
    has_colors, normal_bits, channels = _names(file, sections)
    x_m, y_m, z_m, side_m = place
    return FileHeader(
        resolution=1 << level,
        voxel_count=voxel_count,
        node_count=node_count,
        bounds_m=((x_m, y_m, z_m), (x_m + side_m, y_m + side_m, z_m + side_m)),
        bytes_by_part=_bytes_by_part(sections, level),
        has_colors=has_colors,
        has_normals=normal_bits > 0,
        channels=channels,
        top_cube_counts=_top_cube_counts(file, sections),
    )


def _pieces(file: BinaryIO, section: _Section, progress: Progress | None = None) -> Iterator[bytes]:
    """Raises ValueError, after the last one, where the checksum is another."""
    file.seek(section.offset)
    left, found = section.byte_count, 0
    while left > 0 and (piece := file.read(min(left, _PIECE_BYTES))):
        if progress is not None:
            progress.poll()
        left, found = left - len(piece), zlib.crc32(piece, found)
        yield piece
    if left > 0 or found != section.checksum:
        what = _Kind(section.kind).name.lower().replace("_", " ") if section.kind in set(_Kind) else "a section"
        raise ValueError(f"{what} of level {section.level}: damaged, copy or save the file again")


def _names(file: BinaryIO, sections: list[_Section]) -> tuple[bool, int, list[str]]:
    """Whether there are colours, bits of normals, and names of channels."""
    found = [section for section in sections if section.kind == _Kind.NAMES]
    if not found:
        return False, 0, []
    content = b"".join(_pieces(file, found[0]))
    has_colors, normal_bits, *_, channel_count = _NAMES.unpack_from(content)
    channels, at = [], _NAMES.size
    for _ in range(channel_count):
        (length,) = struct.unpack_from("<I", content, at)
        at += 4 + length
        channels.append(content[at - length : at].decode())
    return bool(has_colors), normal_bits, channels


def _bytes_by_part(sections: list[_Section], level: int) -> dict[str, int]:
    of_kind: Counter[int] = Counter()
    for section in sections:
        of_kind[section.kind] += section.byte_count
    is_empty = not of_kind[_Kind.LEAVES]
    formats = 0 if is_empty else _FORMAT_BYTES * (level - _LEAF_LEVEL)  # as memory has them, whatever the version
    parts = {
        "leaves": of_kind[_Kind.LEAVES],
        "pairs": of_kind[_Kind.PAIRS],
        "records": of_kind[_Kind.RECORDS] + formats + _OTHER_BYTES,
        "directories": of_kind[_Kind.DIRECTORY],
    }
    if of_kind[_Kind.NAMES]:
        parts |= {name: sum(of_kind[kind] for kind in kinds) for name, kinds in _ATTRIBUTES.items()}
    return parts


def _top_cube_counts(file: BinaryIO, sections: list[_Section]) -> list[int]:
    """Of level 1 on: each has a byte per cube of the level above, and a bit set for each cube of its own."""
    masks = sorted((section for section in sections if section.kind == _Kind.TOP_MASKS), key=lambda one: one.level)
    if [section.level for section in masks] != list(range(1, len(masks) + 1)):
        raise ValueError("a topmost level is missing: copy or save the file again")
    if not masks:
        return []
    last = sum(int.from_bytes(piece, "little").bit_count() for piece in _pieces(file, masks[-1]))
    return [*(section.byte_count for section in masks[1:]), last]
