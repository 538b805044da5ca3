# SPDX-License-Identifier: GPL-3.0-or-later
"""What jobs do in tests of them: in a module that every process finds."""

from __future__ import annotations

import os
import signal
from pathlib import Path


def write(path: Path, text: str) -> None:
    part = path.with_suffix(f".{os.getpid()}.part")
    part.write_text(text)
    part.replace(path)


def write_or_die(path: Path, text: str, marker: Path) -> None:
    """The first process that comes here is killed."""
    try:
        marker.touch(exist_ok=False)
    except FileExistsError:
        write(path, text)
    else:
        os.kill(os.getpid(), signal.SIGKILL)


def die(_path: Path) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def refuse(_path: Path) -> None:
    raise ValueError("no such photon")


def do_nothing(_path: Path) -> None:
    pass
