# SPDX-License-Identifier: GPL-3.0-or-later
"""How long reading a scene may hold up the window at once, before it lets the window draw and goes on."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

#: A quarter of a second is what artists bear.
SLICE_S = 0.15


class SliceOver(Exception):  # noqa: N818  not an error: the rest is read in the next slice
    pass


class ReadingSlices:
    """Each slice first meets again what earlier ones have read: from its first news on it lasts twice as long.

    So two thirds of the time go to news. A part that is longer than a slice would never be read: a slice without news
    doubles the next. Where all of a scene takes longer to meet again, the first slice of a later change allows for it,
    or it would always be in vain.
    """

    def __init__(self, read_count: Callable[[], int]) -> None:
        """``read_count``: of what was read and stays, so far."""
        self._read_count = read_count
        self._length_s = SLICE_S
        self._spent_s = self._started = self._ends = 0.0
        self._known = 0
        self._has_news = False

    def begin(self) -> None:
        self._started = time.monotonic()
        self._ends = self._started + self._length_s
        self._known, self._has_news = self._read_count(), False

    def poll(self) -> None:
        """Raises ``SliceOver``."""
        now = time.monotonic()
        if not self._has_news and self._read_count() > self._known:
            self._has_news = True
            if now <= self._ends:  # else it was the news that took long
                self._ends = now + max(SLICE_S, 2.0 * (now - self._started))
        if now > self._ends:
            if not self._has_news:
                self._length_s *= 2.0
            self._spent_s += now - self._started
            raise SliceOver

    def end(self) -> float:
        """All is read: the seconds that it took."""
        last_s = time.monotonic() - self._started
        seconds = self._spent_s + last_s
        self._length_s, self._spent_s = max(SLICE_S, 1.5 * last_s), 0.0
        return seconds
