# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels as meshes, and as the files of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import Context, Event, Operator

from ..amounts import count_text
from ..properties.voxels import LEAST_LEVEL, MOST_LEVEL
from ..voxel_boxes import file_of
from .files import FileOperator, unused
from .fog_box import select_only
from .voxel_files import BoxOperator

MESHES = (
    ("BOXES", "Boxes", "The faces of the cubes, exactly", 0),
    ("SMOOTH", "Smooth", "A rounded surface around them, by OpenVDB", 1),
)
GRIDS = (
    ("FOG", "Fog", "A density of 1 where a voxel is", 0),
    ("LEVEL SET", "Level Set", "Distances to the surface of the voxels, negative within", 1),
)


class _Leveled:
    """What may be coarser than the voxels; a click begins with the level of the preview."""

    level: IntProperty(
        name="Level",
        description="2^level cubes along a side, at most as many as there are voxels",
        min=LEAST_LEVEL,
        max=MOST_LEVEL,
        default=MOST_LEVEL,
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: Context, event: Event) -> Any:  # noqa: ANN401  of the class beside
        self.level = max(LEAST_LEVEL, context.object.tyndall_voxels.preview_level)
        return super().invoke(context, event)

    def _level(self, resolution: int) -> int:
        return min(resolution.bit_length() - 1, int(self.level))


class _AtOnce:
    def invoke(self, context: Context, _event: Event) -> Any:  # noqa: ANN401  of the class beside
        return self.execute(context)


class TYNDALL_OT_voxels_to_mesh(BoxOperator, _Leveled, _AtOnce, Operator):
    """Add a mesh of the active object's voxels, where they are. It has no limit but memory: begin with a low level."""

    bl_idname = "tyndall.voxels_to_mesh"
    bl_label = "Voxels to Mesh"

    kind: EnumProperty(name="Kind", description="What stands for a cube", items=MESHES, default="BOXES")

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import load

        from ..triangle_meshes import triangle_mesh

        box = context.object
        try:
            dag = load(file_of(box))
            level, are_boxes = self._level(dag.resolution), self.kind == "BOXES"
            made = dag.to_mesh(self.kind.lower(), level=level)
            channels = dag.box_channels(made, level=level) if are_boxes else {}
        except (ValueError, OSError) as error:
            return self._refuse(error)
        if len(made.triangles) == 0:
            return self._refuse(f"{file_of(box).name} has no voxels")
        data = triangle_mesh(
            f"{box.name} Mesh",
            made.positions_m,
            made.triangles,
            made.colors,
            is_smooth=not are_boxes,
            channels=channels,
        )
        for material in box.data.materials:
            data.materials.append(material)
        thing = bpy.data.objects.new(data.name, data)
        thing.matrix_world = box.matrix_world
        context.collection.objects.link(thing)
        select_only(context, thing)
        self.report({"INFO"}, f"{count_text(len(made.triangles))} triangles")
        return {"FINISHED"}


class _ExportOperator(BoxOperator, FileOperator):
    bl_options = {"REGISTER"}

    check_existing: BoolProperty(default=True, options={"HIDDEN"})
    suffix = ""

    def default_path(self, context: Context) -> Path:
        return unused(file_of(context.object).with_suffix(self.suffix))

    def _target(self, context: Context) -> Path:
        path = self._path(context)
        return path if path.suffix.lower() == self.suffix else path.with_name(f"{path.name}{self.suffix}")


class TYNDALL_OT_export_voxels_vdb(_Leveled, _ExportOperator, Operator):
    """Write the active object's voxels as a grid of an OpenVDB file, in the object's own space."""

    bl_idname = "tyndall.export_voxels_vdb"
    bl_label = "To OpenVDB"
    suffix = ".vdb"

    filter_glob: StringProperty(default="*.vdb", options={"HIDDEN"})
    kind: EnumProperty(name="Grid", description="What the grid says", items=GRIDS, default="FOG")

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import load

        path = self._target(context)
        try:
            dag = load(file_of(context.object))
            dag.to_vdb(path, self.kind.lower(), level=self._level(dag.resolution))
        except (ValueError, OSError) as error:
            return self._refuse(error)
        self.report({"INFO"}, f"{path.name} is written")
        return {"FINISHED"}


class TYNDALL_OT_export_voxels_vox(_ExportOperator, Operator):
    """Write the active object's voxels, all of them, with their colours, as models of a MagicaVoxel file."""

    bl_idname = "tyndall.export_voxels_vox"
    bl_label = "To MagicaVoxel"
    suffix = ".vox"

    filter_glob: StringProperty(default="*.vox", options={"HIDDEN"})
    quantize: BoolProperty(
        name="Fewer Colours",
        description="Write those of a palette of 255 where there are more. Off: more are refused",
        default=True,
    )

    def execute(self, context: Context) -> set[str]:
        from tyndall.voxel_dag import load

        path = self._target(context)
        try:
            load(file_of(context.object)).to_vox(path, quantize=self.quantize)
        except (ValueError, OSError) as error:
            return self._refuse(error)
        self.report({"INFO"}, f"{path.name} is written")
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_voxels_to_mesh, TYNDALL_OT_export_voxels_vdb, TYNDALL_OT_export_voxels_vox)
