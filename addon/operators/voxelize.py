# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects become voxels: a .tdag file, and an object that stands for it where they stood."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.types import Context, Event, Material, Object, Operator
from mathutils import Vector

from ..amounts import bytes_text, count_text, duration_text
from ..availability import why_no_render
from ..properties.voxels import channels_of
from ..voxel_boxes import EMISSION, add_own_material, add_voxel_box
from .files import beside_blend, kept_path, unused
from .fog_box import select_only
from .in_thread import InThread

if TYPE_CHECKING:
    from tyndall import Progress
    from tyndall.voxel_dag import Config, Estimate, Extent, FileHeader, VoxelDag

    from ..properties.voxels import TyndallVoxelizeSettings
    from ..sync.voxel_colours import Glow
    from ..sync.voxel_meshes import VoxelMesh

_DIALOG_WIDTH_PX = 360


@dataclass(frozen=True, kw_only=True, eq=False)
class _Prepared:
    """All that the work needs of Blender."""

    name: str
    origin: Vector  #: Of the new object, in the world.
    mesh: VoxelMesh
    channels: list[str]  #: What of materials was read for them.
    extent: Extent


@dataclass(frozen=True, kw_only=True)
class _Plan:
    """How what is asked for would be made."""

    says: str
    is_in_parts: bool = False  #: On disk, which takes no more memory than the budget.


class TYNDALL_OT_voxelize(InThread, Operator):
    """Make voxels of what is selected, or of a collection, write them to a file, and add an object that shows them.

    Modifiers and instances are applied. Says first what it would take. Beyond the memory it works in parts, on disk
    """

    bl_idname = "tyndall.voxelize"
    bl_label = "Voxelize to DAG"
    bl_options = {"REGISTER", "UNDO"}
    thread_name = "tyndall voxelize"
    _prepared: _Prepared | None = None

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_no_render()) is not None:
            cls.poll_message_set(reason)
        elif context.mode != "OBJECT":
            cls.poll_message_set("Works in Object Mode")
        else:
            return True
        return False

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if not self._read(context):
            return {"CANCELLED"}
        return context.window_manager.invoke_props_dialog(self, width=_DIALOG_WIDTH_PX)

    def check(self, _context: Context) -> bool:
        """Say anew what it would take, whatever is changed."""
        return True

    def draw(self, context: Context) -> None:
        from ..panels.base import draw_lines
        from ..panels.voxels import draw_settings

        settings = context.scene.tyndall.voxelize
        draw_settings(self.layout, settings)
        plan = _plan(self._prepared.extent, settings)
        draw_lines(self.layout, plan.says, _DIALOG_WIDTH_PX, "INFO")

    def execute(self, context: Context) -> set[str]:
        if self._prepared is None:  # a script
            return super().execute(context)
        return self.start(context) if self._settle(context) else {"CANCELLED"}

    def begin(self, context: Context) -> bool:
        return self._read(context) and self._settle(context)

    def _read(self, context: Context) -> bool:
        try:
            self._prepared = _prepared(context)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def _settle(self, context: Context) -> bool:
        """Decide how, and where the file goes. False, after a report: it cannot be done."""
        from tyndall.frame_files import require_writable

        settings = context.scene.tyndall.voxelize
        if not set(channels_of(settings)) <= set(self._prepared.channels) and not self._read(context):
            return False  # chosen in the dialog
        plan = _plan(self._prepared.extent, settings)
        try:
            self._path = _path_for(settings, self._prepared.name)
            require_writable(self._path.parent)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return False
        except OSError as error:
            self.report({"ERROR"}, f"{self._path.parent}: no folder to write to ({error.strerror})")
            return False
        self._config, self._hides_sources = _config(settings), settings.hides_sources
        self._is_in_parts = plan.is_in_parts
        self._carried = {
            "has_colors": settings.has_colors and not settings.is_solid,
            "has_normals": settings.has_normals and not settings.is_solid,
            "channels": channels_of(settings),
        }
        return True

    def work(self, progress: Progress) -> None:
        from tyndall import Cancelled
        from tyndall.voxel_dag import voxelize, write_voxels

        from ..sync.voxel_surfaces import surface_of

        def poll() -> None:
            if progress.is_cancelled:
                raise Cancelled

        mesh, resolution = self._prepared.mesh, self._config.resolution
        positions_m, triangles, fields = surface_of(mesh, resolution=resolution, poll=poll, **self._carried)
        config = replace(self._config, **fields)
        positions_m = positions_m - tuple(self._prepared.origin)
        made: FileHeader | VoxelDag
        if self._is_in_parts:
            made = write_voxels(positions_m, triangles, self._path, config, progress=progress)
        else:
            made = voxelize(positions_m, triangles, config, progress)
            made.save(self._path, progress)
        self._made = made

    def end(self, context: Context, error: BaseException | None) -> set[str]:
        from tyndall import Cancelled

        if isinstance(error, Cancelled):
            self.report(
                {"INFO"},
                "Stopped: the same again goes on from the parts that are finished, beside the file"
                if self._is_in_parts
                else "Stopped: nothing was written",
            )
            return {"CANCELLED"}
        if isinstance(error, (ValueError, OSError, MemoryError)):
            self.report({"ERROR"}, str(error) or "There is not enough memory: choose a lower resolution")
            return {"CANCELLED"}
        if error is not None:
            raise error
        prepared, made = self._prepared, self._made
        box = add_voxel_box(context, prepared.name, kept_path(self._path), made.bounds_m, prepared.origin)
        if made.has_colors:
            add_own_material(box, made.channels, _glow(prepared.mesh) if EMISSION in made.channels else None)
        elif (material := _first_material(context, prepared.mesh.sources)) is not None:
            box.data.materials.append(material)
        if self._hides_sources:
            _hide(context, prepared.mesh.sources)
        select_only(context, box)
        for line in prepared.mesh.reports.lines():
            self.report({"WARNING"}, line)
        taken = f"{count_text(made.voxel_count)} voxels in {bytes_text(made.geometry_bytes + made.attribute_bytes)}"
        self.report({"INFO"}, f"{self._path.name}: {taken}")
        return {"FINISHED"}


