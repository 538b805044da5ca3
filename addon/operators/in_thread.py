# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that takes long: in a thread, with progress, until Esc, where there is a window; at once for a script."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from bpy.types import Context, Event

if TYPE_CHECKING:
    from tyndall import Progress

_TICK_S = 0.1


class InThread:
    """What an operator inherits that begins and ends in Blender's own thread, and works in another one."""

    thread_name = "tyndall work"

    def begin(self, context: Context) -> bool:
        """Read what the work needs from Blender. False, after a report: there is nothing to do."""
        raise NotImplementedError

    def work(self, progress: Progress) -> None:
        """Without bpy. What it raises is what ``end`` gets."""
        raise NotImplementedError

    def end(self, context: Context, error: BaseException | None) -> set[str]:
        raise NotImplementedError

    def execute(self, context: Context) -> set[str]:
        if not self.begin(context):
            return {"CANCELLED"}
        self._prepare()
        self._run()
        return self.end(context, self._error)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self.start(context) if self.begin(context) else {"CANCELLED"}

    def start(self, context: Context) -> set[str]:
        """In a thread, after ``begin``."""
        self._prepare()
        self._thread = threading.Thread(target=self._run, name=self.thread_name)
        self._thread.start()
        self._timer = context.window_manager.event_timer_add(_TICK_S, window=context.window)
        context.window_manager.progress_begin(0.0, 1.0)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "ESC":
            self._progress.cancel()
        elif event.type == "TIMER":
            context.window_manager.progress_update(self._progress.fraction)
            context.workspace.status_text_set(f"{self._progress.message}    Esc: stop")
            if not self._thread.is_alive():
                self._put_away(context)
                return self.end(context, self._error)
        return {"RUNNING_MODAL"}

    def cancel(self, _context: Context) -> None:
        """Blender asks for it where it closes the window or opens another file: nobody waits for the work any more."""
        self._progress.cancel()
        self._thread.join()

    def _prepare(self) -> None:
        from tyndall import Progress

        self._progress = Progress()
        self._error: BaseException | None = None

    def _run(self) -> None:
        try:
            self.work(self._progress)
        except BaseException as error:  # noqa: BLE001  handed to the thread that watches
            self._error = error

    def _put_away(self, context: Context) -> None:
        self._thread.join()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
