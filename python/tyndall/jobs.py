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
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from tyndall._native import InvalidInput, IoError, Progress

_MOST_DEATHS = 3  # in a row, without a job that was done between them
_POLL_S = 0.1
_LONGEST_ANSWER_S = 10.0  # of a scheduler


@dataclass(frozen=True)
class Job:
    """A call that writes a file, whole or not at all."""

    function: Callable[..., object]
    arguments: tuple[Any, ...]
    output: Path
    needs: tuple[Path, ...] = ()  #: Outputs of other jobs, which come first; where one of those fails, so does this.


class Listener(Protocol):
    """Hears of each job; with one, a job that fails does not end the others."""

    def done(self, job: Job, result: Any) -> None:  # noqa: ANN401 - the function's
        """The job has written its file."""

    def failed(self, job: Job, error: BaseException, *, is_tried_again: bool) -> None:
        """The job raised."""


def run(
    jobs: Sequence[Job],
    workers: int | str | None = None,
    progress: Progress | None = None,
    share: float = 1.0,
    *,
    retries: int = 0,
    listener: Listener | None = None,
) -> None:
    """Run what is not done yet. ``workers``: None, here; a number of processes; the address of a Dask scheduler.

    A job that raises is tried again so many times, on another worker where there is one. What it raises then ends all,
    unless there is a ``listener``; what is done stays. Raises IoError, which names a job whose process died again and
    again or that wrote no file; InvalidInput where Dask is not there; and Cancelled. ``progress`` goes up to ``share``:
    of all that the caller does, the jobs are that much.
    """
    progress = progress or Progress()
    left = [job for job in jobs if not job.output.exists()]
    attempts = _Attempts(retries, listener)
    deaths = 0
    while left:
        progress.poll()
        before = len(left)
        with _executor(workers) as (executor, lost):
            left = _not_done(executor, left, lost, _Report(progress, len(jobs), share), attempts)
        deaths = deaths + 1 if len(left) == before else 0
        if deaths == _MOST_DEATHS:
            raise IoError(
                f"{left[0].output}: the process that was to write it ended {deaths} times without a word: see that "
                "there is memory enough for all workers; what is done stays"
            )


def ask_workers(scheduler: str, function: Callable[..., Any], *arguments: Any) -> dict[str, Any]:  # noqa: ANN401
    """What a function answers, or raises, on each worker that a Dask scheduler has now, by the worker's address."""
    with _client(scheduler) as client:
        answers: dict[str, Any] = client.run(function, *arguments, on_error="return")
        return answers


@dataclass(eq=False)
class _Attempts:
    """Which jobs failed how often, and on which of Dask's workers."""

    retries: int
    listener: Listener | None
    counts: dict[Path, int] = field(default_factory=dict)
    avoided: dict[Path, set[str]] = field(default_factory=dict)

    def failed(self, job: Job, error: BaseException) -> bool:
        """Whether the job is to be tried again. Raises the error if nobody else hears of it."""
        count = self.counts[job.output] = self.counts.get(job.output, 0) + 1
        self.avoided.setdefault(job.output, set()).update(filter(None, [getattr(error, _WORKER, None)]))
        is_tried_again = count <= self.retries
        if self.listener is None and not is_tried_again:
            raise error
        if self.listener is not None:
            self.listener.failed(job, error, is_tried_again=is_tried_again)
        return is_tried_again


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
    executor: _Submit, jobs: list[Job], lost: tuple[type[BaseException], ...], report: _Report, attempts: _Attempts
) -> list[Job]:
    """Run jobs; returns those whose process died."""
    queue = _Queue(executor, list(jobs), attempts)
    try:
        while queue.hand_out(report.progress):
            report.progress.poll()
            ended, queue.running = wait(queue.running, timeout=_POLL_S, return_when=FIRST_COMPLETED)
            for future in ended:
                if not future.cancelled() and not isinstance(future.exception(), lost):
                    queue.take_back(future)
            if ended:
                report.left(sum(queue.is_left(job) for job in jobs))
    finally:
        for future in queue.running:
            future.cancel()
    return [job for job in jobs if job.output not in queue.gone and queue.is_left(job)]


