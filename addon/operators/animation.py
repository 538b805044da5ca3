# SPDX-License-Identifier: GPL-3.0-or-later
"""Key what moves in the shafts over time, and go from key to key."""

from __future__ import annotations

import math

from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, FCurve, Operator

from ..animation_paths import curves_at
from ..edited_light import edited_light
from ..keyed_shafts import animated_properties, next_key
from ..properties.heterogeneity import WIND_PATH
from .occluder_edits import active_edit

#: Of holes that stand still when their turn is animated: enough to see them drift.
_SWAY_FOR_TURNING = 0.5


class TYNDALL_OT_jump_to_key(Operator):
    """Go to the next keyframe of anything that shapes, colours or textures the shafts."""

    bl_idname = "tyndall.jump_to_key"
    bl_label = "Jump to Key"
    bl_options = {"REGISTER", "UNDO"}

    direction: EnumProperty(
        name="Direction",
        items=(("NEXT", "Next", "Later in time", 0), ("PREVIOUS", "Previous", "Earlier in time", 1)),
        default="NEXT",
    )

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        frame = next_key(scene, scene.frame_current_final, is_forward=self.direction == "NEXT")
        if frame is None:
            self.report({"INFO"}, f"There is no {self.direction.lower()} key of the shafts")
            return {"CANCELLED"}
        scene.frame_set(math.floor(frame), subframe=frame % 1.0)
        return {"FINISHED"}


class TYNDALL_OT_toggle_key(Operator):
    """Keyframe this at the present frame, with the value that it has now; or remove the keyframe that is there."""

    bl_idname = "tyndall.toggle_key"
    bl_label = "Toggle Keyframe"
    bl_options = {"REGISTER", "UNDO"}

    identifier: StringProperty(name="Property", options={"SKIP_SAVE"})

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        found = next((one for one in animated_properties(scene) if one.identifier == self.identifier), None)
        if found is None or found.is_driven:
            self.report({"ERROR"}, f"Not keyed any more: {self.identifier}")
            return {"CANCELLED"}
        keys = found.keys_at(scene.frame_current)
        for key_frame in keys:
            found.owner.keyframe_delete(found.path, frame=key_frame)
        if not keys:
            found.owner.keyframe_insert(found.path, frame=scene.frame_current)
        scene.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_key_wind(Operator):
    """Keyframe the wind at this frame: from key to key it freshens or drops, and never makes the texture jump."""

    bl_idname = "tyndall.key_wind"
    bl_label = "Key Wind"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not context.scene.tyndall.heterogeneity.is_enabled:
            cls.poll_message_set("Switch Texture the Air on first")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        scene.keyframe_insert(WIND_PATH, frame=scene.frame_current)
        return {"FINISHED"}


class TYNDALL_OT_loop_holes(Operator):
    """Turn the active holes once over the frame range: their drift ends where it begins, as a loop without a seam."""

    bl_idname = "tyndall.loop_holes"
    bl_label = "Loop Holes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        light = edited_light(context)
        edit = active_edit(light) if light is not None else None
        if edit is None or edit.kind != "HOLES":
            cls.poll_message_set("Make Holes has to be the active edit of the light")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        scene, light = context.scene, edited_light(context)
        noise = active_edit(light).noise
        path = noise.path_from_id("turn_rad")
        for curve in curves_at(light, path):
            _remove_keys(curve)
        # The frame after the last is the first again.
        for frame, turn_rad in ((scene.frame_start, 0.0), (scene.frame_end + 1, 2.0 * math.pi)):
            noise.turn_rad = turn_rad
            light.keyframe_insert(path, frame=frame)
        for curve in curves_at(light, path):
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
            curve.extrapolation = "LINEAR"
        if noise.sway == 0.0:
            noise.sway = _SWAY_FOR_TURNING
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        return {"FINISHED"}


def _remove_keys(curve: FCurve) -> None:
    for index in reversed(range(len(curve.keyframe_points))):
        curve.keyframe_points.remove(curve.keyframe_points[index])


CLASSES = (TYNDALL_OT_jump_to_key, TYNDALL_OT_toggle_key, TYNDALL_OT_key_wind, TYNDALL_OT_loop_holes)
