# SPDX-License-Identifier: GPL-3.0-or-later
"""How an error of a render reaches its caller: Blender alone would save an empty picture and report success.

``report`` makes ``bpy.ops.render.render`` raise RuntimeError, ``error_set`` shows the message in the render window. A
render that was asked for on Blender's command line (-f, -a) has neither caller nor window: there the process ends with
exit status 1.
"""

from __future__ import annotations

import atexit
import os
import sys
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from bpy.types import RenderEngine

_RENDER_ARGUMENTS = {"-f", "--render-frame", "-a", "--render-anim"}
INTERRUPTED = "Tyndall: interrupted"
_last_error: str | None = None


def last_error() -> str | None:
    """What went wrong in the latest final render; None if it succeeded or was cancelled."""
    return _last_error


def clear() -> None:
    global _last_error  # noqa: PLW0603  one process renders one frame at a time
    _last_error = None


def fail(engine: RenderEngine, message: str) -> None:
    """Call after the frame was delivered: before, saving an EXR is a segmentation fault."""
    global _last_error  # noqa: PLW0603
    _last_error = message
    engine.report({"ERROR"}, message)
    engine.error_set(message)
    if _renders_from_command_line():
        atexit.unregister(_exit_with_failure)
        atexit.register(_exit_with_failure)


def _renders_from_command_line() -> bool:
    arguments = sys.argv[: sys.argv.index("--")] if "--" in sys.argv else sys.argv
    return bpy.app.background and not getattr(bpy.app, "module", False) and bool(_RENDER_ARGUMENTS & set(arguments))


def _exit_with_failure() -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(1)
