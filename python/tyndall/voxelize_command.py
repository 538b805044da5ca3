# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m tyndall voxelize FILE --resolution 65536 --out OUT.tdag``: a scene or mesh as a voxel DAG."""

from __future__ import annotations

import argparse
import re
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .frame_files import require_writable

EPILOG = """exit codes: 0 the file is there; 2 the arguments, the mesh or its size are at fault; 3 a file cannot be read
or written; 130 interrupted. Finished parts are kept: the same command goes on from them."""
_UNITS = {"": 1, "k": 2**10, "m": 2**20, "g": 2**30, "t": 2**40}
_TOLD_EVERY_S = 2.0

#: ``read(path, scene, resolution, with_colors, with_normals)`` gives positions in metres, (n, 3), triangles, (m, 3),
#: and settings of ``Config`` that say what voxels carry.
Read = Callable[[Path, str | None, int, bool, bool], tuple[Any, Any, dict[str, Any]]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Those of the command."""
    add = parser.add_argument
    add("file", type=Path, help="scene.blend, mesh.ply, .obj or .npz (positions_m, triangles); .ply.gz, too")
    add("--resolution", type=int, required=True, help="voxels a side, a power of two up to 131072")
    add("--out", type=Path, required=True, help="OUT.tdag")
    add("--rule", choices=("thin", "conservative"), default="thin", help="6- or 26-separating; thin unless said")
    add("--solid", action="store_true", help="what a closed mesh has inside, too; without colours and normals")
    add("--symmetry", choices=("none", "reflections", "cube"), default="cube", help="what may turn equal parts")
    add("--budget", type=_bytes, default=None, help="memory, such as 512MiB or 4GiB; 2GiB unless said")
    add("--scratch", type=Path, default=None, help="for finished parts; all workers see it; OUT's folder unless said")
    add("--scene", default=None, help="the scene's name in a .blend, if not its active one")
    add("--colors", action="store_true", help="of a .blend's materials, or of the vertices of a .ply or .npz (colors)")
    add("--normals", action="store_true", help="the smooth ones of a .blend, or those of the file's vertices (normals)")
    add(
        "--color-difference",
        type=float,
        default=None,
        help="so much CIE94 colours may differ; all are kept unless said",
    )
    add("--normal-bits", type=int, default=None, help="of a normal, 8 to 32; 32 unless said")
    workers = parser.add_mutually_exclusive_group()
    workers.add_argument("--processes", type=int, default=None, help="this many on this machine share the budget")
    workers.add_argument("--scheduler", default=None, help="Dask's, tcp://10.0.0.1:8786; each worker has the budget")


def run(options: argparse.Namespace, read_blend: Read) -> int:
    """Raises ValueError for what is wrong with arguments or mesh, OSError for files, KeyboardInterrupt."""
    from . import Progress, voxel_dag  # noqa: PLC0415 - the native part, without which the help is still told

    if not options.file.is_file():
        raise ValueError(f"there is no file {options.file}")
    if options.out.suffix != ".tdag":
        raise ValueError(f"{options.out.name}: the output's suffix is .tdag")
    if options.processes is not None and options.processes < 1:
        raise ValueError(f"{options.processes} processes make nothing")
    require_writable(options.out.absolute().parent)
    if options.scratch is not None:
        require_writable(options.scratch.absolute())
    positions_m, triangles, carried = _mesh(options, read_blend)
    if options.color_difference is not None:
        carried["most_color_difference"] = options.color_difference
    if options.normal_bits is not None:
        carried["normal_bits"] = options.normal_bits
    config = voxel_dag.Config(
        resolution=options.resolution,
        rule=options.rule,
        solid=options.solid,
        symmetry=options.symmetry,
        memory_budget_bytes=options.budget,
        **carried,
    )
    _say(f"{len(triangles):,} triangles")
    _say(str(voxel_dag.forecast(positions_m, triangles, config)))
    started, progress = time.perf_counter(), Progress()
    made = _told(
        progress,
        lambda: voxel_dag.write_voxels(
            positions_m,
            triangles,
            options.out,
            config,
            scratch=options.scratch,
            progress=progress,
            workers=options.scheduler or options.processes,
        ),
    )
    size = options.out.stat().st_size
    seconds = time.perf_counter() - started
    _say(f"{options.out}: {made.voxel_count:,} voxels, {made.node_count:,} nodes, {size:,} bytes, {seconds:.1f} s")
    return 0


def _mesh(options: argparse.Namespace, read_blend: Read) -> tuple[Any, Any, dict[str, Any]]:
    """Positions, triangles, and what voxels carry of those that were asked for."""
    from .mesh_files import is_mesh_file, read_mesh_file  # noqa: PLC0415 - the native part's errors

    if is_mesh_file(options.file):
        mesh, carried = read_mesh_file(options.file), {}
        for name in ("colors", "normals"):
            if getattr(options, name):
                if (values := getattr(mesh, name)) is None:
                    raise ValueError(f"{options.file.name}: its vertices have no {name}")
                carried[name] = values
        return mesh.positions_m, mesh.triangles, carried
    if options.file.suffix != ".blend":
        raise ValueError(f"{options.file.name}: it may be a .blend, .ply, .obj or .npz file")
    return read_blend(options.file.absolute(), options.scene, options.resolution, options.colors, options.normals)


def _told(progress: Any, work: Callable[[], Any]) -> Any:  # noqa: ANN401 - of the native part; what work gives
    """Do the work in a thread, and say how far it is; Ctrl-C cancels it."""
    outcome: dict[str, Any] = {}

    def call() -> None:
        try:
            outcome["dag"] = work()
        except BaseException as error:  # noqa: BLE001 - raised by who waits
            outcome["error"] = error

    thread = threading.Thread(target=call, name="voxelize")
    thread.start()
    try:
        while thread.is_alive():
            thread.join(_TOLD_EVERY_S)
            if thread.is_alive() and progress.message:
                _say(f"{100 * progress.fraction:3.0f} % {progress.message}")
    except KeyboardInterrupt:
        progress.cancel()
        thread.join()
        raise
    if "error" in outcome:
        raise outcome["error"]
    return outcome["dag"]


def _bytes(text: str) -> int:
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([kmgt]?)(?:i?b)?", text.strip().lower())
    if match is None:
        raise argparse.ArgumentTypeError(f"{text} is no amount of memory such as 512MiB or 2GiB")
    return round(float(match[1]) * _UNITS[match[2]])


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
