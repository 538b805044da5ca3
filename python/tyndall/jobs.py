# SPDX-License-Identifier: GPL-3.0-or-later
"""Independent jobs with files in and files out: in this process, in several, or on machines under Dask's scheduler.

A job is done when its file is there; what was done before is not done again. A job whose process or machine died is run
again. Functions and arguments are pickled: functions are those of a module that all machines have, files lie in folders
that all of them see under the same path.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tyndall._native import InvalidInput, IoError, Progress

_MOST_DEATHS = 3  # in a row, without a job that was done between them
_POLL_S = 0.1


@dataclass(frozen=True)
class Job:
    """A call that writes a file, whole or not at all."""

    function: Callable[..., object]
    arguments: tuple[Any, ...]
    output: Path


def run(
    jobs: Sequence[Job], workers: int | str | None = None, progress: Progress | None = None, share: float = 1.0
) -> None:
    """Run what is not done yet. ``workers``: None, here; a number of processes; the address of a Dask scheduler.

    What a job raises ends all; what is done stays. Raises IoError, which names a job whose process died again and again
    or that wrote no file; InvalidInput where Dask is not there; and Cancelled. ``progress`` goes up to ``share``:
    of all that the caller does, the jobs are that much.
    """
    progress = progress or Progress()
    left = [job for job in jobs if not job.output.exists()]
    deaths = 0
    while left:
        progress.poll()
        before = len(left)
        with _executor(workers) as (executor, lost):
            left = _not_done(executor, left, lost, _Report(progress, len(jobs), share))
        deaths = deaths + 1 if len(left) == before else 0
        if deaths == _MOST_DEATHS:
            raise IoError(
                f"{left[0].output}: the process that was to write it ended {deaths} times without a word: see that "
                "there is memory enough for all workers; what is done stays"
            )


@dataclass(frozen=True)
class _Report:
    """Says how far the jobs are."""

    progress: Progress
    count: int  #: Of all jobs, those that were done before among them.
    share: float

    def left(self, left_count: int) -> None:
        done = self.count - left_count
        self.progress.message = f"{done} of {self.count} parts"
        self.progress.advance_to(self.share * done / self.count)


def _not_done(
    executor: Executor | None, jobs: list[Job], lost: tuple[type[BaseException], ...], report: _Report
) -> list[Job]:
    """Run jobs; returns those whose process died."""
    if executor is None:
        for index, job in enumerate(jobs):
            report.progress.poll()
            job.function(*job.arguments)
            _require_output(job)
            report.left(len(jobs) - index - 1)
        return []
    futures: dict[Future[object], Job] = {executor.submit(job.function, *job.arguments): job for job in jobs}
    running = set(futures)
    try:
        while running:
            report.progress.poll()
            ended, running = wait(running, timeout=_POLL_S, return_when=FIRST_COMPLETED)
            for future in ended:
                error = None if future.cancelled() else future.exception()
                if error is not None and not isinstance(error, lost):
                    raise error
                if error is None and not future.cancelled():
                    _require_output(futures[future])
            report.left(sum(not job.output.exists() for job in jobs))
    finally:
        for future in running:
            future.cancel()
    return [job for job in jobs if not job.output.exists()]


def _require_output(job: Job) -> None:
    if not job.output.exists():
        raise IoError(f"{job.output}: its job ended and wrote no file: see that all machines see its folder")


@contextmanager
def _executor(workers: int | str | None) -> Iterator[tuple[Executor | None, tuple[type[BaseException], ...]]]:
    """Where jobs run, and what tells that a process died."""
    if workers is None:
        yield None, ()
    elif isinstance(workers, int):
        # multiprocessing keeps the module __main__, which Blender frees when a script has run: it would crash at exit.
        from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor  # noqa: PLC0415
        from multiprocessing import get_context  # noqa: PLC0415

        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            yield pool, (BrokenProcessPool,)
    else:
        distributed = _dask()
        with distributed.Client(workers, set_as_default=False) as client:
            # Dask runs what was lost with a worker again by itself, some times; we run what it gave up.
            yield client.get_executor(pure=False), (distributed.KilledWorker, CancelledError)


def _dask() -> Any:  # noqa: ANN401 - a module that need not be there
    try:
        import distributed  # noqa: PLC0415 - of all this module does, one way needs it
    except ModuleNotFoundError as error:
        if error.name != "distributed":
            raise
        raise InvalidInput(
            "Dask is not installed for this Python: pip install distributed, here and on all workers; "
            "or name a number of processes on this machine"
        ) from error
    return distributed
