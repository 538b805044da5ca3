# SPDX-License-Identifier: GPL-3.0-or-later
"""A window stays open while a render reads the scene: what is deleted in it is still drawn."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import bpy

SCRIPT = Path(__file__).parents[1] / "support" / "deleted_meanwhile.py"
#: Memory that is freed is overwritten, as it soon would be, by either of the allocators that Blenders have.
OVERWRITTEN = {"MALLOC_PERTURB_": "165", "MALLOC_CONF": "junk:true"}


def test_objects_that_are_deleted_while_the_scene_is_read_are_drawn(tmp_path: Path) -> None:
    if getattr(bpy.app, "module", False):
        command = [sys.executable, str(SCRIPT), str(tmp_path)]
    else:
        options = ("-b", "--factory-startup", "--python-exit-code", "1")
        command = [bpy.app.binary_path, *options, "--python", str(SCRIPT), "--", str(tmp_path)]
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), **OVERWRITTEN}
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "the same" in done.stdout
