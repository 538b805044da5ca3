# SPDX-License-Identifier: GPL-3.0-or-later
"""Our Embree 3 answers our calls even where the host program holds an Embree 4 in its global scope.

Seen to fail with the wheel as auditwheel leaves it, before its symbols are renamed: the device calls itself 4.4, and no
ray hits anything. Blender's executable links Embree in this way from 4.0 on; bpy wheels load theirs privately.
"""

from collections.abc import Callable
from pathlib import Path

import pytest

from support.blenders import ROOT, environment_of_bpy, run

VERSION_OF_FOREIGN_EMBREE = """
import ctypes
scope = ctypes.CDLL(None)
scope.rtcNewDevice.restype = ctypes.c_void_p
scope.rtcGetDeviceProperty.argtypes = [ctypes.c_void_p, ctypes.c_int]
RTC_DEVICE_PROPERTY_VERSION = 0
print("foreign Embree:", scope.rtcGetDeviceProperty(scope.rtcNewDevice(None), RTC_DEVICE_PROPERTY_VERSION))
"""


@pytest.mark.parametrize("version", ["4.5", "5.0"])
@pytest.mark.parametrize("bpy_comes", ["first", "last"])
def test_rays_hit_beside_a_foreign_embree(
    version: str, bpy_comes: str, host_of: Callable[[str], Path], site_packages: Path, tmp_path: Path
) -> None:
    probe = (ROOT / "tests/support/ray_hits.py").read_text(encoding="utf-8")
    order = ("import bpy\n", probe) if bpy_comes == "first" else (probe, "import bpy\n")
    script = tmp_path / "script.py"
    script.write_text(VERSION_OF_FOREIGN_EMBREE + "".join(order), encoding="utf-8")
    environment = {"PYTHONPATH": f"{environment_of_bpy(version)}:{site_packages}", "HOME": str(tmp_path)}
    result = run([host_of(version), script], environment).succeeded()
    assert int(result.says("foreign Embree:")) >= 40000
    assert float(result.says("share of hits:")) == 0.5
