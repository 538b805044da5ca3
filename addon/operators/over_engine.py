# SPDX-License-Identifier: GPL-3.0-or-later
"""Lay light shafts over the picture of the scene's engine, and take them away again; leave its fog to them."""

from __future__ import annotations

from bpy.types import Context, Operator

from .. import over_engine
from ..over_engine import fog


class TYNDALL_OT_over_engine_set_up(Operator):
    """Render with this scene's engine, and lay Tyndall's light shafts over its picture in the compositor.

    Adds two nodes before the output and leaves all others; where some of it is missing, mends it
    """

    bl_idname = "tyndall.over_engine_set_up"
    bl_label = "Set Up Light Shafts over This Engine"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := over_engine.why_not(context.scene)) is not None:
            cls.poll_message_set(reason)
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        over_engine.set_up(context.scene)
        context.scene.tyndall.over_engine.is_enabled = True
        if doubled := fog.doubled(context):
            names = ", ".join(f'"{owner.name}"' for owner in doubled[:3])
            self.report({"WARNING"}, f"Fog is drawn twice until it is left to the light shafts: {names}")
        return {"FINISHED"}


class TYNDALL_OT_over_engine_remove(Operator):
    """Remove the light shafts' nodes and scene: links are as they were before, and fog is the engine's own again."""

    bl_idname = "tyndall.over_engine_remove"
    bl_label = "Remove Light Shafts from the Compositor"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not (over_engine.is_set_up(context.scene) or over_engine.shafts_scene_of(context.scene)):
            cls.poll_message_set("There are none in this scene's compositor")
            return False
        if (reason := over_engine.compositor.why_locked(context.scene)) is not None:
            cls.poll_message_set(reason)
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        over_engine.remove(context.scene)
        context.scene.tyndall.over_engine.is_enabled = False
        return {"FINISHED"}


class TYNDALL_OT_leave_fog(Operator):
    """Hide the fog of this scene's materials and world from the camera of its engine: the light shafts draw it.

    In Cycles it goes on dimming the light on its way to surfaces. A node before the Volume output does it
    """

    bl_idname = "tyndall.leave_fog"
    bl_label = "Leave Fog to the Light Shafts"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: Context) -> set[str]:
        owners = fog.doubled(context)
        if not owners:
            self.report({"INFO"}, "No material and no world of this scene has a volume that its engine draws")
            return {"CANCELLED"}
        locked = [owner for owner in owners if owner.library is not None or owner.override_library is not None]
        for owner in owners:
            if owner not in locked:
                fog.leave_to_shafts(owner)
        for owner in locked:
            self.report({"WARNING"}, f'"{owner.name}" is linked: make it local, or its fog is drawn twice')
        if len(locked) == len(owners):
            return {"CANCELLED"}
        names = ", ".join(f'"{owner.name}"' for owner in owners if owner not in locked)
        self.report({"INFO"}, f"Left to the light shafts: {names}")
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_over_engine_set_up, TYNDALL_OT_over_engine_remove, TYNDALL_OT_leave_fog)
