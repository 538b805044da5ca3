# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the native part, package ``tyndall``, importable, however the add-on was installed.

As an extension (4.2 and later) Blender has unpacked the wheel of the zip; in a source tree and inside the wheel the
package lies beside the add-on. As a legacy add-on (3.4 to 4.1) nobody has unpacked it: that is done here, once.
"""

from __future__ import annotations

import importlib
import os
import shutil
import sys
import tomllib
import zipfile
from pathlib import Path

ADDON = Path(__file__).parent


def load() -> None:
    """Make ``import tyndall`` give the native part that belongs to this add-on.

    Raises ImportError (a library is missing, no NumPy), OSError (the wheel cannot be unpacked) or RuntimeError (another
    Python, or another version is loaded in this process), each with words that say what is wrong.
    """
    # An extension's wheel lies in its folder, too, but Blender has put its modules on the path already.
    if not (__package__ or "").startswith("bl_ext.") and (wheel := bundled_wheel()):
        require_python_of(wheel)
        folder = str(unpacked(wheel))
        if folder not in sys.path:
            sys.path.append(folder)
            importlib.invalidate_caches()
    require_version(version_of_addon())


def bundled_wheel() -> Path | None:
    """Find the wheel in the add-on's folder; only an add-on that was installed from the zip has one."""
    return next(iter(sorted((ADDON / "wheels").glob("tyndall-*.whl"))), None)


def require_python_of(wheel: Path) -> None:
    """Raise RuntimeError unless the wheel was built for the Python that runs."""
    built_for = wheel.name.split("-")[2]
    running = f"cp{sys.version_info.major}{sys.version_info.minor}"
    if built_for != running:
        raise RuntimeError(
            f"This zip is for Python {built_for[2]}.{built_for[3:]} (Blender 4.1 to 5.0, and Debian's 3.4), "
            f"but this Blender runs Python {running[2]}.{running[3:]}"
        )


def unpacked(wheel: Path) -> Path:
    """Give the folder with the wheel's content, unpacked on first use: 180 MB at most, 0.7 s.

    It lies inside the add-on, so that Blender's update and removal take it away. A library that some Blender has
    loaded is never written over, which would kill that process: a folder is complete when it gets its name, and stays
    as it is.
    """
    folder = ADDON / "native" / wheel.stem
    if not folder.is_dir():
        part = folder.with_name(f"{folder.name}.{os.getpid()}.part")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        try:
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(part)
            part.rename(folder)
        except OSError:
            shutil.rmtree(part, ignore_errors=True)
            if not folder.is_dir():  # else a Blender that started at the same moment was first, with the same content
                raise
    return folder


def version_of_addon() -> str:
    """Read the version from the manifest: Blender replaces ``bl_info`` in an extension."""
    with (ADDON / "blender_manifest.toml").open("rb") as manifest:
        return str(tomllib.load(manifest)["version"])


def require_version(wanted: str) -> None:
    """Raise RuntimeError if the imported package is of another version: a loaded native module cannot be replaced."""
    was_loaded = "tyndall" in sys.modules
    import tyndall

    if tyndall.__version__ == wanted:
        return
    if was_loaded:
        raise RuntimeError(
            f"Tyndall {wanted} is installed, but Blender still runs the native part of {tyndall.__version__}: "
            "restart Blender"
        )
    raise RuntimeError(
        f"The add-on is Tyndall {wanted}, but Python finds {tyndall.__version__} in {Path(tyndall.__file__).parent}: "
        "remove that copy, then restart Blender"
    )
