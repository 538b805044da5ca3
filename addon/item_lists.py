# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists that artists edit, kept in collections whose items never move.

Keys and drivers find an item by its index, library overrides find it by its name: names are unique, and in an ordered
list each item's ``order`` says when its turn is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bpy.types import PropertyGroup

from .animation_paths import forget_item

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.types import Context

#: What a duplicate has of its own.
_NOT_DUPLICATED = frozenset({"name", "order", "is_solo"})


def in_order(items: Iterable[Any]) -> list[Any]:
    """By their turns; of equal orders, which only a script can give, the older first."""
    return sorted(items, key=lambda item: item.order)


def having_a_say(items: Iterable[Any]) -> list[Any]:
    """In order: the soloed one, or all that are enabled."""
    by_turn = in_order(items)
    return [item for item in by_turn if item.is_solo] or [item for item in by_turn if item.is_enabled]


def places(items: Iterable[Any]) -> list[int]:
    """Of each item of a collection: its place in the order; what ``UIList.filter_items`` returns."""
    orders = [item.order for item in items]
    place_of = {index: place for place, index in enumerate(sorted(range(len(orders)), key=orders.__getitem__))}
    return [place_of[index] for index in range(len(orders))]


def unique_name(items: Iterable[Any], wanted: str, besides: PropertyGroup | None = None) -> str:
    """``wanted``, with a number like Blender's own where another item has that name."""
    taken = {item.name for item in items if besides is None or item != besides}
    name, number = wanted, 0
    while name in taken:
        number += 1
        name = f"{wanted}.{number:03d}"
    return name


def keep_name_unique(item: PropertyGroup, _context: Context) -> None:
    """What the ``update`` of an item's name does; one without a name gets its kind's ``UNNAMED``."""
    path = item.path_from_id()
    siblings = item.id_data.path_resolve(path[: path.rindex("[")])
    name = unique_name(siblings, item.name or item.UNNAMED, besides=item)
    if name != item.name:
        item.name = name


class ItemList:
    """A collection, and the index of its active item, as operators change them."""

    def __init__(self, holder: PropertyGroup, name: str, active_name: str) -> None:
        self.holder = holder
        self.owner: Any = holder.id_data  #: The datablock that it is in.
        self._name = name
        self._active_name = active_name

    @property
    def items(self) -> Any:  # noqa: ANN401  a collection of the holder's own type
        return getattr(self.holder, self._name)

    @property
    def active_index(self) -> int:
        return int(getattr(self.holder, self._active_name))

    @property
    def active(self) -> Any | None:  # noqa: ANN401
        """The item whose settings are shown."""
        items = self.items
        return items[self.active_index] if self.active_index < len(items) else None

    def activate(self, index: int) -> None:
        setattr(self.holder, self._active_name, index)

    def in_order(self) -> list[Any]:
        return list(self.items)

    def _number(self, items: list[Any], gap_at: int | None = None) -> None:
        """Write the order of a list into its items, and leave a number free."""

    def _place(self, item: PropertyGroup, place: int) -> None:
        """Write the place of a new item into it."""

    def add(self, name: str) -> Any:  # noqa: ANN401
        """Make a new item, the active one from now on, whose turn comes right after that of the one before."""
        active = self.active
        place = self.in_order().index(active) + 1 if active is not None else 0
        return self.insert(place, name)

    def insert(self, place: int, name: str) -> Any:  # noqa: ANN401
        """Make a new item at a place in the order, the active one from now on."""
        self._number(self.in_order(), gap_at=place)
        item = self.items.add()  # all that was got out of the collection before is invalid from here on
        item.name = unique_name(self.items, name, besides=item)
        self._place(item, place)
        self.activate(len(self.items) - 1)
        return item

    def duplicate(self, *, leaving: frozenset[str] = frozenset()) -> Any:  # noqa: ANN401
        """Add a copy of the active item right after it, with its present values, less those it must have of its own."""
        index = self.active_index
        item = self.add(self.items[index].name)
        copy_settings(self.items[index], item, _NOT_DUPLICATED | leaving)
        return item

    def remove_active(self) -> None:
        """With its keys and drivers; its neighbour becomes the active one."""
        by_turn = self.in_order()
        place = by_turn.index(self.active)
        rest = by_turn[:place] + by_turn[place + 1 :]
        self._number(rest)
        index = self.active_index
        neighbour = list(self.items).index(rest[min(place, len(rest) - 1)]) if rest else 0
        forget_item(self.owner, self.holder.path_from_id(self._name), index)
        self.items.remove(index)
        self.activate(neighbour - (neighbour > index))

    def is_of_library(self, item: PropertyGroup) -> bool:
        """Whether an override has it from its library: such items cannot be removed, only switched off."""
        override = self.owner.override_library
        if override is None:
            return False
        try:
            inherited: Any = override.reference.path_resolve(self.holder.path_from_id(self._name))
        except ValueError:  # the list is within an item of the override's own
            return False
        return item.name in inherited


class OrderedList(ItemList):
    """One whose items have an ``order``, ``is_enabled`` and ``is_solo``."""

    def in_order(self) -> list[Any]:
        return in_order(self.items)

    def _number(self, items: list[Any], gap_at: int | None = None) -> None:
        for place, item in enumerate(items):
            order = place + (gap_at is not None and place >= gap_at)
            if item.order != order:
                item.order = order

    def _place(self, item: PropertyGroup, place: int) -> None:
        item.order = place

    def move_active(self, step: int) -> bool:
        """Give the active item an earlier (-1) or later (1) turn. False at the list's end."""
        by_turn = self.in_order()
        place = by_turn.index(self.active)
        other = place + step
        if not 0 <= other < len(by_turn):
            return False
        by_turn[place], by_turn[other] = by_turn[other], by_turn[place]
        self._number(by_turn)
        return True

    def toggle_solo(self, index: int) -> None:
        solo = not self.items[index].is_solo
        for other, item in enumerate(self.items):
            item.is_solo = solo and other == index


def copy_settings(source: PropertyGroup, target: PropertyGroup, besides: frozenset[str] = frozenset()) -> None:
    """All properties of a group, those of groups and collections in it included."""
    for rna in source.bl_rna.properties:
        name = rna.identifier
        if name in besides or name == "rna_type":
            continue
        value = getattr(source, name)
        if rna.type == "COLLECTION":
            copies = getattr(target, name)
            copies.clear()
            for item in value:
                copy_settings(item, copies.add())
        elif isinstance(value, PropertyGroup):
            copy_settings(value, getattr(target, name))
        else:
            setattr(target, name, value)
