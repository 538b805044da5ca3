# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m tyndall render ... --scheduler ADDRESS``: frames, tiles and view layers as jobs on several machines.

Each job is a process with bpy of its own, whose file has its name when it is whole. Tiles and view layers leave as
films in a hidden folder beside the output; a job that needs all of a frame puts them through Blender into the one file.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .farm_tasks import SIMD_NAMES, TaskError, run_task
from .frame_files import frame_file, require_writable

if TYPE_CHECKING:
    from .command_line import Settings
    from .jobs import Job


def add_arguments(parser: argparse.ArgumentParser, at_least: Callable[[int], Callable[[str], int]]) -> None:
    """Those of the command that concern jobs."""
    add = parser.add_argument
    workers = parser.add_mutually_exclusive_group()
    workers.add_argument("--scheduler", help="Dask's, tcp://10.0.0.1:8786: jobs go to its workers")
    workers.add_argument("--processes", type=at_least(1), help="so many jobs at once on this machine")
    add("--tiles", type=_tiles, help="4x2: each frame as tiles, columns x rows; the file is that of the whole frame")
    add("--view-layers", action="store_true", help="each view layer as a job; the file is that of the whole frame")
    add("--retries", type=at_least(0), default=2, help="a job that fails is tried so often again; 2 unless said")
    add("--simd", choices=SIMD_NAMES, help="the instruction set, so that machines' pictures have the same bits")


def is_asked_for(options: argparse.Namespace) -> bool:
    """Whether the command is one for jobs."""
    return any((options.scheduler, options.processes, options.tiles, options.view_layers, options.simd))


def render(
    options: argparse.Namespace,
    settings: Settings,
    output: Path,
    log: Callable[..., None],
    say: Callable[[str], None],
) -> bool:
    """Whether a frame failed. Raises RuntimeError and ValueError for what is wrong before anything renders."""
    from . import jobs  # noqa: PLC0415 - the native part, without which the help is still told

    base = {"file": str(options.file.absolute()), "settings": asdict(settings), "simd": options.simd, "versions": {}}
    scene = run_task(base | {"kind": "describe"})
    base["versions"] = scene["versions"]
    plan = _Plan(base, output, options.tiles or (1, 1), scene["layers"] if options.view_layers else None)
    why_not = scene["why_not_tiles" if options.tiles else "why_not_layers"] if plan.is_in_parts else None
    if why_not is not None:
        raise ValueError(why_not)
    if plan.is_in_parts:
        plan.layers = plan.layers or scene["layers"]
    if options.scheduler:
        _require_usable(jobs.ask_workers(options.scheduler, run_task, base | {"kind": "probe"}), say)
    listener = _Listener(say, log)
    frames, todo = options.frames or scene["frames"], []
    for frame in frames:
        path = frame_file(output, frame, is_only=len(frames) == 1)
        if path.exists() and not options.overwrite:
            say(f"frame {frame}: {path} exists, skipped")
            log(frame=frame, output=str(path), status="skipped")
            continue
        path.unlink(missing_ok=True)
        todo += plan.jobs_of(frame, path)
    listener.count = len(todo)
    if plan.is_in_parts:
        require_writable(plan.folder)
    jobs.run(todo, options.scheduler or options.processes, retries=options.retries, listener=listener)
    if plan.is_in_parts and not listener.has_failed:
        shutil.rmtree(plan.folder, ignore_errors=True)
    return listener.has_failed


def _require_usable(answers: dict[str, Any], say: Callable[[str], None]) -> None:
    for address, answer in answers.items():
        if isinstance(answer, TaskError):
            raise ValueError(f"worker {address} cannot render: {answer}")  # noqa: TRY004 - of the farm, not a type
        if isinstance(answer, BaseException):  # it went while it was asked, or has no Tyndall: its jobs will tell
            say(f"worker {address} did not answer: {answer}")
    say(f"{len(answers)} workers" if answers else "the scheduler has no workers yet: waiting for them")


@dataclass
class _Plan:
    """Which jobs frames are."""

    base: dict[str, Any]  #: What all tasks have in common.
    output: Path
    tiles: tuple[int, int]  #: Columns and rows.
    layers: list[str] | None  #: That are jobs of their own; None: a frame is one job, unless it has tiles.

    @property
    def is_in_parts(self) -> bool:
        return self.layers is not None or self.tiles != (1, 1)

    @property
    def folder(self) -> Path:
        """For parts; one of its own for each state of the file and the settings, so that parts fit each other."""
        state = Path(self.base["file"]).stat()
        key = json.dumps([self.base, self.tiles, self.layers, state.st_mtime_ns, state.st_size])
        return self.output.parent / f".{self.output.stem}.{hashlib.sha256(key.encode()).hexdigest()[:12]}.parts"

    def jobs_of(self, frame: int, path: Path) -> list[Job]:
        task = self.base | {"frame": frame}
        if not self.is_in_parts:
            return [_job(task | {"kind": "frame"}, path)]
        columns, rows = self.tiles
        folder, parts, tiles = self.folder, [], {}
        for index, layer in enumerate(self.layers or ()):
            tiles[layer] = [
                [str(folder / f"{frame}_{index}_{column}_{row}.npz") for column in range(columns)]
                for row in range(rows)
            ]
            parts += [
                _job(task | {"kind": "part", "layer": layer, "tile": [column, row, columns, rows]}, Path(name))
                for row, names in enumerate(tiles[layer])
                for column, name in enumerate(names)
            ]
        needs = tuple(part.output for part in parts)
        return [*parts, _job(task | {"kind": "assemble", "tiles": tiles}, path, needs)]


def _job(task: dict[str, Any], path: Path, needs: tuple[Path, ...] = ()) -> Job:
    from .jobs import Job  # noqa: PLC0415 - the native part

    return Job(run_task, (task | {"output": str(path)},), path, needs)


@dataclass
class _Listener:
    """Says what becomes of each job."""

    say: Callable[[str], None]
    log: Callable[..., None]
    count: int = 0
    done_count: int = 0
    has_failed: bool = False

    def done(self, job: Job, result: dict[str, Any]) -> None:
        self.done_count += 1
        task = job.arguments[0]
        share = f"{self.done_count} of {self.count} jobs"
        self.say(f"{_name(task)}: {job.output}, {result['seconds']:.2f} s on {result['host']}; {share}")
        if task["kind"] == "part":
            return
        for need in job.needs:
            need.unlink(missing_ok=True)
        self.log(frame=task["frame"], output=str(job.output), status="rendered", **result)

    def failed(self, job: Job, error: BaseException, *, is_tried_again: bool) -> None:
        task = job.arguments[0]
        self.say(f"{_name(task)}: {error}{'; it is tried again' if is_tried_again else ''}")
        if not is_tried_again:
            self.has_failed = True
            self.log(frame=task["frame"], output=str(job.output), status="failed", error=str(error))


def _name(task: dict[str, Any]) -> str:
    if task["kind"] != "part":
        return f"frame {task['frame']}"
    column, row, columns, rows = task["tile"]
    tile = f", tile {column + 1}, {row + 1}" if (columns, rows) != (1, 1) else ""
    return f'frame {task["frame"]}, view layer "{task["layer"]}"{tile}'


def _tiles(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([1-9]\d{0,2})x([1-9]\d{0,2})", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"{text} is no number of columns and rows such as 4x2")
    return int(match[1]), int(match[2])
