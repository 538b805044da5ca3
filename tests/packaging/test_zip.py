# SPDX-License-Identifier: GPL-3.0-or-later
"""What the zip and its wheel must be for Blender 3.4 to 5.0 to install them anywhere, without a network."""

import ast
import base64
import csv
import hashlib
import re
import subprocess
import tomllib
import zipfile
from pathlib import Path

import pytest

from support.blenders import ROOT, environment_of_bpy

TOP = "tyndall_blender/"


def test_the_zip_has_one_folder_and_an_entry_for_it(zip_path: Path) -> None:
    """Without the entry, 3.4 does not remove the old folder on update but merges the new one into it."""
    names = zipfile.ZipFile(zip_path).namelist()
    assert names[0] == TOP
    assert all(name.startswith(TOP) for name in names)
    assert {f"{TOP}__init__.py", f"{TOP}blender_manifest.toml", f"{TOP}LICENSE"} <= set(names)
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]


def test_the_zip_is_at_most_40_mb(zip_path: Path) -> None:
    assert zip_path.stat().st_size <= 40_000_000


@pytest.mark.parametrize("version", ["4.5", "5.0"])
def test_blenders_own_tool_accepts_the_zip(version: str, zip_path: Path) -> None:
    tool = environment_of_bpy(version) / "bpy" / version / "scripts/addons_core/bl_pkg/cli/blender_ext.py"
    result = subprocess.run(
        ["/usr/bin/python3", tool, "validate", zip_path], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stdout + result.stderr


def test_the_manifest_names_the_wheel_that_is_there(zip_path: Path) -> None:
    with zipfile.ZipFile(zip_path) as archive:
        manifest = tomllib.loads(archive.read(f"{TOP}blender_manifest.toml").decode())
        (wheel,) = (name.removeprefix(TOP) for name in archive.namelist() if name.endswith(".whl"))
    assert manifest["wheels"] == [f"./{wheel}"]


def test_every_place_that_states_the_version_states_the_same(zip_path: Path, wheel_path: Path) -> None:
    def found(path: str, pattern: str) -> str:
        match = re.search(pattern, (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE)
        assert match, path
        return match[1]

    addon = ast.parse((ROOT / "addon/__init__.py").read_text(encoding="utf-8"))
    (bl_info,) = (
        ast.literal_eval(node.value)
        for node in addon.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "bl_info"
    )
    versions = {
        "CMake": found("CMakeLists.txt", r"^project\(tyndall VERSION (\S+)"),
        "pyproject": found("pyproject.toml", r'^version = "(.*)"$'),
        "manifest": found("addon/blender_manifest.toml", r'^version = "(.*)"$'),
        "tyndall": found("python/tyndall/__init__.py", r'^__version__ = "(.*)"$'),
        "bl_info": ".".join(map(str, bl_info["version"])),
        "zip": zip_path.name.split("-")[1],
        "wheel": wheel_path.name.split("-")[1],
    }
    assert len(set(versions.values())) == 1, versions


def test_the_wheel_fits_debian_12_ubuntu_22_04_and_fedora_36(wheel_path: Path) -> None:
    """Their glibc is 2.35 or later; a Blender from 4.2 on ignores the number and would fail at import."""
    _, _, python, abi, platform = wheel_path.stem.split("-")
    assert (python, abi) == ("cp311", "cp311")
    match = re.fullmatch(r"manylinux_2_(\d+)_x86_64", platform)
    assert match
    assert int(match[1]) <= 35


def test_the_record_of_the_wheel_is_right(site_packages: Path) -> None:
    """Symbols are renamed after auditwheel wrote its record, so that it has to be written again."""
    (record,) = site_packages.glob("tyndall-*.dist-info/RECORD")
    for name, digest, _ in csv.reader(record.read_text(encoding="utf-8").splitlines()):
        if digest:
            expected = base64.urlsafe_b64encode(hashlib.sha256((site_packages / name).read_bytes()).digest())
            assert digest == f"sha256={expected.decode().rstrip('=')}", name


def test_the_wheel_brings_what_the_package_needs(site_packages: Path) -> None:
    package = site_packages / "tyndall"
    for name in (
        "_native.*.so",
        "_image_io.*.so",
        "_volume_io.*.so",
        "py.typed",
        "blender/__init__.py",
        "blender/addon/__init__.py",
    ):
        assert list(package.glob(name)), name


def test_the_licence_of_every_bundled_library_is_there(site_packages: Path) -> None:
    """By the name of its package; OpenImageIO's comes with those of what is linked into it."""
    (folder,) = site_packages.glob("tyndall-*.dist-info/licenses")
    licences = {path.name for path in folder.iterdir() if path.stat().st_size > 500}
    assert {"LICENSE", "LICENSE.md", "THIRD-PARTY.md"} <= licences
    for library in (site_packages / "tyndall.libs").iterdir():
        name = re.split(r"[-_.0-9]", library.name, maxsplit=1)[0].lower()
        is_of_openimageio = name == "libopenimageio"
        assert is_of_openimageio or any(licence.startswith(name) for licence in licences), library.name
