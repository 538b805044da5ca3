# SPDX-License-Identifier: GPL-3.0-or-later
"""What the items of our lists have in common, see ``item_lists``; a group takes it over by inheriting from it."""

from bpy.props import BoolProperty, IntProperty, StringProperty

from ..item_lists import keep_name_unique
from .tagging import OVERRIDABLE, tag


class NamedItem:
    name: StringProperty(
        name="Name",
        description="Unique in the list: library overrides find an item by its name",
        update=keep_name_unique,
        override=OVERRIDABLE,
    )


class OrderedItem(NamedItem):
    order: IntProperty(
        name="Order",
        description="The lowest comes first. Moving an item in the list changes it",
        min=0,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )


class SwitchedItem(OrderedItem):
    is_enabled: BoolProperty(
        name="Enabled",
        description="Use this one. What is off costs nothing",
        default=True,
        update=tag,
        override=OVERRIDABLE,
    )
    is_solo: BoolProperty(
        name="Solo",
        description="Use this one alone, enabled or not, and none of the list's others",
        default=False,
        options=set(),
        update=tag,
        override=OVERRIDABLE,
    )
