# SPDX-License-Identifier: GPL-3.0-or-later
"""Blenders to run scripts in, each process with the same empty user folder: Debian's 3.4, and bpy 4.5 and 5.0."""

import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

ROOT = Path(__file__).resolve().parents[2]
#: A hang at exit is one of the known traps: a test that waits for this long has found it.
TIME_LIMIT_S = 120


@dataclass
class Run:
    """What a process left behind."""

    exit_code: int  #: Negative for a signal; Blender itself exits with 139 or 11 after a segmentation fault.
    output: str

    def succeeded(self) -> "Run":
        """Return itself, or fail with what the process said."""
        assert self.exit_code == 0, f"exit code {self.exit_code}:\n{self.output}"
        return self

    def says(self, prefix: str) -> str:
        """Give the rest of the one line that starts with prefix."""
        (line,) = (line for line in self.output.splitlines() if line.startswith(prefix))
        return line.removeprefix(prefix).strip()


def run(command: list[str | Path], environment: dict[str, str]) -> Run:
    """Run a command with an environment that inherits nothing but the screen and the language."""
    inherited = {name: os.environ[name] for name in ("DISPLAY", "LANG") if name in os.environ}
    result = subprocess.run(
        command,
        env={"PATH": "/usr/bin:/bin", **inherited, **environment},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=TIME_LIMIT_S,
        check=False,
    )
    return Run(result.returncode, result.stdout)


class Blender(Protocol):
    """A Blender whose user folder outlives its processes."""

    user_folder: Path

    def run(self, script: str) -> Run:
        """Run a script with bpy in a process of its own."""
        ...

    @property
    def install(self) -> str:
        """Lines that define ``install(zip)``, ``enable()``, ``disable()``, ``remove()`` and ``module``, its name."""
        ...


@dataclass
class Executable:
    """Debian's Blender 3.4: a legacy add-on."""

    user_folder: Path
    version: str = "3.4"
    install: str = """
import bpy
module = "tyndall_blender"

def install(zip):
    bpy.ops.preferences.addon_install(filepath=zip, overwrite=True)

def enable():
    bpy.ops.preferences.addon_enable(module=module)
    bpy.ops.wm.save_userpref()

def disable():
    bpy.ops.preferences.addon_disable(module=module)

def remove():
    try:
        bpy.ops.preferences.addon_remove(module=module)
    except RuntimeError:  # it wants an area to redraw, once all is removed
        assert bpy.app.background
"""
    arguments: list[str] = field(default_factory=list)

    def run(self, script: str) -> Run:
        """Run a script in background mode."""
        path = self.user_folder / "script.py"
        path.write_text(script, encoding="utf-8")
        environment = {"HOME": str(self.user_folder)}
        for name in ("config", "scripts", "datafiles"):
            (self.user_folder / name).mkdir(exist_ok=True)
            environment[f"BLENDER_USER_{name.upper()}"] = str(self.user_folder / name)
        return run(
            ["/usr/bin/blender", "-b", *self.arguments, "--python-exit-code", "1", "--python", path], environment
        )


@dataclass
class Bpy:
    """bpy as a module, 4.2 or later: an extension."""

    version: str
    user_folder: Path
    install: str = """
import bpy
module = "bl_ext.user_default.tyndall_blender"

def install(zip):  # enabling is part of it, as in the window: without it, Blender leaves an updated wheel as it was
    bpy.ops.extensions.package_install_files(filepath=zip, repo="user_default", enable_on_install=True)

def enable():
    bpy.ops.preferences.addon_enable(module=module)
    bpy.ops.wm.save_userpref()

def disable():
    bpy.ops.preferences.addon_disable(module=module)

def remove():
    repositories = [repository.module for repository in bpy.context.preferences.extensions.repos]
    bpy.ops.extensions.package_uninstall(repo_index=repositories.index("user_default"), pkg_id="tyndall_blender")
"""

    @property
    def python(self) -> Path:
        """The interpreter that has this bpy."""
        return ROOT / ".deps" / f"bpy{self.version.replace('.', '')}" / "bin/python"

    def run(self, script: str) -> Run:
        """Run a script that has read the user's preferences, which a bare import of bpy does not.

        bpy 4.2 crashes when it reads them, with or without us: there each run begins with Blender's own.
        """
        path = self.user_folder / "script.py"
        read = "" if self.version == "4.2" else "bpy.ops.wm.read_userpref()\n"
        path.write_text(f"import bpy\n{read}{script}", encoding="utf-8")
        environment = {"HOME": str(self.user_folder), "BLENDER_USER_RESOURCES": str(self.user_folder / "resources")}
        return run([self.python, path], environment)


def environment_of_bpy(version: str) -> Path:
    """The site-packages folder that holds this bpy."""
    name = f"python{sys.version_info.major}.{sys.version_info.minor}"
    return ROOT / ".deps" / f"bpy{version.replace('.', '')}" / "lib" / name / "site-packages"
