# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a light's occluder edits: add, remove, duplicate, move, solo."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.props import EnumProperty
from bpy.types import Context, Light, Operator

from ..edited_light import edited_light, why_not_editable
from ..item_lists import OrderedList
from ..properties.occluder_edits import KIND_NAMES, KINDS
from .item_lists import ListOperator, MoveItem, RemoveItem, SoloItem

if TYPE_CHECKING:
    from ..properties.occluder_edits import TyndallOccluderEdit

#: Of a new edit, metres: what shows in a scene of human size.
_NEW_SIZES_M = {"CLOSE": 0.5, "EPIPOLAR_CLOSE": 0.5, "SILHOUETTE": 0.2, "HOLES": 0.5}


def _list_of(light: Light) -> OrderedList:
    return OrderedList(light.tyndall, "occluder_edits", "active_occluder_edit")


def active_edit(light: Light) -> TyndallOccluderEdit | None:
    """The edit whose settings are shown."""
    edit: TyndallOccluderEdit | None = _list_of(light).active
    return edit


class _EditOperator(ListOperator):
    empty = "The light has no occluder edits yet: add one"

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        light = edited_light(context)
        if (reason := why_not_editable(light)) is not None:
            return reason
        return "The light is linked: make a library override of it first" if light.library is not None else None

    @classmethod
    def edited_list(cls, context: Context) -> OrderedList:
        return _list_of(edited_light(context))


class TYNDALL_OT_occluder_edit_add(_EditOperator, Operator):
    """Edit what stands between this light and the air, to shape its shafts."""

    bl_idname = "tyndall.occluder_edit_add"
    bl_label = "Add Occluder Edit"
    needs_item = False

    kind: EnumProperty(name="Kind", description="What is done to the occluders", items=KINDS, default="CLOSE")

    def execute(self, context: Context) -> set[str]:
        edits = self.edited_list(context)
        edit = edits.add(KIND_NAMES[self.kind])
        edit.kind = self.kind
        edit.size_m = _NEW_SIZES_M[self.kind]
        edits.owner.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_occluder_edit_remove(_EditOperator, RemoveItem, Operator):
    """Remove the active edit, with its keyframes and drivers."""

    bl_idname = "tyndall.occluder_edit_remove"
    bl_label = "Remove Occluder Edit"


class TYNDALL_OT_occluder_edit_duplicate(_EditOperator, Operator):
    """Add a copy of the active edit right after it, with its present values; keyframes stay with the original."""

    bl_idname = "tyndall.occluder_edit_duplicate"
    bl_label = "Duplicate Occluder Edit"

    def execute(self, context: Context) -> set[str]:
        edits = self.edited_list(context)
        edits.duplicate()
        edits.owner.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_occluder_edit_move(_EditOperator, MoveItem, Operator):
    """Make the active edit earlier or later. What one has filled, the next can open again."""

    bl_idname = "tyndall.occluder_edit_move"
    bl_label = "Move Occluder Edit"


class TYNDALL_OT_occluder_edit_solo(_EditOperator, SoloItem, Operator):
    """Make this edit alone, and none of the light's others; again: all that are enabled."""

    bl_idname = "tyndall.occluder_edit_solo"
    bl_label = "Solo Occluder Edit"


CLASSES = (
    TYNDALL_OT_occluder_edit_add,
    TYNDALL_OT_occluder_edit_remove,
    TYNDALL_OT_occluder_edit_duplicate,
    TYNDALL_OT_occluder_edit_move,
    TYNDALL_OT_occluder_edit_solo,
)
