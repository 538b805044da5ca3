# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes to .tdag files out of core: seconds, bytes, and the most memory of a process that does nothing else.

Without --resolution, the dragon at 8192 in budgets of 128 MiB and 2 GiB, whose files are compared. The figures of
docs/voxel-dags.md, minutes each: --mesh dragon --resolution 32768, and --mesh sponza --resolution 65536.
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tyndall import Progress
from tyndall.mesh_files import TriangleMesh, read_mesh
from tyndall.voxel_dag import Config
from tyndall.voxel_dag.parts import parts_of

_DATA = Path(os.environ.get("TYNDALL_SHARED_DATA", "../shared/data"))
#: Of Sponza_LowPoly.bin, as its .gltf states them: positions' offset and count, indices' offset and count, two meshes.
_SPONZA = ((0, 64806, 777672, 175905), (1129484, 4697, 1185848, 13347))


def _mesh(name: str) -> TriangleMesh:
    if name == "dragon":
        return read_mesh(_DATA / "dragon/dragon_vrip.ply.gz")
    content = (_DATA / "sponza_lowpoly/Sponza_LowPoly.bin").read_bytes()
    positions, triangles, first = [], [], 0
    for position_offset, position_count, index_offset, index_count in _SPONZA:
        positions.append(np.frombuffer(content, "<f4", 3 * position_count, position_offset).reshape(-1, 3))
        triangles.append(
            np.frombuffer(content, "<u2", index_count, index_offset).reshape(-1, 3).astype(np.uint32) + first
        )
        first += position_count
    return np.concatenate(positions), np.concatenate(triangles)


def _measure(name: str, resolution: int, budget_bytes: int) -> None:
    """In a process of its own, whose peak of memory is this one's. Prints JSON."""
    positions, triangles = _mesh(name)
    config = Config(resolution=resolution, memory_budget_bytes=budget_bytes)
    with tempfile.TemporaryDirectory() as folder:
        begun, progress = time.perf_counter(), Progress()
        out = Path(folder) / "a.tdag"
        made = parts_of(positions.astype(np.float32), triangles, config, Path(folder), progress).finish(out, progress)
        figures = {
            "seconds": time.perf_counter() - begun,
            "cpu_seconds": time.process_time(),
            "peak_bytes": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
            "file_bytes": out.stat().st_size,
            "digest": hashlib.blake2b(out.read_bytes(), digest_size=8).hexdigest(),
            **{
                key: getattr(made, key)
                for key in (
                    "voxel_count",
                    "node_count",
                    "geometry_bytes",
                    "part_count",
                    "part_bytes",
                    "join_pass_count",
                )
            },
        }
    print(json.dumps(figures))


def _row(name: str, resolution: int, budget_bytes: int) -> dict[str, Any]:
    from report import row  # noqa: PLC0415 - with bpy, whose memory is not to be measured

    code = f"import out_of_core_bench as bench; bench._measure({name!r}, {resolution}, {budget_bytes})"
    paths = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": paths},
    )
    figures = json.loads(done.stdout)
    print(name, resolution, figures)
    return row(f"out_of_core/{name}/{resolution}/{budget_bytes >> 20}MiB", figures.pop("seconds"), **figures)


def main() -> None:
    """Measure what is asked for, and write the report."""
    from report import argument_parser, write_report  # noqa: PLC0415 - the same

    parser = argument_parser(__doc__)
    parser.add_argument("--mesh", choices=("dragon", "sponza"), default="dragon")
    parser.add_argument("--resolution", type=int)
    parser.add_argument("--budget-mib", type=int, default=2048)
    arguments = parser.parse_args()
    if arguments.resolution is not None:
        rows = [_row(arguments.mesh, arguments.resolution, arguments.budget_mib << 20)]
    else:
        rows = [_row(arguments.mesh, 8192, budget << 20) for budget in (128, 2048)]
        if len({one["digest"] for one in rows}) != 1:
            raise RuntimeError("the files differ")
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
