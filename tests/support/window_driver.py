# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window: plays a session, which is a generator, between the events of Blender's own loop.

blender --factory-startup --python tests/support/window_driver.py -- SESSION.py FOLDER
A session yields seconds to wait. What it puts into ``window.facts`` arrives in FOLDER/facts.json. Blender ends with it.
It names in CLICKS the operators that it has Blender run by the mouse or a key: one that never ran so is an error.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import addon_utils
import bpy

REPOSITORY = Path(__file__).parents[2]
for folder in (REPOSITORY, REPOSITORY / "tests", REPOSITORY / "python", REPOSITORY / "build/release/python"):
    sys.path.append(str(folder))

TICK_S = 0.01
CALM_TICKS = 10
SETTLED_TICKS = 5
#: Between ticks, while Blender answers steadily: on a busy machine, where it never answers sooner, the next of these.
STEADY_GAPS_S = (0.1, 0.2, 0.4)
POLL_S = 0.01


@dataclass
class Wait:
    """For a condition, until the clock shows a time."""

    is_so: Callable[[], bool]
    ends_s: float
    is_met: bool = False


class Window:
    """Hands for a session: areas, screenshots, and a clock that shows for how long the window did not answer."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.facts: dict[str, Any] = {}
        self.clicked: set[str] = set()  #: Operators of ours that Blender's own loop ran.
        self.is_in_script = True  #: Not so while Blender handles events.
        self._last_tick = time.monotonic()
        self._longest_gap_s = 0.0
        self._calm_ticks = 0
        self._steady_gap_s = STEADY_GAPS_S[0]
        self._ticks = 0
        self._wait: Wait | None = None
        bpy.app.timers.register(self._tick, persistent=True)

    def _tick(self) -> float:
        now = time.monotonic()
        gap_s = now - self._last_tick
        self._longest_gap_s = max(self._longest_gap_s, gap_s)
        self._calm_ticks = self._calm_ticks + 1 if gap_s < self._steady_gap_s else 0
        self._last_tick = now
        self._ticks += 1
        return TICK_S

    def start_watch(self) -> None:
        """Forget the gaps so far."""
        self._longest_gap_s, self._last_tick = 0.0, time.monotonic()

    def longest_gap_s(self) -> float:
        """The longest time since ``start_watch`` in which the window handled no event."""
        return self._longest_gap_s

    def calm(self) -> Iterator[float]:
        """Wait until the window answers steadily: drawing on the CPU, Blender compiles shaders for seconds."""
        self._calm_ticks = 0
        for self._steady_gap_s in STEADY_GAPS_S:
            try:
                yield from self.until(lambda: self._calm_ticks >= CALM_TICKS, at_most_s=60.0)
            except TimeoutError:
                continue
            return
        raise TimeoutError("the window never answers steadily")

    def settled(self) -> Iterator[float]:
        """Wait until Blender has handled what mouse and keys just did: rounds of its loop, however long each is."""
        handled = self._ticks + SETTLED_TICKS
        yield from self.until(lambda: self._ticks >= handled)

    @property
    def bpy_window(self) -> bpy.types.Window:
        return bpy.context.window_manager.windows[0]

    def area(self, kind: str) -> bpy.types.Area:
        """The largest area of a kind: ``VIEW_3D``, ``PROPERTIES``."""
        areas = [area for area in self.bpy_window.screen.areas if area.type == kind]
        return max(areas, key=lambda area: area.width * area.height)

    def region(self, kind: str) -> bpy.types.Region:
        return next(region for region in self.area(kind).regions if region.type == "WINDOW")

    def screenshot(self, name: str) -> Path:
        """What a person would see: the pixels of the X server."""
        path = self.folder / f"{name}.png"
        print(f"{time.monotonic():.1f} s: {name}", flush=True)
        # Packed as loosely as PNG has it: tightly, it takes a fifth of all the time that the tests do.
        subprocess.run(["import", "-window", "root", "-quality", "10", str(path)], check=True)
        return path

    def until(self, is_so: Callable[[], bool], *, at_most_s: float = 120.0) -> Iterator[float]:
        """Wait for a condition, which only reads; ``yield from`` it."""
        self._wait = wait = Wait(is_so, time.monotonic() + at_most_s)
        yield POLL_S
        self._wait = None
        if not wait.is_met:
            raise TimeoutError(f"waited {at_most_s} s in vain")

    def is_waiting(self) -> bool:
        """Whether ``until`` goes on waiting.

        The session sleeps meanwhile: to play it on where Blender denies writes has all windows drawn anew.
        """
        if self._wait is None:
            return False
        self._wait.is_met = self._wait.is_so()
        return not self._wait.is_met and time.monotonic() < self._wait.ends_s


def watch_operators(window: Window) -> None:
    """Note which operators of ours run by a click or a key, and not because the session's own code calls them."""
    from addon.operators import CLASSES  # noqa: PLC0415  after the path is set

    def noting(run: Callable[..., set[str]], name: str) -> Callable[..., set[str]]:
        def invoke(self: Any, context: Any, event: Any) -> set[str]:
            if not window.is_in_script:
                window.clicked.add(name)
            return run(self, context, event)

        def execute(self: Any, context: Any) -> set[str]:
            if not window.is_in_script:
                window.clicked.add(name)
            return run(self, context)

        return invoke if run.__name__ == "invoke" else execute  # Blender counts their arguments

    for cls in CLASSES:
        for name in ("invoke", "execute"):
            if issubclass(cls, bpy.types.Operator) and (run := getattr(cls, name, None)) is not None:
                setattr(cls, name, noting(run, cls.bl_idname))


