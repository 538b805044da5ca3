# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a module of tests/support inside Blender's executable, as ``python -m`` does: ... -- MODULE ARGUMENTS."""

import runpy
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
for folder in (ROOT, ROOT / "tests", ROOT / "python", ROOT / "build/release/python"):
    sys.path.append(str(folder))  # Blender ignores PYTHONPATH

runpy.run_module(sys.argv[sys.argv.index("--") + 1], run_name="__main__", alter_sys=False)
