# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes to .tdag files out of core: seconds, bytes, and the most memory of a process that does nothing else.

Without --resolution, the dragon at 8192 in budgets of 128 MiB and 2 GiB, whose files are compared. The figures of
docs/voxel-dags.md, minutes each: --mesh dragon --resolution 32768, and --mesh sponza --resolution 65536. With --colors
vertices have, interpolated and kept as they come out, 12 bits of a formula, that of dag_attributes_bench.cpp, of their
place x, y, z in the box, by its longest side, and their normal n, the mean of faces by area: check * marble * lambert,
where check is 1 or 0.55, of 16 x 16 x 16 cubes; marble goes from (0.9, 0.85, 0.75) to (0.3, 0.45, 0.6) as
1/2 + 1/2 sin(120 x + 18 sin 14 y + 12 sin 17 z); lambert = 1/4 + 3/4 max(0, n . (0.48, 0.36, 0.8)).
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from bare_meshes import bare_mesh
from numpy.typing import NDArray
from process_memory import most_memory_bytes

from tyndall import Progress
from tyndall.voxel_dag import Config, load
from tyndall.voxel_dag.parts import parts_of


def _colors(positions: NDArray[np.float64], triangles: NDArray[np.uint32]) -> NDArray[np.uint8]:
    """(n, 3), by the formula above."""
    corners = positions[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(positions)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], faces)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    at = (positions - positions.min(axis=0)) / np.ptp(positions, axis=0).max()
    check = np.where(np.floor(16 * at).sum(axis=1) % 2 == 0, 1.0, 0.55)
    x, y, z = at.T
    vein = 0.5 + 0.5 * np.sin(120 * x + 18 * np.sin(14 * y) + 12 * np.sin(17 * z))
    shade = check * (0.25 + 0.75 * np.maximum(normals @ [0.48, 0.36, 0.8], 0.0))
    light, dark = np.array([0.9, 0.85, 0.75]), np.array([0.3, 0.45, 0.6])
    colors = shade[:, None] * (light + vein[:, None] * (dark - light))
    return (17 * np.rint(15 * np.clip(colors, 0.0, 1.0))).astype(np.uint8)


def _measure(
    name: str, resolution: int, budget_bytes: int, *, has_colors: bool, scratch: str | None, keep: str | None
) -> None:
    """In a process of its own, whose peak of memory is this one's. Prints JSON."""
    positions, triangles = bare_mesh(name)
    config = Config(resolution=resolution, memory_budget_bytes=budget_bytes)
    if has_colors:
        config = replace(config, colors=_colors(positions.astype(np.float64), triangles))
    with tempfile.TemporaryDirectory() as folder:
        begun, progress = time.perf_counter(), Progress()
        out = Path(keep or folder + "/a.tdag")
        parts = parts_of(positions.astype(np.float32), triangles, config, Path(scratch or folder), progress)
        made = parts.finish(out, progress)
        figures = {
            "seconds": time.perf_counter() - begun,
            "cpu_seconds": time.process_time(),
            "peak_bytes": most_memory_bytes(),
            "file_bytes": out.stat().st_size,
            "digest": _digest(out),
            **{
                key: getattr(made, key)
                for key in (
                    "voxel_count",
                    "node_count",
                    "geometry_bytes",
                    "attribute_bytes",
                    "kept_part_count",
                    "part_count",
                    "part_bytes",
                    "join_pass_count",
                )
            },
        }
        if has_colors:  # after the peak was taken
            nodes = sum(level.tree_node_count for level in load(out).levels())
            figures |= {
                "bytes_per_voxel": figures["file_bytes"] / made.voxel_count,
                "bytes_per_voxel_of_all_levels": figures["file_bytes"] / (made.voxel_count + nodes),
            }
    print(json.dumps(figures))


def _digest(path: Path) -> str:
    digest = hashlib.blake2b(digest_size=8)
    with path.open("rb") as file:
        while piece := file.read(1 << 24):
            digest.update(piece)
    return digest.hexdigest()


def _row(name: str, resolution: int, budget_bytes: int, *, has_colors: bool, **paths: str | None) -> dict[str, Any]:
    from report import row  # noqa: PLC0415 - with bpy, whose memory is not to be measured

    code = f"import out_of_core_bench as bench; bench._measure({name!r}, {resolution}, {budget_bytes}, "
    code += f"has_colors={has_colors}, scratch={paths.get('scratch')!r}, keep={paths.get('keep')!r})"
    modules = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": modules},
    )
    figures = json.loads(done.stdout)
    print(name, resolution, figures)
    kind = "colors/" if has_colors else ""
    return row(f"out_of_core/{kind}{name}/{resolution}/{budget_bytes >> 20}MiB", figures.pop("seconds"), **figures)


def main() -> None:
    """Measure what is asked for, and write the report."""
    from report import argument_parser, write_report  # noqa: PLC0415 - the same

    parser = argument_parser(__doc__)
    parser.add_argument("--mesh", choices=("dragon", "sponza"), default="dragon")
    parser.add_argument("--resolution", type=int)
    parser.add_argument("--budget-mib", type=int, default=2048)
    parser.add_argument("--colors", action="store_true", help="vertices have the colours of the formula")
    parser.add_argument("--scratch", help="parts stay here if it is stopped; the time is then that of what was left")
    parser.add_argument("--keep", help="the file stays here, instead of going")
    arguments = parser.parse_args()
    how = {"has_colors": arguments.colors, "scratch": arguments.scratch, "keep": arguments.keep}
    if arguments.resolution is not None:
        rows = [_row(arguments.mesh, arguments.resolution, arguments.budget_mib << 20, **how)]
    else:
        rows = [_row(arguments.mesh, 8192, budget << 20, **how) for budget in (128, 2048)]
        if len({one["digest"] for one in rows}) != 1:
            raise RuntimeError("the files differ")
    write_report(rows, arguments)


if __name__ == "__main__":
    main()
