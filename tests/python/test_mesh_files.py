# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in files: the same triangles from every type, and a message that names what cannot be read."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path

import numpy as np
import pytest

import tyndall
from tyndall.mesh_files import read_mesh, read_mesh_file

POSITIONS = [[0.0, 0.5, 1.0], [2.0, 0.25, 0.0], [1.0, 1.0, 4.0], [-1.0, 8.0, 0.125], [3.0, 3.0, 3.0]]
#: A triangle and a face of four corners, which becomes a fan.
FACES = [[0, 1, 2], [1, 2, 3, 4]]
TRIANGLES = [[0, 1, 2], [1, 2, 3], [1, 3, 4]]


def ply(kind: str, faces: list[list[int]] = FACES) -> bytes:
    """With what other programs add: a colour of vertices, a flag of faces, an element of edges."""
    header = (
        f"ply\nformat {kind} 1.0\ncomment of a test\nelement vertex {len(POSITIONS)}\nproperty float x\n"
        f"property float y\nproperty double z\nproperty uchar red\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
        "property uchar flag\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    )
    if kind == "ascii":
        rows = [f"{x} {y} {z} 7" for x, y, z in POSITIONS] + [f"{len(f)} {' '.join(map(str, f))} 1" for f in faces]
        return (header + "\n".join([*rows, "0 1"]) + "\n").encode()
    order = "<" if kind == "binary_little_endian" else ">"
    body = b"".join(struct.pack(f"{order}ffdB", *position, 7) for position in POSITIONS)
    body += b"".join(struct.pack(f"{order}B{len(face)}iB", len(face), *face, 1) for face in faces)
    return header.encode() + body + struct.pack(f"{order}ii", 0, 1)


OBJ = b"# of a test\no thing\n" + b"".join(b"v %g %g %g\n" % tuple(position) for position in POSITIONS)
OBJ += b"vt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 3/1/1\nf -4//1 -3//1 \\\n-2//1 -1//1\n"


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ply", ply("ascii")),
        ("b.ply", ply("binary_little_endian")),
        ("c.PLY", ply("binary_big_endian")),
        ("d.ply.gz", gzip.compress(ply("ascii"))),
        ("e.obj", OBJ),
        ("f.obj.gz", gzip.compress(OBJ.replace(b"\n", b"\r\n").replace(b"\\\r\n", b"\\\n"))),
    ],
)
def test_every_type_gives_the_same_triangles(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    positions_m, triangles = read_mesh(tmp_path / name)
    assert positions_m.tolist() == POSITIONS
    assert (triangles.tolist(), triangles.dtype) == (TRIANGLES, np.uint32)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
def test_faces_of_one_size_and_none_at_all(tmp_path: Path, kind: str) -> None:
    for faces in ([[0, 1, 2], [2, 3, 4]], []):
        (tmp_path / "a.ply").write_bytes(ply(kind, faces))
        positions_m, triangles = read_mesh(tmp_path / "a.ply")
        assert positions_m.tolist() == POSITIONS
        assert triangles.reshape(-1, 3).tolist() == faces


def test_arrays_are_read_back(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", positions_m=np.array(POSITIONS, np.float32), triangles=np.array(TRIANGLES))
    positions_m, triangles = read_mesh(tmp_path / "a.npz")
    assert (positions_m.tolist(), triangles.tolist()) == (POSITIONS, TRIANGLES)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
def test_colours_and_normals_of_vertices_are_read(tmp_path: Path, kind: str) -> None:
    names = ("x", "y", "z", "nx", "ny", "nz")
    header = f"ply\nformat {kind} 1.0\nelement vertex 3\n" + "".join(f"property float {name}\n" for name in names)
    header += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue", "alpha"))
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [(*position, 0.0, -1.0, 0.5, 7, 90 + i, 255, 1) for i, position in enumerate(POSITIONS[:3])]
    if kind == "ascii":
        content = header + "".join(" ".join(map(str, row)) + "\n" for row in rows) + "3 0 1 2\n"
        (tmp_path / "a.ply").write_text(content)
    else:
        body = b"".join(struct.pack("<6f4B", *row) for row in rows) + struct.pack("<B3i", 3, 0, 1, 2)
        (tmp_path / "a.ply").write_bytes(header.encode() + body)
    mesh = read_mesh_file(tmp_path / "a.ply")
    assert mesh.colors is not None
    assert (mesh.colors.tolist(), mesh.colors.dtype) == ([[7, 90, 255], [7, 91, 255], [7, 92, 255]], np.uint8)
    assert mesh.normals is not None
    assert mesh.normals.tolist() == [[0.0, -1.0, 0.5]] * 3
    (tmp_path / "b.ply").write_bytes(ply("ascii"))  # red alone is no colour
    assert read_mesh_file(tmp_path / "b.ply").colors is None


@pytest.mark.parametrize(
    ("name", "content", "culprit"),
    [
        ("a.ply", ply("ascii")[:-40], "too early"),
        ("a.ply", ply("binary_little_endian")[:-20], "too early"),
        ("a.ply", b"play\nend_header\n", "no .ply file"),
        ("a.ply", b"", "a.ply"),
        ("a.obj", b"v 0 0 x\n", "a.obj"),
        ("a.obj", b"v 0 0 0\nf 1 2 -5\n", "negative"),
        ("a.ply.gz", b"no gzip", "a.ply.gz"),
        ("a.stl", b"solid", ".ply, .obj, .npz"),
    ],
)
def test_what_cannot_be_read_is_named(tmp_path: Path, name: str, content: bytes, culprit: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(tyndall.IoError, match=culprit):
        read_mesh(tmp_path / name)


def test_arrays_that_are_missing_are_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", positions=np.array(POSITIONS))
    with pytest.raises(tyndall.IoError, match="positions_m, triangles are not there"):
        read_mesh(tmp_path / "a.npz")
