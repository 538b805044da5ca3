# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes to Blender's data from handlers, which Blender may deny for no reason of theirs.

While Blender calls what only draws, Python may not write. It keeps that in one flag for all threads: a render that
begins amid a panel's drawing restores what it found, and the flag may stay for as long as Blender runs. Of properties,
only those of the window manager can be set then, and what their ``update`` does is granted in any case.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from collections.abc import Callable

    from bpy.types import Context, WindowManager

_PROPERTY = "tyndall_granted_writes"


class _Pending(threading.local):
    change: Callable[[], object] | None = None
    error: Exception | None = None


_pending = _Pending()


def write(change: Callable[[], object]) -> None:
    """Do what may be done twice; anew, where Blender denies it. Raises what ``change`` raises where it is granted."""
    try:
        change()
    except (AttributeError, RuntimeError):  # of which Blender raises one by properties, and one by operators
        grant(change)


def grant(change: Callable[[], object]) -> None:
    """Do it with write access. Windows are drawn anew, so ``write`` tries without."""
    _pending.change, _pending.error = change, None
    setattr(bpy.data.window_managers[0], _PROPERTY, True)
    if (error := _pending.error) is not None:
        _pending.error = None
        raise error


def _run(_: WindowManager, __: Context) -> None:
    change, _pending.change = _pending.change, None
    if change is None:
        return
    try:
        change()
    except Exception as error:  # noqa: BLE001  Blender would print it, and go on
        _pending.error = error


def register() -> None:
    setattr(bpy.types.WindowManager, _PROPERTY, bpy.props.BoolProperty(options={"HIDDEN"}, update=_run))


def unregister() -> None:
    delattr(bpy.types.WindowManager, _PROPERTY)