def play(session: Iterator[float], expected: Iterable[str], window: Window) -> Callable[[], float | None]:
    def step() -> float | None:
        window.is_in_script = True
        try:
            return POLL_S if window.is_waiting() else next_step(session)
        except StopIteration:
            if missing := sorted(set(expected) - window.clicked):
                window.facts["error"] = f"never clicked: {missing}"
            finish(window)
        except Exception:  # noqa: BLE001  the test reads it
            window.facts["error"] = traceback.format_exc()
            finish(window)
        finally:
            window.is_in_script = False
        return None

    return step


def next_step(session: Iterator[float]) -> float:
    """Also after Blender has lost track of whether something is drawn (see ``addon/granted_writes.py``)."""
    from addon.granted_writes import grant  # noqa: PLC0415  after the path is set

    if not is_denied():
        return next(session)
    waits: list[float] = []
    grant(lambda: waits.append(next(session)))
    return waits[0]


def is_denied() -> bool:
    """Whether Blender takes writes for writes amid drawing."""
    try:
        del bpy.data.scenes[0]["nothing of this name"]
    except KeyError:
        pass
    except AttributeError:
        return True
    return False


def finish(window: Window) -> None:
    from addon.granted_writes import grant  # noqa: PLC0415  after the path is set

    was_denied = is_denied()

    def end() -> None:
        if was_denied:  # Blender would do it as it ends, and print an error for each
            addon_utils.disable_all()
        bpy.ops.wm.quit_blender()

    (window.folder / "facts.json").write_text(json.dumps(window.facts))
    grant(end)


@bpy.app.handlers.persistent
def draw_cheaply(*_: object) -> None:
    """On the CPU, each change would be drawn again for every sample of its smooth edges: most of a session's time.

    Factory settings that a session loads bring them back.
    """
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.system.viewport_aa = "OFF"
    bpy.context.preferences.system.use_overlay_smooth_wire = False


def main(session_path: str, folder: str) -> None:
    import addon  # noqa: PLC0415  after the path is set

    draw_cheaply()
    bpy.app.handlers.load_factory_preferences_post.append(draw_cheaply)
    window = Window(Path(folder))
    watch_operators(window)
    addon.register()
    spec = importlib.util.spec_from_file_location("session", session_path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    played = play(module.session(window), getattr(module, "CLICKS", ()), window)
    bpy.app.timers.register(played, first_interval=1.0, persistent=True)


if __name__ == "__main__":
    os.chdir(REPOSITORY)
    main(*sys.argv[sys.argv.index("--") + 1 :])
