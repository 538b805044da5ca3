# SPDX-License-Identifier: GPL-3.0-or-later
"""Key what moves in the shafts over time, and go from key to key."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, FCurve, Operator
from mathutils import Vector

from ..animation_paths import animates_by_other_means, curves_at
from ..availability import why_no_render
from ..edited_light import edited_light
from ..keyed_shafts import animated_properties, next_key
from ..properties.heterogeneity import SCALE_PATH, WIND_PATH
from .occluder_edits import active_edit

if TYPE_CHECKING:
    import numpy as np
    from bpy.types import Scene
    from numpy.typing import NDArray

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


class TYNDALL_OT_loop_wind(Operator):
    """Change the wind as little as it takes to have the texture where it was after the frame range: a seamless loop."""

    bl_idname = "tyndall.loop_wind"
    bl_label = "Loop Wind"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_no_render() or _why_no_loop(context.scene)) is not None:
            cls.poll_message_set(reason)
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        from tyndall.heterogeneity import AirNoise

        scene = context.scene
        air = scene.tyndall.heterogeneity
        frame_count = scene.frame_end + 1 - scene.frame_start
        seconds = frame_count * scene.render.fps_base / scene.render.fps
        before = Vector(air.wind_m_per_s)
        air.wind_m_per_s = _looping(before * seconds, AirNoise(scale_m=air.scale_m).periods_m) / seconds
        after = Vector(air.wind_m_per_s)
        self.report(
            {"INFO"},
            f"{frame_count} frames loop: the wind is {after.length / before.length:.2g} times as fast, and turned by "
            f"{math.degrees(after.angle(before)):.0f}\N{DEGREE SIGN}",
        )
        return {"FINISHED"}


def _why_no_loop(scene: Scene) -> str | None:
    """What the button says that loops the wind; None: it may."""
    air = scene.tyndall.heterogeneity
    if not air.is_enabled:
        return "Switch Texture the Air on first"
    for path, name in ((WIND_PATH, "wind"), (SCALE_PATH, "scale")):
        if curves_at(scene, path) or animates_by_other_means(scene, path):
            return f"The {name} is animated: a loop needs one that stays"
    return None if any(air.wind_m_per_s) else "There is no wind: set one first, as it shall be about"


def _looping(way_m: Vector, periods_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """The whole multiples of the periods, (3, 3) by rows at right angles, that end nearest to a way; but not at 0."""
    import numpy as np

    periods = periods_m @ np.array(way_m) / (periods_m**2).sum(axis=1)
    whole = np.round(periods)
    if not whole.any():
        strongest = np.abs(periods).argmax()
        whole[strongest] = np.copysign(1.0, periods[strongest])
    looping_m: NDArray[np.float64] = whole @ periods_m
    return looping_m


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


CLASSES = (
    TYNDALL_OT_jump_to_key,
    TYNDALL_OT_toggle_key,
    TYNDALL_OT_key_wind,
    TYNDALL_OT_loop_wind,
    TYNDALL_OT_loop_holes,
)
