# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing of ours can be found by name inside Blender's process, and nothing that we need is looked for outside."""

import subprocess
from pathlib import Path

import pytest

#: What every Linux with a Blender has: the C and C++ libraries, and zlib.
LIBRARIES_OF_THE_SYSTEM = {
    *("libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "librt.so.1", "ld-linux-x86-64.so.2"),
    *("libstdc++.so.6", "libgcc_s.so.1", "libz.so.1"),
}


def libraries(site_packages: Path) -> list[Path]:
    """Every shared library of the wheel."""
    found = sorted(path for path in site_packages.rglob("*.so*") if path.is_file())
    assert len(found) >= 4
    return found


def dynamic_symbols(library: Path, *options: str) -> list[str]:
    """Names in the dynamic symbol table, without their versions."""
    output = subprocess.run(["nm", "-D", *options, library], capture_output=True, text=True, check=True).stdout
    return [line.split()[-1].split("@")[0] for line in output.splitlines()]


@pytest.mark.parametrize("module", ["_native", "_image_io", "_volume_io"])
def test_a_module_exports_its_entry_and_nothing_else(module: str, site_packages: Path) -> None:
    """OpenVDB's template statics, found twice by name, crash at initialize(); Blender has its own OpenVDB."""
    (library,) = (site_packages / "tyndall").glob(f"{module}.*.so")
    assert dynamic_symbols(library, "--defined-only") == [f"PyInit_{module}"]


def test_only_the_module_of_volume_files_loads_openvdb(site_packages: Path) -> None:
    """57 MB that most scenes do not need."""
    loads = {
        path.name.split(".")[0]: "libopenvdb" in subprocess.check_output(["readelf", "-d", path], text=True)
        for path in (site_packages / "tyndall").glob("_*.so")
    }
    assert loads == {"_native": False, "_image_io": False, "_volume_io": True}


def test_embree_is_called_by_a_name_that_no_other_embree_has(site_packages: Path) -> None:
    by_library = {path.name: dynamic_symbols(path) for path in libraries(site_packages)}
    assert not [
        (name, symbol) for name, symbols in by_library.items() for symbol in symbols if symbol.startswith("rtc")
    ]
    (embree,) = (symbols for name, symbols in by_library.items() if name.startswith("libembree"))
    assert len([symbol for symbol in embree if symbol.startswith("tyndall_rtc")]) > 90
    (native,) = (symbols for name, symbols in by_library.items() if name.startswith("_native"))
    assert "tyndall_rtcNewDevice" in native


def test_every_library_that_is_needed_travels_in_the_wheel(site_packages: Path) -> None:
    bundled = {path.name for path in libraries(site_packages)}
    for library in libraries(site_packages):
        output = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True).stdout
        needed = {line.split("[")[1].rstrip("]") for line in output.splitlines() if "(NEEDED)" in line}
        assert needed <= bundled | LIBRARIES_OF_THE_SYSTEM, library.name
