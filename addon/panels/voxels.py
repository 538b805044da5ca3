# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxels, in the 3D view's sidebar: make them, what shows of them, and what they take."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from bpy.types import Context, Menu, Panel, TOPBAR_MT_file_import, UILayout

from ..amounts import bytes_text, count_text
from ..properties.voxels import CHANNELS, TyndallVoxelizeSettings
from ..voxel_boxes import file_of, is_voxel_box
from ..voxel_reading import header_of, levels_of
from .base import SidebarPanel, draw_text, draw_value, is_wide_region

if TYPE_CHECKING:
    from tyndall.voxel_dag import FileHeader

_Read = TypeVar("_Read")

#: Of an octree without sharing, in the smallest of the usual layouts: a child mask and an offset.
OCTREE_BYTES_PER_NODE = 4
_LONGEST_BAR = 24
_NAME_SHARE = 0.42  #: Of a narrow row.


class VoxelPanel(SidebarPanel):
    bl_category = "Voxels"


class TYNDALL_PT_voxelize(VoxelPanel, Panel):
    bl_label = "Voxelize"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = is_wide = is_wide_region(context)
        draw_settings(layout, context.scene.tyndall.voxelize, is_narrow=not is_wide)
        layout.operator("tyndall.voxelize", icon="MESH_GRID")
        row = layout.row(align=True)
        row.operator("tyndall.import_tdag", text=".tdag", icon="IMPORT")
        row.operator("tyndall.import_vox", text=".vox", icon="IMPORT")


def draw_settings(layout: UILayout, settings: TyndallVoxelizeSettings, *, is_narrow: bool = False) -> None:
    """``is_narrow``: a region that would cut names off, if values had the usual share of it."""
    column = layout.column()

    def draw(name: str) -> None:
        if not is_narrow:
            column.prop(settings, name)
            return
        row = column.split(factor=_NAME_SHARE)
        row.label(text=settings.bl_rna.properties[name].name)
        row.prop(settings, name, text="")

    for name in ("collection", "resolution", "rule"):
        draw(name)
    column.prop(settings, "is_solid")
    if not settings.is_solid:
        for kept, how in (("has_colors", "color_difference"), ("has_normals", "normal_bits")):
            column.prop(settings, kept)
            if getattr(settings, kept):
                draw(how)
        column.label(text="Channels")
        grid = column.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        grid.use_property_split = False
        for name in CHANNELS:
            grid.prop(settings, f"has_{name}", toggle=True)
    for name in ("symmetry", "memory_budget_mib", "path"):
        draw(name)
    column.prop(settings, "hides_sources")


class _BoxPanel(VoxelPanel):
    """Of the active object's file."""

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and is_voxel_box(context.object)


class TYNDALL_PT_voxel_box(_BoxPanel, Panel):
    bl_label = "Voxel Object"

    def draw(self, context: Context) -> None:
        layout = self.layout
        settings = context.object.tyndall_voxels
        row = layout.row(align=True)
        row.prop(settings, "path", text="")
        row.operator("tyndall.reload_voxels", text="", icon="FILE_REFRESH")
        column = layout.column(align=True)
        column.row(align=True).prop(settings, "preview", expand=True)
        row = column.row()
        row.active = settings.preview != "NONE"
        row.prop(settings, "preview_level")
        if (header := _header(context, layout)) is not None:
            column = layout.column(align=True)
            draw_value(column, context, "Resolution", f"{header.resolution:,}")
            draw_value(column, context, "Voxels", count_text(header.voxel_count))
            draw_value(column, context, "Distinct nodes", count_text(header.node_count))


class TYNDALL_PT_voxel_exports(_BoxPanel, Panel):
    bl_label = "Export"
    bl_parent_id = "TYNDALL_PT_voxel_box"

    def draw(self, context: Context) -> None:
        row = self.layout.row(align=True)
        row.operator("tyndall.voxels_to_mesh", text="Mesh", icon="MESH_DATA")
        row.operator("tyndall.export_voxels_vdb", text=".vdb", icon="EXPORT")
        row.operator("tyndall.export_voxels_vox", text=".vox", icon="EXPORT")


class TYNDALL_PT_voxel_bytes(_BoxPanel, Panel):
    bl_label = "Size"
    bl_parent_id = "TYNDALL_PT_voxel_box"

    def draw(self, context: Context) -> None:
        column = self.layout.column(align=True)
        if (header := _header(context, column)) is None:
            return
        for name, part in header.bytes_by_part.items():
            draw_value(column, context, name.replace("_", " "), bytes_text(part))
        draw_value(column, context, "All", bytes_text(sum(header.bytes_by_part.values())))
        draw_value(
            column,
            context,
            "Raw, a bit per voxel of the cube",
            f"{header.resolution**3 / 8 / header.geometry_bytes:.3g} x",
        )


class TYNDALL_PT_voxel_levels(_BoxPanel, Panel):
    """Closed until it is asked for: counting reads all of the geometry."""

    bl_label = "Levels"
    bl_parent_id = "TYNDALL_PT_voxel_box"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        column = self.layout.column(align=True)
        levels = _found(context, column, levels_of(file_of(context.object)))
        if levels is None or (header := _header(context, column)) is None:
            return
        column.label(text="Side: distinct nodes, of those of an octree")
        longest = max((level.node_count for level in levels), default=1)
        for level in reversed(levels[1:]):
            row = column.split(factor=0.15)
            row.label(text=f"{level.side:,}")
            row = row.split(factor=0.35)
            row.label(text="|" * max(1, round(_LONGEST_BAR * level.node_count / longest)))
            row.label(text=f"{count_text(level.node_count)} of {count_text(level.tree_node_count)}")
        octree = OCTREE_BYTES_PER_NODE * sum(level.tree_node_count for level in levels)
        draw_value(
            column,
            context,
            f"An octree, {OCTREE_BYTES_PER_NODE} bytes per node",
            f"{octree / header.geometry_bytes:.3g} x",
        )


def _header(context: Context, layout: UILayout) -> FileHeader | None:
    """None, after a line that says why."""
    return _found(context, layout, header_of(file_of(context.object)))


def _found(context: Context, layout: UILayout, read: _Read | Exception | None) -> _Read | None:
    if read is not None and not isinstance(read, Exception):
        return read
    draw_text(layout, context, "Reading the file" if read is None else str(read), icon="ERROR" if read else "TIME")
    return None


def draw_import(menu: Menu, _context: Context) -> None:
    """In File > Import."""
    menu.layout.operator("tyndall.import_tdag", text="Voxel DAG (.tdag)")
    menu.layout.operator("tyndall.import_vox", text="MagicaVoxel (.vox)")


def register() -> None:
    TOPBAR_MT_file_import.append(draw_import)


def unregister() -> None:
    TOPBAR_MT_file_import.remove(draw_import)


SIDEBAR_CLASSES = (
    TYNDALL_PT_voxelize,
    TYNDALL_PT_voxel_box,
    TYNDALL_PT_voxel_exports,
    TYNDALL_PT_voxel_bytes,
    TYNDALL_PT_voxel_levels,
)
