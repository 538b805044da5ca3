# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the native core runs on this machine; if not, why, and what to do about it."""

from __future__ import annotations

import re

_why_not: str | None = None


def why_not() -> str | None:
    """Explain in one or two sentences why the core could not be loaded; None if it was."""
    return _why_not


def why_no_render() -> str | None:
    """What a button says that renders; None: it may."""
    return None if _why_not is None else "Tyndall cannot render here: its panel in the Render properties says why"


def explained(error: Exception) -> str:
    """Put an error of the import into words that say what to do; the error's own words where we know no better."""
    text = str(error)
    if isinstance(error, RuntimeError):  # native_module's own words
        return f"{text}."
    if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] == "numpy":
        return (
            "Blender's Python has no NumPy. On Debian and Ubuntu: sudo apt install python3-numpy, then restart Blender."
        )
    if symbol := re.search(r"version `(GLIBC\w*_[\d.]+)' not found", text):
        return (
            f"This system is too old: its C or C++ library lacks {symbol[1]}. "
            "Tyndall needs what Debian 12, Ubuntu 22.04 or Fedora 36 have, or later."
        )
    if library := re.search(r"(\S+\.so[\w.]*): cannot open shared object file", text):
        return f"The library {library[1]} is missing. Install the add-on's zip again; it brings all that it needs."
    if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] == "tyndall":
        return (
            f"The add-on's native part is not installed ({text}). Install the add-on's zip for this version of Blender."
        )
    return f"{text or type(error).__name__}. Install the add-on's zip again, then restart Blender."


def load() -> bool:
    """Load the bundled native core, or the one that is importable; afterwards ``why_not`` is up to date."""
    global _why_not  # noqa: PLW0603  one process, one core
    try:
        from . import native_module

        native_module.load()
        from tyndall.native_fit import require_fit

        require_fit()  # proves as well that every library behind it loads
    except (ImportError, OSError, RuntimeError) as error:
        _why_not = explained(error)
    else:
        _why_not = None
    return _why_not is None
