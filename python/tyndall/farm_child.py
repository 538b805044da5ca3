# SPDX-License-Identifier: GPL-3.0-or-later
"""A process with bpy that does one task of a farm: ``python -m tyndall.farm_child``, started by ``tyndall.farm_tasks``.

The task is a line of JSON on standard input, which stays open: when it ends, who asked is gone, and so is this process.
The answer goes to the file that the task names.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import sys
import threading
import time
from pathlib import Path
from typing import Any

import tyndall
from tyndall.command_line import Settings
from tyndall.frame_files import completed

_LONGEST_END_S = 20.0  #: A render that does not end on Ctrl-C in this time is left as it is.


def main() -> None:
    """Answers {"result": ...} or {"error": ...}."""
    task = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_caller, daemon=True).start()
    try:
        answer: dict[str, Any] = {"result": _do(task)}
    except (RuntimeError, ValueError, OSError, ModuleNotFoundError) as error:
        answer = {"error": str(error) or type(error).__name__}
    Path(task["answer"]).write_text(json.dumps(answer))


def _end_with_caller() -> None:
    sys.stdin.read()
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(_LONGEST_END_S)
    os._exit(1)


def _do(task: dict[str, Any]) -> Any:  # noqa: ANN401 - JSON
    forced = _forced(task["simd"])
    try:
        from . import blender  # noqa: PLC0415 - its absence is an answer
    except ModuleNotFoundError as error:
        if error.name != "bpy":
            raise
        raise RuntimeError(
            f"{sys.executable} has no bpy: pip install bpy==4.5.*, or let TYNDALL_BPY_PYTHON name a Python that has it"
        ) from error
    versions = {"Tyndall": tyndall.__version__, "Blender": blender.version()}
    for name, wanted in task["versions"].items():
        if versions[name] != wanted:
            raise RuntimeError(f"it has {name} {versions[name]}, not {wanted}: all machines need the same")
    if task["kind"] == "probe":
        return versions
    from .blender.blend_file import OpenBlendFile  # noqa: PLC0415 - needs bpy

    blend = OpenBlendFile(Path(task["file"]), Settings(**task["settings"]))
    if task["kind"] == "describe":
        return {
            "versions": versions,
            "frames": blend.frames,
            "layers": blend.layer_names,
            "why_not_layers": blend.why_not_in_parts(has_tiles=False),
            "why_not_tiles": blend.why_not_in_parts(has_tiles=True),
        }
    with completed(Path(task["output"])) as temporary:
        started = time.perf_counter()
        if task["kind"] == "part":
            statistics = blend.render_part(task["frame"], task["layer"], tuple(task["tile"]), temporary)
        elif task["kind"] == "assemble":
            statistics = blend.assemble(task["frame"], task["tiles"], temporary)
        else:
            statistics = blend.render(task["frame"], temporary)
    del forced  # it has to live until here
    return {"statistics": statistics, "seconds": time.perf_counter() - started, "host": socket.gethostname()}


def _forced(simd: str | None) -> object:
    if simd is None:
        return None
    from . import _native  # noqa: PLC0415 - a library, which may fail to load

    return _native.ForcedSimdTarget(simd)


if __name__ == "__main__":
    main()
