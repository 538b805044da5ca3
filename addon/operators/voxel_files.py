# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of voxels: into the scene as objects that stand for them, and read anew."""

from __future__ import annotations

from pathlib import Path

from bpy.props import StringProperty
from bpy.types import Context, Operator

from ..availability import why_no_render
from ..voxel_boxes import add_voxel_box, file_of, fit_box, is_voxel_box
from ..voxel_reading import forget
from .files import FileOperator, beside_blend, kept_path
from .fog_box import select_only


class _VoxelOperator:
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_no_render() or cls.why_not(context)) is not None:
            cls.poll_message_set(reason)
            return False
        return True

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        """What the button says that cannot be pressed; None: it may."""
        return None if context.mode == "OBJECT" else "Works in Object Mode"


class TYNDALL_OT_import_tdag(_VoxelOperator, FileOperator, Operator):
    """Add an object that stands for the voxels of a .tdag file, which stays where it is."""

    bl_idname = "tyndall.import_tdag"
    bl_label = "Import Voxels (.tdag)"

    filter_glob: StringProperty(default="*.tdag", options={"HIDDEN"})

    def default_path(self, context: Context) -> Path:
        """The newest beside the .blend."""
        other = beside_blend("voxels.tdag")
        return max(other.parent.glob("*.tdag"), key=lambda path: path.stat().st_mtime_ns, default=other)

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import load

        path = self._path(context)
        try:
            bounds_m = load(path).bounds_m
        except OSError as error:
            return self._refuse(error)
        forget(path)
        select_only(context, add_voxel_box(context, path.stem, kept_path(path), bounds_m, (0.0, 0.0, 0.0)))
        return {"FINISHED"}


class TYNDALL_OT_reload_voxels(_VoxelOperator, Operator):
    """Read the active object's file again, and make its box the file's."""

    bl_idname = "tyndall.reload_voxels"
    bl_label = "Reload Voxels"

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        if not is_voxel_box(context.object):
            return "The active object has no file of voxels"
        if context.object.type != "MESH" or context.object.data.library is not None:
            return "The box is linked: make a library override of it first"
        return super().why_not(context)

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import load

        box = context.object
        path = file_of(box)
        forget(path)
        try:
            bounds_m = load(path).bounds_m
        except OSError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        fit_box(box.data, bounds_m)
        box.tyndall_voxels.path = box.tyndall_voxels.path  # who draws it learns of it
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_import_tdag, TYNDALL_OT_reload_voxels)
