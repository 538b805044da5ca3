# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what Blender writes: uncompressed OpenEXR files of scanlines, float or half, of one part or several."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_DTYPES = {1: np.dtype("<f2"), 2: np.dtype("<f4")}


def read_channels(path: Path) -> dict[str, NDArray[np.float32]]:
    """Channels by name, such as ``ViewLayer.Normal.X`` or ``R``: (height, width), rows bottom to top."""
    content = path.read_bytes()
    is_multipart = bool(content[5] & 0x10)  # as Blender 5.0 writes layers
    headers, at = _headers(content, is_multipart=is_multipart)
    channels: dict[str, NDArray[np.float32]] = {}
    for header in headers:
        if header["compression"][0] != 0:
            raise ValueError(f"{path} is compressed: render it with exr_codec NONE")
        x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
        width, height = x1 - x0 + 1, y1 - y0 + 1
        offsets = struct.unpack_from(f"<{height}Q", content, at)
        at += 8 * height
        planes = {name: np.empty((height, width), np.float32) for name, _ in _channels(header["channels"])}
        for offset in offsets:
            chunk = offset + 4 * is_multipart  # the number of the part comes first
            (y,) = struct.unpack_from("<i", content, chunk)
            start = chunk + 8
            for name, dtype in _channels(header["channels"]):
                planes[name][y - y0] = np.frombuffer(content, dtype, width, start)
                start += width * dtype.itemsize
        part = header.get("name", b"").decode()
        for name, plane in planes.items():
            channels[name if "." in name or not part else f"{part}.{name}"] = plane[::-1]
    return channels


def read_planes(path: Path) -> dict[str, NDArray[np.float32]]:
    """Passes by ``layer.pass``: (height, width, channels) in the order RGBA, XYZW, UVA. A plain picture is ""."""
    grouped: dict[str, dict[str, NDArray[np.float32]]] = {}
    for name, plane in read_channels(path).items():
        group, _, channel = name.rpartition(".")
        grouped.setdefault(group, {})[channel] = plane

    def place(channel: str) -> int:
        return "RXUGYVBZAW".index(channel.upper())

    return {
        group: np.stack([planes[channel] for channel in sorted(planes, key=place)], axis=-1)
        for group, planes in grouped.items()
    }


def read_stamps(path: Path) -> dict[str, str]:
    """What the file says about its picture, in words, by name."""
    content = path.read_bytes()
    headers, _ = _headers(content, is_multipart=bool(content[5] & 0x10))
    return {
        name: value.decode() for header in headers for name, value in header.items() if name.startswith("cryptomatte/")
    }


def _headers(content: bytes, *, is_multipart: bool) -> tuple[list[dict[str, bytes]], int]:
    headers, at = [], 8  # after the magic number and the version
    while not headers or (is_multipart and content[at] != 0):
        attributes: dict[str, bytes] = {}
        while content[at] != 0:
            name, at = _text(content, at)
            _kind, at = _text(content, at)
            (size,) = struct.unpack_from("<i", content, at)
            attributes[name] = content[at + 4 : at + 4 + size]
            at += 4 + size
        headers.append(attributes)
        at += 1
    return headers, at + is_multipart


def _text(content: bytes, at: int) -> tuple[str, int]:
    end = content.index(0, at)
    return content[at:end].decode(), end + 1


def _channels(content: bytes) -> list[tuple[str, np.dtype]]:
    channels, at = [], 0
    while content[at] != 0:
        name, at = _text(content, at)
        channels.append((name, _DTYPES[struct.unpack_from("<i", content, at)[0]]))
        at += 16
    return channels
