# SPDX-License-Identifier: GPL-3.0-or-later
"""A program that holds bpy's own libraries in its global scope, as Blender's executable does."""

import subprocess
from pathlib import Path

from support.blenders import ROOT, environment_of_bpy


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
