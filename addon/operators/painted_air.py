# SPDX-License-Identifier: GPL-3.0-or-later
"""The box that is painted in: add it, and change all of a volume at once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, IntVectorProperty
from bpy.types import Context, Operator

from ..air_strokes import volume_to_paint
from ..painted_air import VOLUMES as VOLUME_NAMES
from ..painted_air import edited_box, read_volume, write_volume
from ..properties.painted_air import MOST_VOXELS
from ..shader_nodes import is_medium_only
from .fog_box import box_bounds_m, enclosed_points, select_only
from .paint_air import PaintOperator

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bpy.types import Depsgraph
    from mathutils import Vector

#: A first brush is so much smaller than the box.
_BRUSHES_ALONG_BOX = 12.0
_AXES = (("X", "X", "Along the box's own x", 0), ("Y", "Y", "Its y", 1), ("Z", "Z", "Its z", 2))


class TYNDALL_OT_add_painted_box(Operator):
    """Add a box to paint the air in: around the fog, or, without any, around the scene."""

    bl_idname = "tyndall.add_painted_box"
    bl_label = "Add Box to Paint In"
    bl_options = {"REGISTER", "UNDO"}

    voxels: IntProperty(
        name="Resolution",
        description="Voxels along the longest side; the others have as many as make them cubes",
        min=4,
        max=MOST_VOXELS,
        default=96,
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Works in Object Mode")
        elif context.scene.library is not None:
            cls.poll_message_set("The scene is linked: make a library override of it first")
        else:
            return True
        return False

    def execute(self, context: Context) -> set[str]:
        depsgraph = context.evaluated_depsgraph_get()
        corners = list(_corners_of_fog(depsgraph))
        if corners:
            lowest, highest = box_bounds_m(iter(corners), 0.0)
        else:
            lowest, highest = box_bounds_m(enclosed_points(depsgraph, with_camera_and_lights=False), 0.05)
        box = bpy.data.objects.new("Painted Air", None)
        box.empty_display_type, box.empty_display_size = "CUBE", 1.0
        box.location, box.scale = (lowest + highest) / 2.0, (highest - lowest) / 2.0
        context.collection.objects.link(box)
        sides_m = (highest - lowest).to_tuple()
        longest_m = max(sides_m)
        box.tyndall.painted_air.resolution = [max(1, round(self.voxels * side_m / longest_m)) for side_m in sides_m]
        select_only(context, box)
        texture = context.scene.tyndall.heterogeneity
        texture.painted, texture.is_enabled = box, True
        context.scene.tyndall.air_brush.radius_m = longest_m / _BRUSHES_ALONG_BOX
        context.view_layer.update()  # a script may paint at once: the box is where it is
        return {"FINISHED"}


def _corners_of_fog(depsgraph: Depsgraph) -> Iterator[Vector]:
    """In the world, of all objects that are media without a surface."""
    from mathutils import Vector as Point

    for instance in depsgraph.object_instances:
        if instance.object.type == "MESH" and instance.show_self and is_medium_only(instance.object):
            matrix = instance.matrix_world.copy()
            yield from (matrix @ Point(corner) for corner in instance.object.bound_box)


class _VolumeOperator(PaintOperator):
    """Works on the volume that the brush paints, or on all three."""

    bl_options = {"REGISTER", "UNDO"}


def _painted_name(context: Context) -> str:
    return str(context.scene.tyndall.air_brush.volume.lower())


class TYNDALL_OT_painted_air_fill(_VolumeOperator, Operator):
    """Set the whole volume to the brush's value."""

    bl_idname = "tyndall.painted_air_fill"
    bl_label = "Fill"

    opacity: FloatProperty(
        name="Opacity", description="How much of the value", subtype="FACTOR", min=0.0, max=1.0, default=1.0
    )

    def execute(self, context: Context) -> set[str]:
        box, name = edited_box(context), _painted_name(context)
        value = getattr(context.scene.tyndall.air_brush, name)
        try:
            values = volume_to_paint(box, name)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        write_volume(box, name, (1.0 - self.opacity) * values + self.opacity * value)
        return {"FINISHED"}


class TYNDALL_OT_painted_air_clear(_VolumeOperator, Operator):
    """Take all paint out of the volume."""

    bl_idname = "tyndall.painted_air_clear"
    bl_label = "Clear"

    takes_all: BoolProperty(name="All Volumes", description="Of the others, too", default=False)

    def execute(self, context: Context) -> set[str]:
        for name in VOLUME_NAMES if self.takes_all else (_painted_name(context),):
            write_volume(edited_box(context), name, None)
        return {"FINISHED"}


