# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m tyndall render FILE.blend --output OUT.exr``: frames without a window, for farms and scripts.

``python -m tyndall voxelize FILE --resolution 65536 --out OUT.tdag`` is in ``voxelize_command``.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from . import farm, voxelize_command
from .frame_files import completed, frame_file, parse_frames, require_writable

SUCCESS, RENDER_FAILED, BAD_USAGE, BAD_OUTPUT, INTERRUPTED = 0, 1, 2, 3, 130
_EPILOG = """exit codes: 0 all frames are there; 1 a frame failed; 2 the arguments, the file or Blender's module are at
fault; 3 the output cannot be written; 130 interrupted. Frames whose file exists are skipped: run the same command again
to resume. A file has its name only when it is complete. With --scheduler, --processes, --tiles, --view-layers or --simd
each frame, tile or view layer is a process of Blender's own, and the files to be overwritten are removed first."""
_SUFFIXES = (".exr", ".png", ".tif", ".tiff", ".jpg", ".jpeg", ".hdr", ".webp")


class BlendFile(Protocol):
    """An open .blend, as tyndall.blender.blend_file offers it."""

    @property
    def frames(self) -> list[int]:
        """What renders if nobody says otherwise."""

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        """Write the picture and return its statistics. Raises RuntimeError and OSError."""


@dataclass(kw_only=True)
class Settings:
    """What overrides the file's own settings; None keeps them."""

    scene: str | None = None
    samples: int | None = None
    method: str | None = None
    threads: int | None = None
    multilayer: bool = False


@dataclass(kw_only=True)
class _Log:
    """What ``--statistics`` writes, anew after each frame, so that a killed run leaves what it did."""

    path: Path | None
    file: str
    frames: list[dict[str, Any]] = field(default_factory=list)

    def add(self, **entry: object) -> None:
        self.frames.append(entry)
        if self.path is not None:
            with completed(self.path) as temporary:
                temporary.write_text(json.dumps({"file": self.file, "frames": self.frames}, indent=1))


def main(arguments: Sequence[str] | None = None, open_blend: Callable[..., BlendFile] | None = None) -> int:
    """The exit code. ``open_blend(path, settings)`` replaces Blender in tests."""
    options = _parser().parse_args(arguments)
    try:
        if options.command == "voxelize":
            return _voxelize(options)
        return _render(options, open_blend)
    except KeyboardInterrupt:
        return _failed("interrupted", INTERRUPTED)
    except _UsageError as error:
        return _failed(str(error), BAD_USAGE)
    except OSError as error:
        return _failed(str(error), BAD_OUTPUT)


class _UsageError(Exception):
    """Said in one line, with exit code 2."""


def _voxelize(options: argparse.Namespace) -> int:
    def read_blend(*asked: Any) -> Any:  # noqa: ANN401
        return _blender("read_triangles")(*asked)

    try:
        return voxelize_command.run(options, read_blend)
    except OSError:
        raise
    except (RuntimeError, ValueError) as error:
        raise _UsageError(str(error)) from error


def _blender(name: str) -> Callable[..., Any]:
    """A part of ``tyndall.blender.blend_file``."""
    try:
        from .blender import blend_file  # noqa: PLC0415  needs bpy, which a message can ask for
    except ModuleNotFoundError as error:
        if error.name != "bpy":
            raise
        raise _UsageError(
            "Blender's module bpy is not installed for this Python: pip install bpy==4.5.*, "
            "or use Blender itself: blender -b FILE -E TYNDALL -o //out -f 1"
        ) from error
    part: Callable[..., Any] = getattr(blend_file, name)
    return part


def _render(options: argparse.Namespace, open_blend: Callable[..., BlendFile] | None) -> int:
    if not options.file.is_file():
        raise _UsageError(f"there is no file {options.file}")
    output = options.output.absolute()
    if output.suffix.lower() not in _SUFFIXES:
        raise _UsageError(f"{output.name}: the output's suffix may be one of {', '.join(_SUFFIXES)}")
    require_writable(output.parent)
    if options.statistics is not None:
        require_writable(options.statistics.absolute().parent)
    settings = Settings(
        scene=options.scene,
        samples=options.samples,
        method=options.method,
        threads=options.threads,
        multilayer=options.multilayer,
    )
    log = _Log(path=options.statistics and options.statistics.absolute(), file=str(options.file))
    if farm.is_asked_for(options):
        try:
            return RENDER_FAILED if farm.render(options, settings, output, log.add, _say) else SUCCESS
        except OSError:
            raise
        except (RuntimeError, ValueError) as error:
            raise _UsageError(str(error)) from error
    try:
        blend = (open_blend or _blender("OpenBlendFile"))(options.file.absolute(), settings)
    except (RuntimeError, ValueError) as error:
        raise _UsageError(str(error)) from error
    frames = options.frames or blend.frames
    return max((_frame(blend, frame, output, options, log, len(frames)) for frame in frames), default=SUCCESS)


def _frame(blend: BlendFile, frame: int, output: Path, options: argparse.Namespace, log: _Log, frame_count: int) -> int:
    path = frame_file(output, frame, is_only=frame_count == 1)
    if path.exists() and not options.overwrite:
        _say(f"frame {frame}: {path} exists, skipped")
        log.add(frame=frame, output=str(path), status="skipped")
        return SUCCESS
    started = time.perf_counter()
    try:
        with completed(path) as temporary:
            statistics = blend.render(frame, temporary)
    except RuntimeError as error:
        log.add(frame=frame, output=str(path), status="failed", error=str(error))
        return _failed(f"frame {frame}: {error}", RENDER_FAILED)
    seconds = time.perf_counter() - started
    _say(f"frame {frame}: {path}, {seconds:.2f} s")
    log.add(frame=frame, output=str(path), status="rendered", seconds=seconds, statistics=statistics)
    return SUCCESS


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def _failed(line: str, code: int) -> int:
    sys.stderr.write(f"tyndall: {line}\n")
    return code


def _frames(text: str) -> list[int]:
    try:
        return parse_frames(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _at_least(lowest: int) -> Callable[[str], int]:
    def number(text: str) -> int:
        try:
            value = int(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text} is no whole number") from error
        if value < lowest:
            raise argparse.ArgumentTypeError(f"{text} is less than {lowest}")
        return value

    return number


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tyndall", description="Renders .blend files, and makes voxel DAGs."
    )
    commands = parser.add_subparsers(required=True, dest="command")
    voxelize_command.add_arguments(
        commands.add_parser("voxelize", epilog=voxelize_command.EPILOG, help="make a voxel DAG of a scene or mesh")
    )
    render = commands.add_parser("render", epilog=_EPILOG, help="render frames of a file")
    add = render.add_argument
    add("file", type=Path, help="the .blend file")
    add("--output", type=Path, required=True, help="OUT.exr; #### becomes the frame's number")
    add("--frames", type=_frames, help="7, 1-10, 1-100x5 or a list of these; without it the file's current frame")
    add("--samples", type=_at_least(1), help="rays per pixel; 1: pixel centres")
    add("--method", choices=("EXACT", "EPIPOLAR", "SHADOW_MAP"), help="how light shafts are found")
    add("--threads", type=_at_least(0), help="0: all")
    add("--scene", help="the scene's name, if not the file's active one")
    add("--multilayer", action="store_true", help="one EXR with all view layers and passes")
    add("--statistics", type=Path, help="a JSON file: seconds, counts, reports and what was skipped, by frame")
    add("--overwrite", action="store_true", help="render frames whose file exists, too")
    farm.add_arguments(render, _at_least)
    return parser
