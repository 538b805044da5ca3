# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from the wild are damaged: no scene may crash us, each culprit is named, and the rest still renders.

The scenes are those of tests/support/damaged_scenes.py, 550 of them, rendered in processes of their own: where one ends
before its time, or says nothing for too long, the scene it had begun is the one that crashed or hung it, and the next
process goes on behind it. Every push renders each damage alone, a third of them in each version of Blender; all 550 are
among the long tests.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import pytest

from support.damaged_scenes import DAMAGES, HIDES_ALL, damages_of

pytestmark = pytest.mark.dealt
ROOT = Path(__file__).parents[2]
SCENE_COUNT = 550
THIRDS = tuple(len(DAMAGES) * third // 3 for third in range(4))
SCENE_LIMIT_S = 120  # most take half a second: for a hang, not for a machine that others use as well


def _command(first: int, last: int) -> list[str]:
    if bpy.app.binary_path:
        script = str(ROOT / "tests/support/run_in_blender.py")
        return [
            bpy.app.binary_path,
            "-b",
            "--factory-startup",
            "--python",
            script,
            "--",
            "support.damaged_scenes",
            str(first),
            str(last),
        ]
    return [sys.executable, "-m", "support.damaged_scenes", str(first), str(last)]


def _environment() -> dict[str, str]:
    folders = (ROOT, ROOT / "tests", ROOT / "python", ROOT / "build/release/python")
    return {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, folders))}


def _lines(process: subprocess.Popen[bytes]) -> Iterator[bytes]:
    """What it says of its scenes; where it says nothing for too long it is ended, which counts as a crash."""
    while True:
        watchdog = threading.Timer(SCENE_LIMIT_S, process.kill)
        watchdog.start()
        line = process.stdout.readline()
        watchdog.cancel()
        if not line:
            process.wait()
            return
        if line.startswith(b'{"seed"'):  # and not Blender's greeting
            yield line


@pytest.fixture(
    scope="module",
    params=[
        *(
            pytest.param(THIRDS[i : i + 2], id=f"each of the {name} third alone")
            for i, name in enumerate(("first", "second", "last"))
        ),
        pytest.param((len(DAMAGES), SCENE_COUNT), id="together", marks=pytest.mark.long),
    ],
)
def outcomes(request: pytest.FixtureRequest) -> dict[int, dict[str, Any]]:
    """What came of each seed; a crash is an outcome without an end."""
    found: dict[int, dict[str, Any]] = {}
    first, end = request.param
    while first < end:
        first = _rendered(first, end, found) + 1
    return found


def _rendered(first: int, end: int, found: dict[int, dict[str, Any]]) -> int:
    """Render seeds in one process, as far as it gets; the last that it began."""
    begun = first
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen(
            _command(first, end), env=_environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=said, cwd=ROOT,
        ) as process:  # fmt: skip
            for line in _lines(process):
                entry = json.loads(line)
                begun = entry["seed"]
                found[begun] = entry
        if found.get(begun, {"begins": True}).get("begins"):
            said.seek(0)
            found[begun] = {"crash": process.returncode, "said": said.read().decode(errors="replace")[-2000:]}
    return begun


def _described(seed: int) -> str:
    return f"seed {seed} ({', '.join(each.name for each in damages_of(seed))})"


def test_every_damage_occurs_alone_and_in_company() -> None:
    """The generator itself: no damage is missing from the 550 scenes."""
    alone = {damages_of(seed)[0].name for seed in range(len(DAMAGES))}
    together = {each.name for seed in range(len(DAMAGES), SCENE_COUNT) for each in damages_of(seed)}
    assert alone == together == {each.name for each in DAMAGES}


def test_none_crashes(outcomes: dict[int, dict[str, Any]]) -> None:
    """Neither a signal, nor a hang, nor an exception that nobody meant."""
    crashes = [f"{_described(seed)}: {end['crash']} {end['said']}" for seed, end in outcomes.items() if "crash" in end]
    assert not crashes, "\n".join(crashes)
    traces = [
        f"{_described(seed)}: {end['error']}" for seed, end in outcomes.items() if "Traceback" in end.get("error", "")
    ]
    assert not traces, "\n".join(traces)


def test_each_culprit_is_named(outcomes: dict[int, dict[str, Any]]) -> None:
    """In a report; or, where there is no picture, in the error: that stops at the first, and Blender has its own."""
    silent = []
    for seed, end in outcomes.items():
        culprits = [name for each in damages_of(seed) for name in each.culprits]
        if end.get("error"):
            is_named = any(name in end["error"] for name in culprits)
            missing = [] if is_named or not HIDES_ALL.isdisjoint(each.of for each in damages_of(seed)) else culprits
        else:
            missing = [name for name in culprits if name not in "\n".join(end.get("reports", []))]
        if missing:
            silent.append(f"{_described(seed)}: {missing} in neither {end.get('reports')} nor {end.get('error')!r}")
    assert not silent, "\n".join(silent)


def test_the_rest_still_renders(outcomes: dict[int, dict[str, Any]]) -> None:
    """Wherever the camera and the frame are sound there is a picture, finite everywhere and lit somewhere."""
    lost = []
    for seed, end in outcomes.items():
        if "brightest" in end and not end["is_finite"]:
            lost.append(f"{_described(seed)}: not finite")
        is_swallowed = any("lets nothing of it through" in line for line in end.get("reports", []))  # by an endless fog
        may_be_dark = is_swallowed or not HIDES_ALL.isdisjoint(each.of for each in damages_of(seed))
        if not may_be_dark and not end.get("brightest", 0.0) > 0.01:
            lost.append(f"{_described(seed)}: dark or absent: {end.get('error')}")
    assert not lost, "\n".join(lost)


# Seen to fail: with what glows beyond all measure, all was dark.
def test_what_stands_beside_keeps_its_picture(outcomes: dict[int, dict[str, Any]]) -> None:
    """An object that is damaged, and is the only one, costs no other its light; it may add some, where it glows."""
    changed = [
        f"{_described(seed)}: by {end['lost_beside']:.2g}"
        for seed, end in outcomes.items()
        if not end.get("lost_beside", 0.0) < 1e-5  # what rounding leaves
    ]
    assert not changed, "\n".join(changed)
