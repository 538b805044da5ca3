# SPDX-License-Identifier: GPL-3.0-or-later
"""The seam to Blender, the only part of this package that knows ``bpy``: makes the one add-on available to scripts.

import bpy, tyndall.blender
tyndall.blender.enable()
bpy.context.scene.render.engine = "TYNDALL"
bpy.ops.render.render(write_still=True)  # raises RuntimeError if the render fails
"""

from __future__ import annotations

import atexit
import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy

_ADDON = "tyndall.blender.addon"
ENGINE = "TYNDALL"


def enable() -> None:
    """Register the engine, unless some copy of the add-on has done so already.

    Raises RuntimeError that says why, where the native core does not load. The engine is unregistered when Python ends:
    one that is left over makes bpy 4.2 crash and bpy 4.5 hang.
    """
    addon = _registered_addon()
    if addon is None:
        addon = _import_addon()
        addon.register()
        atexit.register(disable)
    why_not = importlib.import_module(".availability", addon.__name__).why_not()
    if why_not is not None:
        raise RuntimeError(f"Tyndall cannot render: {why_not}")


def disable() -> None:
    """Unregister what ``enable`` registered; does nothing if it did not."""
    atexit.unregister(disable)
    addon = sys.modules.get(_ADDON)
    if addon is not None and _registered_addon() is addon:
        addon.unregister()


def last_error() -> str | None:
    """What went wrong in the latest final render; None if it succeeded or was cancelled."""
    error: str | None = _part(".engine.failures").last_error()
    return error


def was_interrupted() -> bool:
    """Whether the latest final render ended by Ctrl-C."""
    failures = _part(".engine.failures")
    return bool(failures.last_error() == failures.INTERRUPTED)


def last_statistics(scene_name: str) -> dict[str, Any] | None:
    """Stages, counts, reports and what was skipped, of the scene's latest final render; for JSON. None before one."""
    statistics: dict[str, Any] | None = _part(".last_render").statistics_of(scene_name)
    return statistics


def version() -> str:
    """Blender's, such as "4.5.15"."""
    return str(bpy.app.version_string)


def film_parts() -> ModuleType:
    """How parts of frames leave the engine and come back: its module ``film_parts``."""
    return _part(".engine.film_parts")


def _part(name: str) -> ModuleType:
    addon = _registered_addon()
    if addon is None:
        raise RuntimeError("Tyndall is not registered: call tyndall.blender.enable() first")
    return importlib.import_module(name, addon.__name__)


def _registered_addon() -> ModuleType | None:
    """The package of the engine that Blender knows: ours, an installed add-on or an extension."""
    for engine in bpy.types.RenderEngine.__subclasses__():
        if getattr(engine, "bl_idname", "") == ENGINE and getattr(engine, "is_registered", False):
            # a class of <package>.engine, or of <package>.unavailable_engine
            return sys.modules[engine.__module__.rpartition(".")[0]]
    return None


def _import_addon() -> ModuleType:
    """The wheel carries the add-on as ``tyndall.blender.addon``; in a source tree it lies beside ``python/``."""
    if importlib.util.find_spec(_ADDON) is not None:
        return importlib.import_module(_ADDON)
    folder = Path(__file__).parents[3] / "addon"
    spec = importlib.util.spec_from_file_location(
        _ADDON, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    if spec is None or spec.loader is None or not (folder / "__init__.py").is_file():
        raise RuntimeError(f"the add-on is neither in the package nor in {folder}")
    addon = importlib.util.module_from_spec(spec)
    sys.modules[_ADDON] = addon
    spec.loader.exec_module(addon)
    return addon