def _config(settings: TyndallVoxelizeSettings) -> Config:
    from tyndall.voxel_dag import Config

    return Config(
        resolution=int(settings.resolution),
        rule=settings.rule.lower(),
        symmetry=settings.symmetry.lower(),
        solid=settings.is_solid,
        most_color_difference=settings.color_difference or None,
        normal_bits=settings.normal_bits,
        memory_budget_bytes=settings.memory_budget_mib * 2**20 or None,
    )


def _prepared(context: Context) -> _Prepared:
    """Raises ValueError, which says what to choose or what is wrong with it."""
    from tyndall.voxel_dag import extent_of

    from ..sync.voxel_meshes import gather

    things, name = _chosen(context)
    if not things:
        raise ValueError("Select what becomes voxels, or choose a collection")
    channels = channels_of(context.scene.tyndall.voxelize)
    mesh = gather(context.evaluated_depsgraph_get(), things, channels=channels)
    active = context.view_layer.objects.active
    lowest, highest = Vector(mesh.positions_m.min(axis=0)), Vector(mesh.positions_m.max(axis=0))
    origin = active.matrix_world.translation.copy() if active in things else (lowest + highest) / 2.0
    return _Prepared(
        name=f"{name} Voxels",
        origin=origin,
        mesh=mesh,
        channels=channels,
        extent=extent_of(mesh.positions_m, mesh.triangles),
    )


def _chosen(context: Context) -> tuple[list[Object], str]:
    """What becomes voxels, and the name of it."""
    collection = context.scene.tyndall.voxelize.collection
    if collection is not None:
        return list(collection.all_objects), collection.name
    things = list(context.selected_objects)
    active = context.view_layer.objects.active
    named = active if active in things else things[0] if things else None
    return things, named.name if named is not None else ""


def _glow(mesh: VoxelMesh) -> Glow:
    """Of voxels with colours."""
    from ..sync.voxel_surfaces import glow_of

    return glow_of(mesh, has_colors=True)


def _plan(extent: Extent, settings: TyndallVoxelizeSettings) -> _Plan:
    """In memory where that suffices, else in parts."""
    from tyndall.voxel_dag import estimate, largest_that_fits

    config, attribute_bytes = _config(settings), _attribute_bytes(settings)
    wanted, fitting = estimate(extent, config, attribute_bytes), largest_that_fits(extent, config, attribute_bytes)
    if fitting is not None and fitting.resolution == config.resolution:
        return _Plan(says=_takes_text(wanted))
    budget = f"the budget is {settings.memory_budget_mib:,} MiB"
    parts = f"{budget}: it is made in parts, in a folder beside the file, and takes several times as long"
    return _Plan(says=f"{_takes_text(wanted)}; {parts}", is_in_parts=True)


def _attribute_bytes(settings: TyndallVoxelizeSettings) -> float:
    """Of a voxel, where no two are alike."""
    if settings.is_solid:
        return 0.0
    colours, normals = 3.0 * settings.has_colors, settings.normal_bits / 8.0 * settings.has_normals
    return float(colours + normals + len(channels_of(settings)))


def _takes_text(found: Estimate) -> str:
    return (
        f"Resolution {found.resolution:,}: about {count_text(found.voxel_count)} voxels, "
        f"{bytes_text(found.memory_bytes)} of memory, {duration_text(found.seconds)}, "
        f"a file of up to {bytes_text(found.file_bytes)}"
    )


def _path_for(settings: TyndallVoxelizeSettings, name: str) -> Path:
    """Raises ValueError where nobody has said where."""
    if settings.path:
        path = Path(bpy.path.abspath(settings.path))
        return path if path.suffix.lower() == ".tdag" else path.with_name(f"{path.name}.tdag")
    if not bpy.data.filepath:
        raise ValueError("Save the .blend first, or choose a file for the voxels")
    return unused(beside_blend(f"{bpy.path.clean_name(name)}.tdag"))


def _first_material(context: Context, names: list[str]) -> Material | None:
    """What renders draw voxels with: a box has one for all of them."""
    things = (context.view_layer.objects.get(name) for name in names)
    slots = (slot.material for thing in things if thing is not None for slot in thing.material_slots)
    return next((material for material in slots if material is not None), None)


def _hide(context: Context, names: list[str]) -> None:
    for name in names:
        if (thing := context.view_layer.objects.get(name)) is not None:
            thing.hide_set(True)
            thing.hide_render = True


CLASSES = (TYNDALL_OT_voxelize,)
