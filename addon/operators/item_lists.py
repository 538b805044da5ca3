# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators on a list have in common: when they may run, and what removing, moving and soloing an item does."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.props import EnumProperty, IntProperty
from bpy.types import Context

if TYPE_CHECKING:
    from ..item_lists import ItemList, OrderedList


class ListOperator:
    """An operator on the list that ``edited_list`` returns, and on its active item where that is needed."""

    bl_options = {"REGISTER", "UNDO"}
    needs_item = True
    #: What a button says while the list is empty.
    empty = ""

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        """What a button says while there is no list to change; None: there is one."""
        raise NotImplementedError

    @classmethod
    def edited_list(cls, context: Context) -> OrderedList | ItemList:
        raise NotImplementedError

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := cls.why_not(context)) is not None:
            cls.poll_message_set(reason)
        elif cls.needs_item and cls.edited_list(context).active is None:
            cls.poll_message_set(cls.empty)
        else:
            return True
        return False


class RemoveItem(ListOperator):
    def execute(self, context: Context) -> set[str]:
        items = self.edited_list(context)
        if items.is_of_library(items.active):
            self.report({"ERROR"}, f'"{items.active.name}" comes from the library: switch it off instead')
            return {"CANCELLED"}
        items.remove_active()
        items.owner.update_tag()
        return {"FINISHED"}


class MoveItem(ListOperator):
    direction: EnumProperty(
        name="Direction",
        items=(("UP", "Up", "Towards the top of the list", 0), ("DOWN", "Down", "Towards its end", 1)),
        default="UP",
    )
    #: The step in the order that goes up in the list.
    up = -1

    def execute(self, context: Context) -> set[str]:
        items = self.edited_list(context)
        if not items.move_active(self.up if self.direction == "UP" else -self.up):
            return {"CANCELLED"}
        items.owner.update_tag()
        return {"FINISHED"}


class SoloItem(ListOperator):
    index: IntProperty(name="Index", description="In the list's collection; -1: the active one", default=-1)

    def execute(self, context: Context) -> set[str]:
        items = self.edited_list(context)
        index = items.active_index if self.index < 0 else self.index
        if index >= len(items.items):
            self.report({"ERROR"}, f'"{items.owner.name}" has only {len(items.items)} of them: there is no {index}')
            return {"CANCELLED"}
        items.toggle_solo(index)
        items.owner.update_tag()
        return {"FINISHED"}
