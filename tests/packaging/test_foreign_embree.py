# SPDX-License-Identifier: GPL-3.0-or-later
"""Our Embree 3 answers our calls even where the host program holds an Embree 4 in its global scope.

Seen to fail with the wheel as auditwheel leaves it, before its symbols are renamed: the device calls itself 4.4, and no
ray hits anything. Blender's executable links Embree in this way from 4.0 on; bpy wheels load theirs privately.
"""

import subprocess
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


def needed_libraries(library: Path) -> list[str]:
    """Names of the libraries that a library is linked with."""
    lines = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True).stdout.splitlines()
    return [line.split("[")[1].rstrip("]") for line in lines if "(NEEDED)" in line]


def build_host(version: str, folder: Path) -> Path:
    """Build an interpreter that is linked with what bpy itself is linked with, as Blender's executable is."""
    bpy = environment_of_bpy(version) / "bpy"
    foreign = [f"-l:{name}" for name in needed_libraries(bpy / "__init__.so") if (bpy / "lib" / name).exists()]
    assert any("embree4" in name for name in foreign)

    def python_config(*options: str) -> list[str]:
        return subprocess.run(
            ["/usr/bin/python3-config", *options], capture_output=True, text=True, check=True
        ).stdout.split()

    host = folder / "host"
    subprocess.run(
        [
            *("g++", ROOT / "tests/support/foreign_host.cpp", "-o", host, *python_config("--includes")),
            *("-Wl,--no-as-needed,--allow-shlib-undefined", f"-L{bpy / 'lib'}", f"-Wl,-rpath,{bpy / 'lib'}", *foreign),
            *python_config("--embed", "--ldflags"),
        ],
        check=True,
    )
    return host


@pytest.mark.parametrize("version", ["4.5", "5.0"])
@pytest.mark.parametrize("bpy_comes", ["first", "last"])
def test_rays_hit_beside_a_foreign_embree(version: str, bpy_comes: str, site_packages: Path, tmp_path: Path) -> None:
    probe = (ROOT / "tests/support/ray_hits.py").read_text(encoding="utf-8")
    order = ("import bpy\n", probe) if bpy_comes == "first" else (probe, "import bpy\n")
    script = tmp_path / "script.py"
    script.write_text(VERSION_OF_FOREIGN_EMBREE + "".join(order), encoding="utf-8")
    environment = {"PYTHONPATH": f"{environment_of_bpy(version)}:{site_packages}", "HOME": str(tmp_path)}
    result = run([build_host(version, tmp_path), script], environment).succeeded()
    assert int(result.says("foreign Embree:")) >= 40000
    assert float(result.says("share of hits:")) == 0.5
