# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles of .ply, .obj and .npz files, also gzipped ones (.ply.gz), and what vertices have: colours and normals."""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tyndall._native import IoError

#: Positions (n, 3) float64, as the file has them, and triangles (m, 3) uint32.
TriangleMesh = tuple[NDArray[np.float64], NDArray[np.uint32]]


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshFile:
    """What a file holds of a mesh."""

    positions_m: NDArray[np.float64]  #: (n, 3), as the file has them.
    triangles: NDArray[np.uint32]  #: (m, 3)
    colors: NDArray[Any] | None = None  #: (n, 3), uint8 or 0 to 1, as sRGB encodes them; .obj files: none are read.
    normals: NDArray[Any] | None = None  #: (n, 3); .obj files: none are read.


_PLY_TYPES = {
    name: kind
    for names, kind in (
        ("char int8", "i1"),
        ("uchar uint8", "u1"),
        ("short int16", "i2"),
        ("ushort uint16", "u2"),
        ("int int32", "i4"),
        ("uint uint32", "u4"),
        ("float float32", "f4"),
        ("double float64", "f8"),
    )
    for name in names.split()
}
_PLY_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
SUFFIXES = (".ply", ".obj", ".npz")


def is_mesh_file(path: Path) -> bool:
    """Whether ``read_mesh`` knows such names."""
    return _suffix(path) in SUFFIXES


def read_mesh(path: Path) -> TriangleMesh:
    """Positions and triangles of ``read_mesh_file``."""
    mesh = read_mesh_file(path)
    return mesh.positions_m, mesh.triangles


def read_mesh_file(path: Path) -> MeshFile:
    """Faces of more corners become fans. Raises IoError, which names the path and what is wrong, and OSError."""
    if not is_mesh_file(path):
        raise IoError(f"{path}: a mesh may be {', '.join(SUFFIXES)}, or one of these and .gz")
    try:
        if _suffix(path) == ".npz":
            return _npz(path)
        content = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        return (_ply if _suffix(path) == ".ply" else _obj)(content)
    except (ValueError, KeyError, IndexError, EOFError, gzip.BadGzipFile) as error:
        raise IoError(f"{path}: {error}: export it again, or as another type of file") from error


def _suffix(path: Path) -> str:
    return (path.with_suffix("") if path.suffix == ".gz" else path).suffix.lower()


def _npz(path: Path) -> MeshFile:
    with np.load(path) as arrays:
        if missing := {"positions_m", "triangles"} - set(arrays.files):
            raise ValueError(f"the arrays {', '.join(sorted(missing))} are not there")
        return MeshFile(
            positions_m=np.asarray(arrays["positions_m"], np.float64),
            triangles=np.asarray(arrays["triangles"], np.uint32),
            colors=arrays.get("colors"),
            normals=arrays.get("normals"),
        )


def _fans(counts: NDArray[np.int64], corners: NDArray[np.int64]) -> NDArray[np.uint32]:
    """Triangles of faces whose corners come one face after the other."""
    first = np.cumsum(counts) - counts
    triangle_counts = np.maximum(counts - 2, 0)
    face = np.repeat(np.arange(len(counts)), triangle_counts)
    within = np.arange(triangle_counts.sum()) - np.repeat(np.cumsum(triangle_counts) - triangle_counts, triangle_counts)
    begin = first[face]
    triangles = np.stack([corners[begin], corners[begin + within + 1], corners[begin + within + 2]], axis=-1)
    if triangles.size and triangles.min() < 0:
        raise ValueError("a face has a negative corner")
    return triangles.astype(np.uint32)


def _obj(content: bytes) -> MeshFile:
    positions: list[list[bytes]] = []
    counts: list[int] = []
    corners: list[int] = []
    for line in content.replace(b"\\\n", b" ").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == b"v":
            positions.append(words[1:4])
        elif words[0] == b"f":
            face = [int(word.split(b"/", 1)[0]) for word in words[1:]]
            counts.append(len(face))
            # From 1 on; negative ones count back from the last vertex so far.
            corners += [corner - 1 if corner > 0 else len(positions) + corner for corner in face]
    return MeshFile(
        positions_m=np.array(positions, np.float64).reshape(-1, 3),
        triangles=_fans(np.array(counts, np.int64), np.array(corners, np.int64)),
    )


