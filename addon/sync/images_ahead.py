# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of images that other threads read before the scene's reader asks for them.

Only who asks decides what is begun next, so that nobody waits for room: what was not begun by then is read at once.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from .image_files import read_bytes

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    #: A file, or an image that has packed one.
    Source = Path | bpy.types.Image
    Pixels = NDArray[np.uint8] | None

_ASSUMED_BYTES = 64 << 20  #: Of an image that has not been read yet: 4096 x 4096.
_MOST_BYTES = 1 << 30  #: That are begun and not asked for yet.


class ImagesAhead:
    """As read_bytes, of sources that were said before."""

    def __init__(self) -> None:
        self._threads: ThreadPoolExecutor | None = None
        self._waiting: deque[Source] = deque()
        self._begun: dict[str, Future[Pixels]] = {}
        self._most_bytes = 0

    def start(self, sources: Iterable[Source], budget_bytes: int) -> None:
        """``budget_bytes``: of memory, for all images; 0: as there is."""
        thread_count = len(os.sched_getaffinity(0))
        self._waiting.extend({_name(source): source for source in sources}.values())
        if len(self._waiting) > 1 and thread_count > 1:
            self._most_bytes = min(budget_bytes // 8 or _MOST_BYTES, _MOST_BYTES)
            self._threads = ThreadPoolExecutor(thread_count, thread_name_prefix="tyndall images")
            self._begin()
        else:
            self._waiting.clear()

    def take(self, source: Source) -> Pixels:
        """What read_bytes has of it."""
        name = _name(source)
        begun = self._begun.pop(name, None)
        if self._threads is None:
            return _read(source)
        self._waiting = deque(other for other in self._waiting if _name(other) != name)
        self._begin()
        return _read(source) if begun is None else begun.result()

    def stop(self) -> None:
        """What was begun and not asked for is dropped."""
        self._waiting.clear()
        self._begun.clear()
        if self._threads is not None:
            self._threads.shutdown(wait=False, cancel_futures=True)
            self._threads = None

    def _begin(self) -> None:
        held = sum(_held_bytes(begun) for begun in self._begun.values())
        while self._threads is not None and self._waiting and held + _ASSUMED_BYTES <= self._most_bytes:
            source = self._waiting.popleft()
            self._begun[_name(source)] = self._threads.submit(read_bytes, *_data(source))
            held += _ASSUMED_BYTES


def _name(source: Source) -> str:
    return str(source) if isinstance(source, Path) else f"packed {source.name_full}"


def _data(source: Source) -> tuple[Path | bytes, str]:
    """Read here: Blender's data is no other thread's."""
    return (source, source.name) if isinstance(source, Path) else (source.packed_file.data, source.name)


def _read(source: Source) -> Pixels:
    return read_bytes(*_data(source))


def _held_bytes(begun: Future[Pixels]) -> int:
    if not begun.done() or begun.exception() is not None:  # which is raised to who asks for it
        return _ASSUMED_BYTES
    pixels = begun.result()
    return 0 if pixels is None else pixels.nbytes
