# SPDX-License-Identifier: GPL-3.0-or-later
"""The packaged zip, its wheel, and Blenders with a user folder of their own to install it into."""

import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from support.blenders import ROOT, Blender, Bpy, Executable
from support.foreign_host import build_host


@pytest.fixture(scope="session")
def zip_path() -> Path:
    """The zip that scripts/package.sh made."""
    zips = sorted((ROOT / "dist").glob("tyndall_blender-*-linux-x64.zip"), key=lambda path: path.stat().st_mtime)
    assert zips, "there is no zip in dist: run scripts/package.sh"
    return zips[-1]


@pytest.fixture(scope="session")
def wheel_path(zip_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel inside the zip."""
    folder = tmp_path_factory.mktemp("zip")
    with zipfile.ZipFile(zip_path) as archive:
        archive.extractall(folder)
    (wheel,) = (folder / "tyndall_blender" / "wheels").glob("*.whl")
    return wheel


@pytest.fixture(scope="session")
def site_packages(wheel_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, unpacked."""
    folder = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel_path) as archive:
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="session")
def host_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Give the host program with a version's libraries, which is linked once."""
    return cache(lambda version: build_host(version, tmp_path_factory.mktemp("host")))


@pytest.fixture(params=["3.4", "4.5", "5.0"])
def blender(request: pytest.FixtureRequest, tmp_path: Path) -> Blender:
    """Each Blender in turn, with nothing installed."""
    return Executable(tmp_path) if request.param == "3.4" else Bpy(request.param, tmp_path)


@pytest.fixture
def blender_34(tmp_path: Path) -> Executable:
    """Debian's Blender, with nothing installed."""
    return Executable(tmp_path)
