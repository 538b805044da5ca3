# SPDX-License-Identifier: GPL-3.0-or-later
"""What the files of voxel boxes hold: read once, in a thread where there is a window, and again when a file changes.

No more of a file is read than is asked for: of a large one its header, its topmost levels, or its geometry.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from tyndall import Progress
    from tyndall.voxel_dag import FileHeader, LevelCounts

_TICK_S = 0.1
#: Of files and levels of previews: a dozen boxes of some megabytes each.
_MOST_KEPT = 24


@dataclass(kw_only=True, eq=False)
class _Reading:
    progress: Progress
    result: Any = None  #: None while it is being made; what was raised, where that failed.
    thread: threading.Thread | None = None


@dataclass(kw_only=True, eq=False)
class _Kept:
    readings: OrderedDict[tuple[object, ...], _Reading] = field(default_factory=OrderedDict)
    one_at_a_time: threading.Lock = field(default_factory=threading.Lock)


_kept = _Kept()


def header_of(path: Path) -> FileHeader | Exception | None:
    """None: it is being read. An exception says what is wrong with the file."""
    found: FileHeader | Exception | None = read(path, "header", _header)
    return found


def levels_of(path: Path) -> list[LevelCounts] | Exception | None:
    """Likewise; all of the geometry is read for it."""
    found: list[LevelCounts] | Exception | None = read(path, "levels", _levels)
    return found


def read(path: Path, what: str, make: Callable[[Path, Progress], Any]) -> Any:  # noqa: ANN401  what make gives
    """What ``make``, which runs without bpy, gives of the file; None while it is at work, or what it raised."""
    from tyndall import Progress

    try:
        stamp = path.stat()
    except OSError as error:
        return error
    key = (str(path), stamp.st_mtime_ns, stamp.st_size, what)
    reading = _kept.readings.get(key)
    if reading is None:
        reading = _kept.readings[key] = _Reading(progress=Progress())
        _drop_old()
        if bpy.app.background:
            _make(reading, path, make)
        else:
            reading.thread = threading.Thread(target=_make, args=(reading, path, make), name="tyndall voxels")
            reading.thread.start()
            if not bpy.app.timers.is_registered(_redraw_when_read):
                bpy.app.timers.register(_redraw_when_read, first_interval=_TICK_S)
    _kept.readings.move_to_end(key)
    return reading.result


def forget(path: Path | None = None) -> None:
    """Read it anew when it is asked for next; all files, without a path."""
    for key in [key for key in _kept.readings if path is None or key[0] == str(path)]:
        _kept.readings.pop(key).progress.cancel()


def _make(reading: _Reading, path: Path, make: Callable[[Path, Progress], Any]) -> None:
    try:
        with _kept.one_at_a_time:
            reading.result = make(path, reading.progress)
    except Exception as error:  # noqa: BLE001  shown where the result would be
        reading.result = error


def _header(path: Path, _progress: Progress) -> FileHeader:
    from tyndall.voxel_dag import read_header

    return read_header(path)


def _levels(path: Path, progress: Progress) -> list[LevelCounts]:
    from tyndall.voxel_dag import load

    return load(path, progress, attributes=False).levels(progress)


def _drop_old() -> None:
    while len(_kept.readings) > _MOST_KEPT:
        _kept.readings.popitem(last=False)[1].progress.cancel()


def _redraw_when_read() -> float | None:
    """Of Blender's timers: its own thread alone may touch the window."""
    is_reading = any(reading.thread is not None and reading.thread.is_alive() for reading in _kept.readings.values())
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "PROPERTIES"}:
                area.tag_redraw()
    return _TICK_S if is_reading else None


@persistent
def _forget_all(_path: object = None) -> None:
    forget()


def register() -> None:
    bpy.app.handlers.load_post.append(_forget_all)


def unregister() -> None:
    bpy.app.handlers.load_post.remove(_forget_all)
    if bpy.app.timers.is_registered(_redraw_when_read):
        bpy.app.timers.unregister(_redraw_when_read)
    forget()
