# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's panels and previews read of a .tdag file: seconds, and the most memory beyond what Python takes.

  header    what the panel says: read_header
  import    the same, with every section's checksum: checked_header
  preview   blocks of at most 150,000 cubes of --level, with their colours: load_coarse
  levels    counts by level: the geometry
  whole     the same preview by way of the whole file, which a render reads, too

Each in a process of its own. seconds are of the wall, cpu_seconds of all threads. Without --file the Stanford dragon at
4,096, whose colours are its places. With scripts/python:

  benchmarks/voxel_preview_bench.py --file large.tdag --context build/logs/bench-context.json --output preview.json
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from process_memory import forget_most_memory, memory_bytes, most_memory_bytes

from tyndall.mesh_files import read_mesh
from tyndall.voxel_dag import (
    Config,
    VoxelDag,
    checked_header,
    exposed_cubes,
    exposed_faces,
    load,
    load_coarse,
    read_header,
    write_voxels,
)

if TYPE_CHECKING:
    from report import Row

_DATA = Path(os.environ.get("TYNDALL_SHARED_DATA", "../shared/data"))
_MOST_CUBES = 150_000


def _picture(dag: VoxelDag, level: int) -> int:
    """What a preview makes of it: how many faces."""
    cubes, found = dag.coarse_cubes(level, _MOST_CUBES)
    owners = exposed_cubes(cubes)
    faces = exposed_faces(cubes, owners)
    if dag.has_colors:
        colours = dag.colors_at(cubes << np.uint32(dag.resolution.bit_length() - 1 - found), found)
        return sum(len(colours[owned]) for owned in owners)
    return sum(len(part) for part in faces)


_WAYS: dict[str, Callable[[Path, int], object]] = {
    "header": lambda path, _level: read_header(path),
    "import": lambda path, _level: checked_header(path),
    "preview": lambda path, level: _picture(load_coarse(path, level, _MOST_CUBES), level),
    "levels": lambda path, _level: load(path, attributes=False).levels(),
    "whole": lambda path, level: _picture(load(path), level),
}


def _measure(way: str, path: str, level: int) -> None:
    """In a process of its own. Prints JSON."""
    forget_most_memory()
    before = memory_bytes()
    begun, begun_cpu = time.perf_counter(), time.process_time()
    found = _WAYS[way](Path(path), level)
    figures = {
        "seconds": time.perf_counter() - begun,
        "cpu_seconds": time.process_time() - begun_cpu,
        "peak_bytes": most_memory_bytes() - before,
    }
    if isinstance(found, int):
        figures["faces"] = found
    print(json.dumps(figures))


def main() -> None:
    """Measure each way, and write the report."""
    from report import argument_parser, write_report  # noqa: PLC0415 - with bpy, whose memory is not to be measured

    parser = argument_parser(__doc__)
    parser.add_argument("--file", type=Path)
    parser.add_argument("--level", type=int, default=8)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write_report(_rows(chosen.file or _coloured_dragon(Path(folder) / "dragon.tdag"), chosen.level), chosen)


def _coloured_dragon(path: Path) -> Path:
    positions_m, triangles = read_mesh(_DATA / "dragon/dragon_vrip.ply.gz")
    lower_m = positions_m.min(axis=0)
    colors = (255 * (positions_m - lower_m) / np.ptp(positions_m, axis=0)).astype(np.uint8)
    write_voxels(positions_m.astype(np.float32), triangles, path, Config(resolution=4096, colors=colors))
    return path


def _rows(path: Path, level: int) -> list[Row]:
    from report import row  # noqa: PLC0415 - the same

    header = read_header(path)
    print(header)
    modules = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    rows = []
    for way in _WAYS:
        code = f"import voxel_preview_bench as bench; bench._measure({way!r}, {str(path)!r}, {level})"
        command, environment = [sys.executable, "-c", code], os.environ | {"PYTHONPATH": modules}
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        figures = json.loads(done.stdout)
        print(way, figures, flush=True)
        size = {"file_bytes": path.stat().st_size, "geometry_bytes": header.geometry_bytes}
        rows.append(row(f"read/{way}", figures.pop("seconds"), **figures, **size))
    return rows


if __name__ == "__main__":
    main()
