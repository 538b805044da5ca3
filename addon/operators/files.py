# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share that ask for a file."""

from __future__ import annotations

from itertools import chain, count
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Event


class Refusing:
    """Says why it does nothing."""

    def _refuse(self, reason: object) -> set[str]:
        self.report({"ERROR"}, str(reason))
        return {"CANCELLED"}


class FileOperator(Refusing):
    """Asks in Blender's file browser; a script gives ``filepath``. A class of it adds its ``filter_glob``."""

    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", description="Its path", subtype="FILE_PATH", options={"SKIP_SAVE"})

    def invoke(self, context: Context, _event: Event) -> set[str]:
        self.filepath = str(self._path(context))
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def default_path(self, context: Context) -> Path:
        """What is proposed, and taken where a script gives none."""
        raise NotImplementedError

    def _path(self, context: Context) -> Path:
        return Path(bpy.path.abspath(self.filepath)) if self.filepath else self.default_path(context)


def beside_blend(name: str) -> Path:
    """Of an unsaved file, in the folder that Blender runs in."""
    return Path(bpy.data.filepath).with_name(name) if bpy.data.filepath else Path(name).absolute()


def unused(path: Path) -> Path:
    """With a number if need be."""
    numbered = (path.with_stem(f"{path.stem}_{number:03d}") for number in count(2))
    return next(name for name in chain((path,), numbered) if not name.exists())


def kept_path(path: Path) -> str:
    """As a property keeps it: relative to a .blend that is saved."""
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path))
    except ValueError:  # on another drive
        return str(path)