@dataclass(eq=False)
class _Queue:
    """Jobs that wait for others or for a worker, and those at work."""

    executor: _Submit
    waiting: list[Job]
    attempts: _Attempts
    job_of: dict[Future[object], Job] = field(default_factory=dict)
    running: set[Future[object]] = field(default_factory=set)
    gone: set[Path] = field(default_factory=set)  #: Outputs that there will not be.
    done: set[Path] = field(default_factory=set)  #: Outputs that there were, whoever has taken them away since.

    def is_left(self, job: Job) -> bool:
        return job.output not in self.done and not job.output.exists()

    def hand_out(self, progress: Progress) -> bool:
        """Submit what needs nothing any more; whether something is at work."""
        for job in [job for job in self.waiting if self.gone.intersection(job.needs)]:
            self.gone.add(job.output)
            self.waiting.remove(job)
        ready = [job for job in self.waiting if all(path.exists() for path in job.needs)]
        for job in ready[: self.executor.most_at_once]:
            progress.poll()
            future = self.executor.submit(job, self.attempts.avoided.get(job.output, set()))
            self.job_of[future] = job
            self.running.add(future)
            self.waiting.remove(job)
        return len(self.running) > 0

    def take_back(self, future: Future[object]) -> None:
        """Of a job that ended, well or with an error."""
        job = self.job_of[future]
        error = future.exception() or _missing_output(job)
        if error is None:
            self.done.add(job.output)
            if self.attempts.listener is not None:
                self.attempts.listener.done(job, future.result())
        elif self.attempts.failed(job, error):
            self.waiting.append(job)
        else:
            self.gone.add(job.output)


def _missing_output(job: Job) -> IoError | None:
    if job.output.exists():
        return None
    return IoError(f"{job.output}: its job ended and wrote no file: see that all machines see its folder")


@dataclass(frozen=True)
class _Submit:
    """Hands jobs out."""

    executor: Executor | None = None  #: None: they run here, when they are handed out.
    client: Any = None  #: Dask's.

    @property
    def most_at_once(self) -> int | None:
        return 1 if self.executor is None else None

    def submit(self, job: Job, avoided: set[str]) -> Future[object]:
        """``avoided``: addresses of Dask's workers, which get it only if there are no others."""
        if self.executor is None:
            future: Future[object] = Future()
            try:
                future.set_result(job.function(*job.arguments))
            except Exception as error:  # noqa: BLE001 - for who asks the future
                future.set_exception(error)
            return future
        if self.client is None:
            return self.executor.submit(job.function, *job.arguments)
        others = [address for address in self.client.ncores() if address not in avoided]
        executor = self.executor
        if avoided and others:
            executor = self.client.get_executor(pure=False, workers=others, allow_other_workers=True)
        return executor.submit(_on_worker, job.function, job.arguments)


_WORKER = "tyndall_worker"


def _on_worker(function: Callable[..., object], arguments: tuple[Any, ...]) -> object:
    """The call; what it raises has the worker's address."""
    try:
        return function(*arguments)
    except Exception as error:
        setattr(error, _WORKER, _dask().get_worker().address)
        raise


@contextmanager
def _executor(workers: int | str | None) -> Iterator[tuple[_Submit, tuple[type[BaseException], ...]]]:
    """Where jobs run, and what tells that a process died."""
    if workers is None:
        yield _Submit(), ()
    elif isinstance(workers, int):
        # multiprocessing keeps the module __main__, which Blender frees when a script has run: it would crash at exit.
        from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor  # noqa: PLC0415
        from multiprocessing import get_context  # noqa: PLC0415

        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            yield _Submit(pool), (BrokenProcessPool,)
    else:
        distributed = _dask()
        with _client(workers) as client:
            # Dask runs what was lost with a worker again by itself, some times; we run what it gave up.
            lost = (distributed.KilledWorker, CancelledError)
            yield _Submit(client.get_executor(pure=False), client), lost


@contextmanager
def _client(scheduler: str) -> Iterator[Any]:
    try:
        client = _dask().Client(scheduler, set_as_default=False, timeout=_LONGEST_ANSWER_S)
    except (OSError, ValueError) as error:
        raise InvalidInput(f"there is no Dask scheduler at {scheduler}: {error}") from error
    with client:
        yield client


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
