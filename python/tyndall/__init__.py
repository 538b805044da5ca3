# SPDX-License-Identifier: GPL-3.0-or-later
"""Tyndall: light shafts and global illumination for Blender, on a native core that knows no Blender.

``Progress`` and the exceptions ``InvalidInput``, ``IoError`` and ``Cancelled`` come from the native module, which is
loaded when the first of them is asked for: a scene can be described, and a load error explained, without it.
"""

from __future__ import annotations

import os
import pkgutil
from pathlib import Path
from typing import TYPE_CHECKING

# In a source tree the native module lies in the build folder: beside a `tyndall` folder on sys.path, or where
# TYNDALL_NATIVE_DIR says.
__path__ = pkgutil.extend_path(__path__, __name__)
if _native_dir := os.environ.get("TYNDALL_NATIVE_DIR"):
    __path__.append(str(Path(_native_dir) / "tyndall"))

if TYPE_CHECKING:
    from ._native import Cancelled, InvalidInput, IoError, Progress

__version__ = "0.1.0"
__all__ = ["Cancelled", "InvalidInput", "IoError", "Progress"]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import _native  # noqa: PLC0415 - see the module's docstring

    return getattr(_native, name)
