# SPDX-License-Identifier: GPL-3.0-or-later
"""Our OpenVDB and Blender's work side by side in one process, whichever comes first.

Blender 3.4 of Debian has the same OpenVDB under the same names; 4.5 and 5.0 have version 12 in another namespace.
"""

from collections.abc import Callable
from pathlib import Path

import pytest

from support.blenders import ROOT, Blender, environment_of_bpy, run

PROBE = (ROOT / "tests/support/volume_files_beside_blender.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("ours_comes", ["first", "last"])
def test_volume_files_are_read_beside_blenders_own(
    ours_comes: str, blender: Blender, site_packages: Path, tmp_path: Path
) -> None:
    script = f"import sys\nsys.path.append({str(site_packages)!r})\n{PROBE}\ncheck({str(tmp_path)!r}, {ours_comes!r})\n"
    assert blender.run(script).succeeded().says("volume files:") == "agree"


@pytest.mark.parametrize("version", ["4.5", "5.0"])
@pytest.mark.parametrize("ours_comes", ["first", "last"])
def test_volume_files_are_read_where_blenders_libraries_are_global(
    version: str, ours_comes: str, host_of: Callable[[str], Path], site_packages: Path, tmp_path: Path
) -> None:
    script = tmp_path / "script.py"
    script.write_text(f"{PROBE}\ncheck({str(tmp_path)!r}, {ours_comes!r})\n", encoding="utf-8")
    environment = {"PYTHONPATH": f"{environment_of_bpy(version)}:{site_packages}", "HOME": str(tmp_path)}
    result = run([host_of(version), script], environment).succeeded()
    assert result.says("volume files:") == "agree"
