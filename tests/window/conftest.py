# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender 3.4 in a window of its own, on an X server of its own, with a home of its own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

REPOSITORY = Path(__file__).parents[2]
BLENDER = "/usr/bin/blender"
#: Unless a session asks for another.
SCREEN_PX = (800, 500)


@dataclass(frozen=True)
class Played:
    """What a session left behind."""

    facts: dict[str, Any]
    console: str
    folder: Path


@contextmanager
def screen(size_px: tuple[int, int]) -> Iterator[str]:
    """An X server on a free display."""
    if not (Path(BLENDER).exists() and shutil.which("Xvfb") and shutil.which("import")):
        pytest.skip("needs Debian's blender, xvfb and imagemagick: run scripts/setup.sh")
    read_end, write_end = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write_end), "-screen", "0", f"{size_px[0]}x{size_px[1]}x24", "-nolisten", "tcp"],
        pass_fds=[write_end],
        stderr=subprocess.DEVNULL,
    )
    os.close(write_end)
    with os.fdopen(read_end) as pipe:
        number = pipe.readline().strip()
    try:
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()


@pytest.fixture
def play(tmp_path: Path) -> Callable[[str], Played]:
    """Play a session in a new Blender. Fails if it failed there, or if Blender's console shows an exception."""

    def played(
        session: str,
        *,
        timeout_s: float = 900.0,
        screen_px: tuple[int, int] = SCREEN_PX,
        settings: dict[str, str] | None = None,
    ) -> Played:
        folder = Path(os.environ.get("TYNDALL_SCREENSHOTS", tmp_path))
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "facts.json").unlink(missing_ok=True)
        environment = {
            "PATH": "/usr/bin:/bin",  # Blender takes the first python3 on PATH for its own
            "HOME": str(tmp_path),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "LANG": "C.UTF-8",
        }
        with screen(screen_px) as display:
            process = subprocess.run(
                [
                    BLENDER,
                    "--factory-startup",
                    *("--window-geometry", "0", "0", *map(str, screen_px)),
                    *("--python", str(REPOSITORY / "tests/support/window_driver.py"), "--"),
                    *(str(Path(__file__).parent / "sessions" / f"{session}.py"), str(folder)),
                ],
                env=environment | (settings or {}) | {"DISPLAY": display},
                cwd=tmp_path,
                capture_output=True,
                text=True,
                timeout=timeout_s,
                check=False,
            )
        console = process.stdout + process.stderr
        assert process.returncode in {0, 1}, console  # 1: the last render was cancelled
        assert (folder / "facts.json").exists(), console
        facts = json.loads((folder / "facts.json").read_text())
        assert "error" not in facts, facts["error"]
        assert "Traceback" not in console, console
        return Played(facts, console, folder)

    return played
