# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air, and what is painted in it, to OpenVDB files and back."""

from __future__ import annotations

from math import log
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty
from bpy.types import Context, Operator

from ..availability import why_no_render
from ..baked_air import baked_volume, new_baked_volume
from ..painted_air import VOLUMES, edited_box, local_from_unit, why_no_space, write_volume
from ..properties.painted_air import MOST_VOXELS
from .files import FileOperator, beside_blend, kept_path, unused
from .fog_box import fog_material
from .paint_air import PaintOperator

if TYPE_CHECKING:
    from bpy.types import Object, UILayout

    from tyndall.volumes import SparseGrid


#: What Blender 4.5 and 5.0 have read of a file stays until they end (measured: unloaded, removed, in a new .blend).
_KEEPS_WHAT_IT_READ = bpy.app.version >= (4, 0, 0)
_shown: set[Path] = set()


class _VolumeFileOperator(FileOperator):
    filter_glob: StringProperty(default="*.vdb", options={"HIDDEN"})

    def default_path(self, _context: Context) -> Path:
        return beside_blend(f"{Path(bpy.data.filepath).stem}_air.vdb" if bpy.data.filepath else "air.vdb")


class TYNDALL_OT_bake_air(_VolumeFileOperator, Operator):
    """Write the texture of the air inside the painted box, and what is painted, to an OpenVDB file for any program."""

    bl_idname = "tyndall.bake_air"
    bl_label = "Bake to File"

    check_existing: BoolProperty(default=True, options={"HIDDEN"})
    voxels: IntProperty(
        name="Resolution",
        description="Voxels of the baked texture along the longest side of the box; paint keeps its own",
        min=4,
        max=1024,
        default=192,
    )
    is_half: BoolProperty(
        name="Half Floats", description="Half the size of the file; 11 bits of each number stay", default=False
    )
    shows: BoolProperty(
        name="Add Volume",
        description="Show the file as a volume in the box: in Solid view, EEVEE, Cycles. Tyndall, which has this air "
        "already, leaves it out",
        default=True,
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_no_render() or _why_no_bake(context)) is not None:
            cls.poll_message_set(reason)
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        from tyndall.volumes import write_vdb

        box, path = edited_box(context), self._path(context)
        if path.suffix.lower() != ".vdb":
            path = path.with_name(f"{path.name}.vdb")
        try:
            grids = _grids(context, box, self.voxels)
            write_vdb(path, grids, is_half=self.is_half)
        except (ValueError, OSError) as error:
            return self._refuse(error)
        self.report({"INFO"}, f"{path.name}: {', '.join(grid.name for grid in grids)}")
        if self.shows:
            if _KEEPS_WHAT_IT_READ and path in _shown:
                self.report({"WARNING"}, f"Blender shows what it read of {path.name} before, until it is restarted")
            _show(box, path)
        return {"FINISHED"}

    def default_path(self, context: Context) -> Path:
        return unused(super().default_path(context))


def _why_no_bake(context: Context) -> str | None:
    """What the button says that bakes; None: it may."""
    settings, box = context.scene.tyndall.heterogeneity, edited_box(context)
    if box is None:
        return "Add a box to paint in first: it says where the air is baked"
    if settings.painted != box:
        return f'"{box.name}" is not the painted air of the scene'
    if not settings.is_enabled:
        return "There is nothing to bake: Texture the Air is off"
    return why_no_space(box)


def _sides_m(box: Object) -> list[float]:
    return [side.length for side in (box.matrix_world.to_3x3() @ local_from_unit(box).to_3x3()).col]


def _grids(context: Context, box: Object, voxels: int) -> list[SparseGrid]:
    from tyndall import InvalidInput, Progress
    from tyndall.air_files import baked_density, painted_grids

    from ..sync.heterogeneity import read_heterogeneity
    from ..sync.reports import Reports

    reports = Reports()
    heterogeneity = read_heterogeneity(context.evaluated_depsgraph_get(), reports)
    if heterogeneity is None or heterogeneity.painted is None:
        raise InvalidInput("; ".join(reports.lines()))
    sides_m = _sides_m(box)
    nx, ny, nz = (max(1, round(voxels * side_m / max(sides_m))) for side_m in sides_m)
    matrix = [list(row) for row in local_from_unit(box)]
    painted = painted_grids(heterogeneity.painted, tuple(box.tyndall.painted_air.resolution), matrix)
    return [baked_density(heterogeneity, (nx, ny, nz), matrix, Progress()), *painted]


def _show(box: Object, path: Path) -> None:
    """In a volume that is a child of the box."""
    thing = baked_volume(box)
    if thing is None:
        # Half of the light is lost on the way through the box, along its longest side.
        material = fog_material(density_per_m=log(2.0) / max(_sides_m(box)), asymmetry_g=0.0)
        material.name = "Baked Air"
        thing = new_baked_volume(box, material)
    volume = thing.data
    volume.filepath = ""
    volume.grids.load()  # nothing: Blender 3.4 forgets what it has read of a file that no volume shows
    bpy.context.view_layer.update()
    volume.filepath = kept_path(path)
    volume.grids.load()
    _shown.add(path)


class TYNDALL_OT_load_painted_air(PaintOperator, _VolumeFileOperator, Operator):
    """Read grids named amount, level and intensity of an OpenVDB file into the painted box, wherever they lie.

    What the file does not have stays as it is painted
    """

    bl_idname = "tyndall.load_painted_air"
    bl_label = "Load from File"

    takes_resolution: BoolProperty(
        name="Its Resolution",
        description="Give the box the file's voxels, where these fill a box like it; otherwise they are resampled",
        default=True,
    )

    def execute(self, context: Context) -> set[str]:
        from tyndall.air_files import painted_values, resolution_of
        from tyndall.volumes import grid_infos, read_vdb

        box, path = edited_box(context), self._path(context)
        matrix = [list(row) for row in local_from_unit(box)]
        settings = box.tyndall.painted_air
        try:
            there = [info.name for info in grid_infos(path)]
            names = [name for name in VOLUMES if name in there]
            if not names:
                listed = ", ".join(f'"{name}"' for name in there) or "no grid at all"
                return self._refuse(f'{path}: it has no grid "amount", "level" or "intensity"; it has {listed}')
            grids = read_vdb(path, names)
            resolution = resolution_of(grids[names[0]], matrix) if self.takes_resolution else None
            if resolution is None or max(resolution) > MOST_VOXELS:
                resolution = tuple(settings.resolution)
            painted = {name: painted_values(grids[name], resolution, matrix) for name in names}
        except (ValueError, OSError) as error:
            return self._refuse(error)
        settings.resolution = resolution
        for name, values in painted.items():
            write_volume(box, name, values)
        self.report({"INFO"}, f"{path.name}: {', '.join(names)}")
        return {"FINISHED"}


def draw_buttons(layout: UILayout) -> None:
    """To a file and back."""
    row = layout.row(align=True)
    row.operator("tyndall.bake_air")
    row.operator("tyndall.load_painted_air")


CLASSES = (TYNDALL_OT_bake_air, TYNDALL_OT_load_painted_air)
