# SPDX-License-Identifier: GPL-3.0-or-later
"""Change the list of a scene's transfer functions, and key which of them the shafts show."""

from __future__ import annotations

from bpy.types import Context, Operator

from ..function_trees import copy_function
from ..item_lists import OrderedList, in_order
from ..transfer_states import close_gap, key_at, keys_of, make_room, place_for, states_of
from .item_lists import ListOperator, RemoveItem
from .transfer_functions import why_not_editable_scene


class _StateOperator(ListOperator):
    empty = "Make a transfer function first"

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        return why_not_editable_scene(context)

    @classmethod
    def edited_list(cls, context: Context) -> OrderedList:
        return states_of(context.scene)


class TYNDALL_OT_transfer_state_add(_StateOperator, Operator):
    """Add a state after the active one, and choose its transfer function; without one, its shafts are physical."""

    bl_idname = "tyndall.transfer_state_add"
    bl_label = "Add State"
    needs_item = False

    def execute(self, context: Context) -> set[str]:
        states = self.edited_list(context)
        if states.active is not None:
            make_room(context.scene, states.in_order().index(states.active) + 1)
        states.add("State")
        context.scene.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_transfer_state_remove(_StateOperator, RemoveItem, Operator):
    """Remove the active state, with the keyframes that show it. Its transfer function stays in the file."""

    bl_idname = "tyndall.transfer_state_remove"
    bl_label = "Remove State"

    def execute(self, context: Context) -> set[str]:
        states = self.edited_list(context)
        if not states.is_of_library(states.active):
            close_gap(context.scene, states.in_order().index(states.active))
        return super().execute(context)


class TYNDALL_OT_transfer_state_key(_StateOperator, Operator):
    """Keyframe what the shafts show at this frame as a state of its own: a copy of the transfer function, to change.

    The first keyframe is that of the function as it is
    """

    bl_idname = "tyndall.transfer_state_key"
    bl_label = "Key This State"

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        shafts, states, frame = scene.tyndall.shafts, self.edited_list(context), scene.frame_current
        existing = key_at(scene, frame)
        shown = round(existing.co.y if existing is not None else shafts.transfer_state)
        place = min(max(shown, 0), len(states.items) - 1)
        if existing is None and keys_of(scene):
            function = in_order(states.items)[place].function
            place = place_for(scene, frame)
            make_room(scene, place)
            states.insert(place, "State").function = copy_function(function) if function is not None else None
        else:
            states.activate(list(states.items).index(in_order(states.items)[place]))
        if existing is None:
            shafts.transfer_state = place
            shafts.keyframe_insert("transfer_state", frame=frame)
        scene.update_tag()
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_transfer_state_add, TYNDALL_OT_transfer_state_remove, TYNDALL_OT_transfer_state_key)