class TYNDALL_OT_painted_air_flip(_VolumeOperator, Operator):
    """Mirror what is painted, in all volumes, along an axis of the box."""

    bl_idname = "tyndall.painted_air_flip"
    bl_label = "Flip"

    axis: EnumProperty(name="Axis", description="Of the box", items=_AXES, default="X")

    def execute(self, context: Context) -> set[str]:
        import numpy as np

        box, axis = edited_box(context), 2 - "XYZ".index(self.axis)
        try:
            volumes = {name: read_volume(box, name) for name in VOLUME_NAMES}
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for name, values in volumes.items():
            if values is not None:
                write_volume(box, name, np.ascontiguousarray(np.flip(values, axis)))
        return {"FINISHED"}


class TYNDALL_OT_painted_air_resample(_VolumeOperator, Operator):
    """Give the box another resolution, and keep what is painted in it."""

    bl_idname = "tyndall.painted_air_resample"
    bl_label = "Resample"

    resolution: IntVectorProperty(
        name="Resolution",
        description="Voxels along the sides of the box",
        subtype="XYZ",
        size=3,
        min=1,
        max=MOST_VOXELS,
        default=(64, 64, 64),
    )

    def invoke(self, context: Context, _event: object) -> set[str]:
        self.resolution = edited_box(context).tyndall.painted_air.resolution
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, _context: Context) -> None:
        self.layout.prop(self, "resolution")
        self.layout.label(text=memory_text(self.resolution), icon="INFO")

    def execute(self, context: Context) -> set[str]:
        box = edited_box(context)
        box.tyndall.painted_air.resolution = self.resolution
        try:
            painted = {name: read_volume(box, name) for name in VOLUME_NAMES}
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for name, values in painted.items():
            write_volume(box, name, values)
        self.report({"INFO"}, memory_text(self.resolution))
        return {"FINISHED"}


class TYNDALL_OT_painted_air_bake(_VolumeOperator, Operator):
    """Bake the noise and all three volumes into the intensity, as they are at this frame.

    Inside the box the air then stands still: wind, amount and softness change nothing there, the scene's intensity
    does. Noise finer than the voxels is lost; the rest is exact at their centres and linear between them
    """

    bl_idname = "tyndall.painted_air_bake"
    bl_label = "Bake into Intensity"

    def execute(self, context: Context) -> set[str]:
        import numpy as np

        from tyndall import InvalidInput, Progress
        from tyndall.baked_air import bake_air

        from ..sync.heterogeneity import read_heterogeneity
        from ..sync.reports import Reports

        box, reports = edited_box(context), Reports()
        heterogeneity = read_heterogeneity(context.evaluated_depsgraph_get(), reports)
        reason = "; ".join(reports.lines())
        if heterogeneity is None:
            reason = "There is nothing to bake: Texture the Air is off"
        elif context.scene.tyndall.heterogeneity.painted != box:
            reason = f'"{box.name}" is not the painted air of the scene'
        if reason:
            self.report({"ERROR"}, reason)
            return {"CANCELLED"}
        nx, ny, nz = box.tyndall.painted_air.resolution
        try:
            baked = bake_air(heterogeneity, (nx, ny, nz), Progress())
        except InvalidInput as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        write_volume(box, "intensity", baked)
        write_volume(box, "amount", np.full_like(baked, -1.0))
        write_volume(box, "level", None)
        return {"FINISHED"}


def memory_text(resolution: tuple[int, int, int]) -> str:
    """What a volume takes in memory while it is painted or rendered; a .blend has only what is painted."""
    nx, ny, nz = resolution
    kibibytes = nx * ny * nz * 4 / 2**10
    size = f"{kibibytes / 2**10:.3g} MiB" if kibibytes >= 2**10 else f"{math.ceil(kibibytes)} KiB"
    return f"{size} per painted volume"


CLASSES = (
    TYNDALL_OT_add_painted_box,
    TYNDALL_OT_painted_air_fill,
    TYNDALL_OT_painted_air_clear,
    TYNDALL_OT_painted_air_flip,
    TYNDALL_OT_painted_air_resample,
    TYNDALL_OT_painted_air_bake,
)
