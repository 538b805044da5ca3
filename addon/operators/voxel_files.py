# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of voxels: into the scene as objects that stand for them, and read anew."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import FloatProperty, StringProperty
from bpy.types import Context, Operator

from ..amounts import count_text
from ..availability import why_no_render
from ..voxel_boxes import add_own_material, add_voxel_box, file_of, fit_box, is_voxel_box
from ..voxel_reading import forget
from .files import FileOperator, Refusing, beside_blend, kept_path, unused
from .fog_box import select_only


def newest(pattern: str) -> Path:
    """Of the files beside the .blend; a name like theirs, where there is none."""
    other = beside_blend(pattern.replace("*", "voxels"))
    return max(other.parent.glob(pattern), key=lambda path: path.stat().st_mtime_ns, default=other)


class _VoxelOperator(Refusing):
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


class BoxOperator(_VoxelOperator):
    """Of the active object's voxels."""

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        return super().why_not(context) if is_voxel_box(context.object) else "The active object has no file of voxels"


class TYNDALL_OT_import_tdag(_VoxelOperator, FileOperator, Operator):
    """Add an object that stands for the voxels of a .tdag file, which stays where it is."""

    bl_idname = "tyndall.import_tdag"
    bl_label = "Import Voxels (.tdag)"

    filter_glob: StringProperty(default="*.tdag", options={"HIDDEN"})

    def default_path(self, context: Context) -> Path:
        return newest("*.tdag")

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import checked_header

        path = self._path(context)
        try:
            header = checked_header(path)
        except OSError as error:
            return self._refuse(error)
        forget(path)
        box = add_voxel_box(context, path.stem, kept_path(path), header.bounds_m, (0.0, 0.0, 0.0))
        if header.has_colors:
            add_own_material(box, header.channels)
        select_only(context, box)
        return {"FINISHED"}


class TYNDALL_OT_import_vox(_VoxelOperator, FileOperator, Operator):
    """Make a .tdag file of all models of a MagicaVoxel file, with their colours, and add an object that shows it."""

    bl_idname = "tyndall.import_vox"
    bl_label = "Import MagicaVoxel (.vox)"

    filter_glob: StringProperty(default="*.vox", options={"HIDDEN"})
    voxel_size_m: FloatProperty(
        name="Voxel Size", description="Side of a voxel", subtype="DISTANCE", min=1e-6, max=1e3, default=0.1
    )

    def default_path(self, context: Context) -> Path:
        return newest("*.vox")

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import import_vox

        source = self._path(context)
        beside = Path(bpy.data.filepath) if bpy.data.filepath else source
        path = unused(beside.with_name(f"{source.stem}.tdag"))
        try:
            dag = import_vox(source, voxel_size_m=self.voxel_size_m)
            dag.save(path)
        except (ValueError, OSError) as error:
            return self._refuse(error)
        box = add_voxel_box(context, source.stem, kept_path(path), dag.bounds_m, (0.0, 0.0, 0.0))
        add_own_material(box, dag.channels)
        select_only(context, box)
        self.report({"INFO"}, f"{path.name}: {count_text(dag.voxel_count)} voxels")
        return {"FINISHED"}


class TYNDALL_OT_reload_voxels(BoxOperator, Operator):
    """Read the active object's file again, and make its box the file's."""

    bl_idname = "tyndall.reload_voxels"
    bl_label = "Reload Voxels"

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        if (reason := super().why_not(context)) is not None:
            return reason
        if context.object.type != "MESH" or context.object.data.library is not None:
            return "Its box is no mesh of this file"
        return None

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import checked_header

        box = context.object
        path = file_of(box)
        forget(path)
        try:
            header = checked_header(path)
        except OSError as error:
            return self._refuse(error)
        fit_box(box.data, header.bounds_m)
        box.tyndall_voxels.path = box.tyndall_voxels.path  # who draws it learns of it
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_import_tdag, TYNDALL_OT_import_vox, TYNDALL_OT_reload_voxels)
