# SPDX-License-Identifier: GPL-3.0-or-later
"""Random edits of a rendered viewport, drawn by seeds: TYNDALL_EDIT_SEEDS is "FIRST LAST".

After each sequence there must be a picture or an error that names something. What happens is written line by line, so
that a crash shows the edit that it followed.
"""

from __future__ import annotations

import json
import os
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

from support.beam_scene import build_beam_scene
from support.edit_sequences import EDITS, SAVED, STEPS, is_rendering, leave_eevee, made, renders_begun

WORKING = ("Updating", "Rendering")  #: What a status begins with that is no error.
RENDER_S = 240  #: A whole picture, while the viewport renders too and other tests run: more than this is a hang.


def session(window: Any) -> Iterator[float]:  # noqa: C901  its helpers share its state
    from addon.engine import failures, viewport
    from addon.engine.viewport_worker import ViewportWorker

    first, last = map(int, os.environ["TYNDALL_EDIT_SEEDS"].split())
    log = Path(window.folder / "edits.jsonl")
    silent: list[str] = []
    begun = renders_begun()

    def note(**facts: object) -> None:
        with log.open("a") as lines:
            lines.write(json.dumps(facts) + "\n")

    def show_rendered() -> None:
        for space in (area.spaces[0] for area in window.bpy_window.screen.areas if area.type == "VIEW_3D"):
            space.region_3d.view_perspective = "CAMERA"
            space.shading.type = "RENDERED"

    def worker() -> ViewportWorker | None:
        return next((open_one.worker for open_one in viewport.open_viewports.values()), None)

    def is_finished() -> bool:
        now = worker()
        return now is not None and bool(now.picture or now.status) and not now.status.startswith(WORKING)

    def tell_of(seed: int) -> None:
        """An error is said, not swallowed, and names something."""
        if status := worker().status:
            note(seed=seed, status=status)
            if '"' not in status and "'" not in status and "camera" not in status.lower():
                silent.append(f"seed {seed}: {status}")
        if failures.last_error():
            note(seed=seed, failure=failures.last_error())

    yield from window.calm()
    for seed in range(first, last + 1):
        chance = random.Random(seed)  # noqa: S311  no secret
        bpy.ops.wm.read_factory_settings()
        yield 0.05
        scene = build_beam_scene()
        scene.tyndall.pixel_samples = scene.tyndall.viewport_samples = 1
        bpy.ops.wm.save_as_mainfile(filepath=str(window.folder / SAVED), copy=True)
        bpy.ops.ed.undo_push(message="built")
        show_rendered()
        for _ in range(STEPS):
            name, edit = chance.choice(EDITS)
            note(seed=seed, edit=name)
            yield from made(edit, chance, window, begun)
            leave_eevee()
            yield chance.choice((0.0, 0.01, 0.05, 0.2))
            show_rendered()
        yield from window.until(lambda: not is_rendering(), at_most_s=RENDER_S)
        bpy.context.scene.render.engine = "TYNDALL"
        show_rendered()
        yield 0.1
        yield from window.until(is_finished, at_most_s=60)
        tell_of(seed)
    window.facts["silent"] = silent
    window.facts["seeds"] = [first, last]
