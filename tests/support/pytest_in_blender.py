# SPDX-License-Identifier: GPL-3.0-or-later
r"""Runs pytest inside Blender's executable, which has neither pytest nor our package on its path.

PATH=/usr/bin:/bin blender -b --factory-startup --python-exit-code 1 \
    --python tests/support/pytest_in_blender.py -- ARGUMENTS
"""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
#: Appended, so that Blender's own NumPy comes first; pytest and Pillow come from the environment of bpy 4.5.
SITE_PACKAGES = ROOT / ".deps/bpy45/lib/python3.11/site-packages"

# Blender ignores PYTHONPATH; a process that a test starts should not.
os.environ["PYTHONPATH"] = os.pathsep.join(str(ROOT / folder) for folder in ("python", "build/release/python"))
sys.path.append(str(SITE_PACKAGES))
os.chdir(ROOT)

import pytest  # noqa: E402  # only there once the path is set

code = int(pytest.main(sys.argv[sys.argv.index("--") + 1 :]))
sys.stdout.flush()
sys.exit(code)
