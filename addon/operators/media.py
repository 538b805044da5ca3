# SPDX-License-Identifier: GPL-3.0-or-later
"""Find what holds a medium: a fog box is drawn as wires, and easily missed."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Object, Operator

from ..scene_media import objects_of
from .fog_box import select_only


class TYNDALL_OT_select_medium(Operator):
    """Select the objects that hold this medium; the first of them becomes the active one."""

    bl_idname = "tyndall.select_medium"
    bl_label = "Select Medium"
    bl_options = {"REGISTER", "UNDO"}

    material_name: StringProperty(name="Material", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Works in Object Mode")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        material = bpy.data.materials.get(self.material_name)
        holders: list[Object] = objects_of(context.scene, material) if material is not None else []
        shown = [thing for thing in holders if thing.visible_get(view_layer=context.view_layer)]
        if not shown:
            why = "what holds it is hidden" if holders else "nothing in this scene has it"
            self.report({"ERROR"}, f'Nothing to select for "{self.material_name}": {why}')
            return {"CANCELLED"}
        select_only(context, *shown)
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_select_medium,)
