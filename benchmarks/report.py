# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments and report of a benchmark in Python: the report has the shape of Google Benchmark's."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy

import tyndall.blender

Row = dict[str, float | str | bool]


def argument_parser(description: str | None, *, has_page: bool = False) -> argparse.ArgumentParser:
    """Arguments that scripts/bench.sh gives; with a page, the folder that it is written to."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--context", type=Path, required=True, help="JSON of what it is measured on")
    parser.add_argument("--output", type=Path, required=True)
    if has_page:
        parser.add_argument("--docs", type=Path)
    return parser


def row(name: str, seconds: float, **more: float | str | bool) -> Row:
    """One line of the report."""
    return {"name": name, "run_name": name, "real_time": seconds, "time_unit": "s", **more}


def write_report(rows: Sequence[Row], arguments: argparse.Namespace) -> None:
    """Write the rows, whole or not at all, with what they were measured on and in which Blender."""
    context = json.loads(arguments.context.read_text(encoding="utf-8")) | {"blender": bpy.app.version_string}
    part = arguments.output.with_suffix(".json.part")
    part.write_text(json.dumps({"context": context, "benchmarks": rows}, indent=1) + "\n", encoding="utf-8")
    part.replace(arguments.output)


def run_scenes(run: Callable[[list[str]], Sequence[Row]], description: str | None) -> None:
    """Report what `run` measures in the scenes that the command line names; in all of them without any."""
    parser = argument_parser(description)
    parser.add_argument("scenes", nargs="*", help="names of scenes; all without any")
    arguments = parser.parse_args()
    tyndall.blender.enable()
    write_report(run(arguments.scenes), arguments)


def write_page(name: str, text: str, arguments: argparse.Namespace) -> None:
    """A page of the documentation, whole or not at all; nowhere without --docs."""
    if arguments.docs is None:
        return
    part: Path = arguments.docs / f"{name}.part"
    part.write_text(text, encoding="utf-8")
    part.replace(arguments.docs / name)
