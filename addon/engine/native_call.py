# SPDX-License-Identifier: GPL-3.0-or-later
"""A native render in a thread of its own, while Blender's render thread watches over it.

The native side releases the GIL; Blender's API is only called by the watching thread.
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from tyndall import Cancelled, Progress

if TYPE_CHECKING:
    from collections.abc import Callable

    from tyndall.renderer import Film

_POLL_S = 0.1


class NativeCall:
    """Runs ``work``, which may show films before it is done by calling its second argument."""

    def __init__(self, work: Callable[[Progress, Callable[[Film], None]], Film]) -> None:
        self.progress = Progress()
        self._work = work
        self._shown: Film | None = None
        self._result: Film | None = None
        self._error: BaseException | None = None

    def watch(self, *, is_cancelled: Callable[[], bool], tick: Callable[[Progress, Film | None], None]) -> Film:
        """The finished film. Raises what ``work`` raised; Cancelled after ``is_cancelled`` answered True.

        ``tick`` gets every 0.1 s the progress, and the latest film that it has not seen yet.
        """
        thread = threading.Thread(target=self._run, name="tyndall render")
        thread.start()
        try:
            while thread.is_alive():
                started = time.monotonic()
                if is_cancelled():
                    self.progress.cancel()
                else:
                    film, self._shown = self._shown, None
                    tick(self.progress, film)
                thread.join(max(0.0, _POLL_S - (time.monotonic() - started)))
        finally:  # an error of tick, or Ctrl-C: nothing native may outlive this call
            self.progress.cancel()
            thread.join()
        if self._error is not None:
            raise self._error
        if self._result is None:
            raise Cancelled
        return self._result

    def _run(self) -> None:
        try:
            self._result = self._work(self.progress, self._show)
        except BaseException as error:  # noqa: BLE001  handed to the thread that watches
            self._error = error

    def _show(self, film: Film) -> None:
        self._shown = film
