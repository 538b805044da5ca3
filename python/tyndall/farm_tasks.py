# SPDX-License-Identifier: GPL-3.0-or-later
"""A task of a farm, done on the machine that calls: in a process of its own that has bpy, and dies with the caller."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import tyndall

#: What makes other libraries of a process compute alike on every CPU, by the instruction set that is forced. All CPUs
#: with AVX2 have the fused operations that glibc, numpy and OpenBLAS choose; those of the baseline must not use them.
_ALIKE = {
    "SSE4": {
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4,-FMA4_Usable,-AVX512F",
        "OPENBLAS_CORETYPE": "Nehalem",
    },
    "AVX2": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL", "OPENBLAS_CORETYPE": "Haswell"},
    "AVX-512": {"OPENBLAS_CORETYPE": "SkylakeX"},
}
SIMD_NAMES = tuple(_ALIKE)
_LINES_OF_A_CRASH = 3


class TaskError(RuntimeError):
    """Names the machine and what went wrong there."""


def run_task(task: dict[str, Any]) -> Any:  # noqa: ANN401 - JSON
    """What farm_child makes of the task. Raises TaskError."""
    host = socket.gethostname()
    file = task.get("file")
    if file is not None and not Path(file).is_file():
        raise TaskError(f"{host} does not see {file}: all machines need the file under the same path")
    output = task.get("output")
    if output is not None and not Path(output).parent.is_dir():
        raise TaskError(f"{host} does not see {Path(output).parent}: all machines need the folder under the same path")
    with tempfile.TemporaryDirectory(prefix="tyndall") as folder:
        answer, log = Path(folder) / "answer.json", Path(folder) / "log"
        code = _call(task | {"answer": str(answer)}, log)
        if not answer.exists():
            last = " / ".join(log.read_text(errors="replace").strip().splitlines()[-_LINES_OF_A_CRASH:])
            raise TaskError(f"{host}: Blender's process ended with {code} and no answer: {last or 'it said nothing'}")
        told = json.loads(answer.read_text())
    if "error" in told:
        raise TaskError(f"{host}: {told['error']}")
    return told["result"]


def _call(task: dict[str, Any], log: Path) -> int:
    """The exit code. The process ends with its standard input, whatever happens to this one."""
    folders = [str(Path(folder).parent) for folder in tyndall.__path__]
    environment = os.environ | _ALIKE.get(task["simd"] or "", {})
    environment["PYTHONPATH"] = os.pathsep.join([*folders, *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [os.environ.get("TYNDALL_BPY_PYTHON") or sys.executable, "-m", "tyndall.farm_child"]
    with log.open("wb") as out:
        try:
            child = subprocess.Popen(  # noqa: S603 - this Python, or the one that who runs the worker names
                command, stdin=subprocess.PIPE, stdout=out, stderr=out, env=environment, start_new_session=True
            )
        except OSError as error:
            raise TaskError(f"{socket.gethostname()}: {command[0]} does not start: {error}") from error
    with child:
        if child.stdin is not None:
            with suppress(BrokenPipeError):  # it has ended already, and its log says why
                child.stdin.write(json.dumps(task).encode() + b"\n")
                child.stdin.flush()
        return child.wait()