def _ply(content: bytes) -> MeshFile:
    end = content.index(b"end_header")
    header = [line.split() for line in content[:end].decode("ascii", "replace").splitlines()]
    body = content[content.index(b"\n", end) + 1 :]
    if header[0] != ["ply"]:
        raise ValueError("it is no .ply file")
    order = _PLY_FORMATS[next(words[1] for words in header if words[:1] == ["format"])]
    elements: list[tuple[str, int, list[list[str]]]] = []
    for words in header:
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    numbers = _Numbers(body, order)
    positions, faces = np.zeros((0, 3)), np.zeros((0, 3), np.uint32)
    colors: NDArray[Any] | None = None
    normals: NDArray[Any] | None = None
    for name, count, properties in elements:
        columns = _element(numbers, count, properties)
        if name == "vertex":
            positions = np.stack([columns[axis][1] for axis in "xyz"], axis=-1).astype(np.float64)
            colors = _ply_colors(columns, properties)
            normals = _three(columns, ("nx", "ny", "nz"))
        elif name == "face":
            counts, corners = columns["vertex_indices" if "vertex_indices" in columns else "vertex_index"]
            faces = _fans(counts, corners.astype(np.int64))
    return MeshFile(positions_m=positions, triangles=faces, colors=colors, normals=normals)


def _three(columns: dict[str, tuple[NDArray[Any], NDArray[Any]]], names: tuple[str, str, str]) -> NDArray[Any] | None:
    if not all(name in columns for name in names):
        return None
    return np.stack([columns[name][1] for name in names], axis=-1)


def _ply_colors(
    columns: dict[str, tuple[NDArray[Any], NDArray[Any]]], properties: list[list[str]]
) -> NDArray[Any] | None:
    """Bytes, or numbers from 0 to 1, by the type that the header states: a text has numbers alone."""
    colors = _three(columns, ("red", "green", "blue"))
    if colors is None:
        return None
    kind = next(_PLY_TYPES[words[0]] for words in properties if words[-1] == "red")
    if kind not in ("u1", "f4", "f8"):
        raise ValueError(f"colours are {kind}, neither uchar nor float")
    return colors.astype(np.uint8 if kind == "u1" else np.float64)


class _Numbers:
    """Those of a .ply file's body, from its begin to its end."""

    def __init__(self, body: bytes, order: str) -> None:
        self._body, self._order = body, order
        self._text = np.fromstring(body, np.float64, sep=" ") if order == "" else None
        self.at = 0  #: How many numbers of a text, or bytes, are behind.

    def take(self, kinds: list[str], count: int = 1) -> list[NDArray[Any]]:
        """Columns of rows of numbers."""
        dtype = np.dtype([(str(column), self._order + kind) for column, kind in enumerate(kinds)])
        size = count * (dtype.itemsize if self._text is None else len(kinds))
        if self.at + size > len(self._body if self._text is None else self._text):
            raise ValueError("it ends too early")
        self.at += size
        if self._text is not None:
            return list(self._text[self.at - size : self.at].reshape(count, -1).T)
        table = np.frombuffer(self._body, dtype, count, self.at - size)
        return [table[str(column)] for column in range(len(kinds))]


def _element(
    numbers: _Numbers, count: int, properties: list[list[str]]
) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
    """By property: how many values each row has, and all of them, one row after the other."""
    begin = numbers.at
    first = [_values(numbers, words) for words in properties] if count else []
    numbers.at = begin
    try:  # nearly always rows are alike: triangles alone
        return _alike_rows(numbers, count, properties, [len(values) for values in first])
    except ValueError:
        numbers.at = begin
    rows = [[_values(numbers, words) for words in properties] for _ in range(count)]
    return {
        words[-1]: (np.array([len(row[column]) for row in rows]), np.concatenate([row[column] for row in rows]))
        for column, words in enumerate(properties)
    }


def _values(numbers: _Numbers, words: list[str]) -> NDArray[Any]:
    """Of one property in one row: ``float x``, or ``list uchar int vertex_indices``."""
    count = int(numbers.take([_PLY_TYPES[words[1]]])[0][0]) if words[0] == "list" else 1
    return np.array([column[0] for column in numbers.take([_PLY_TYPES[words[-2]]] * count)])


def _alike_rows(
    numbers: _Numbers, count: int, properties: list[list[str]], lengths: list[int]
) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
    """Raises ValueError if a list has another length than in the first row."""
    kinds: list[str] = []
    for words, length in zip(properties, lengths, strict=count > 0):
        kinds += [*([_PLY_TYPES[words[1]]] if words[0] == "list" else []), *[_PLY_TYPES[words[-2]]] * length]
    columns = numbers.take(kinds, count) if count else []
    found, at = {}, 0
    for words, length in zip(properties, lengths or [0] * len(properties), strict=True):
        if count and words[0] == "list":
            if (columns[at] != length).any():
                raise ValueError("rows differ")
            at += 1
        values = np.stack(columns[at : at + length], axis=-1).ravel() if length * count else np.zeros(0)
        found[words[-1]] = (np.full(count, length), values)
        at += length
    return found
