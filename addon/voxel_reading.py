# SPDX-License-Identifier: GPL-3.0-or-later
"""What the files of voxel boxes hold: read once, in a thread where there is a window, and again when a file changes."""

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
    from tyndall.voxel_dag import LevelCounts, VoxelDag

_TICK_S = 0.1
#: Of files and levels of previews: a dozen boxes of some megabytes each.
_MOST_KEPT = 24


@dataclass(frozen=True, kw_only=True)
class Counts:
    """What a panel says of a file."""

    resolution: int
    voxel_count: int
    node_count: int
    geometry_bytes: int
    bytes_by_part: dict[str, int]
    levels: list[LevelCounts]
    bounds_m: list[list[float]]

    @property
    def octree_node_count(self) -> int:
        return sum(level.tree_node_count for level in self.levels)


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


def counts_of(path: Path) -> Counts | Exception | None:
    """None: it is being read. An exception says what is wrong with the file."""
    found: Counts | Exception | None = read(path, "counts", _counts)
    return found


def read(path: Path, what: str, make: Callable[[VoxelDag, Progress], Any]) -> Any:  # noqa: ANN401  what make gives
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


def _make(reading: _Reading, path: Path, make: Callable[[VoxelDag, Progress], Any]) -> None:
    from tyndall.voxel_dag import load

    try:
        with _kept.one_at_a_time:
            reading.result = make(load(path, reading.progress), reading.progress)
    except Exception as error:  # noqa: BLE001  shown where the result would be
        reading.result = error


def _counts(dag: VoxelDag, progress: Progress) -> Counts:
    return Counts(
        resolution=dag.resolution,
        voxel_count=dag.voxel_count,
        node_count=dag.node_count,
        geometry_bytes=dag.geometry_bytes,
        bytes_by_part=dag.bytes_by_part,
        levels=dag.levels(progress),
        bounds_m=dag.bounds_m.tolist(),
    )


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
