# SPDX-License-Identifier: GPL-3.0-or-later
"""How a list of items that can be switched off and soloed is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..item_lists import places

if TYPE_CHECKING:
    from bpy.types import Context, PropertyGroup, UILayout


class SwitchedItemRows:
    """Of a ``UIList``: icon, name and eye; a soloed item has a star in the place of its eye."""

    kind_icons: dict[str, str]
    collection_name: str  #: Of the group that the list is in.
    solo_operator: str
    lists_first_on_top = True

    def draw_item(
        self,
        _context: Context,
        layout: UILayout,
        data: PropertyGroup,
        item: Any,  # noqa: ANN401  of any of our lists
        _icon: int,
        _active_data: object,
        _active_property: str,
    ) -> None:
        items = getattr(data, self.collection_name)
        row = layout.row(align=True)
        row.active = item.is_solo if any(other.is_solo for other in items) else item.is_enabled
        row.prop(item, "name", text="", emboss=False, icon=self.kind_icons[item.kind])
        if item.is_solo:
            row.operator(self.solo_operator, text="", icon="SOLO_ON", emboss=False).index = items.find(item.name)
        else:
            row.prop(item, "is_enabled", text="", icon="HIDE_OFF" if item.is_enabled else "HIDE_ON", emboss=False)

    def filter_items(self, _context: Context, data: PropertyGroup, _name: str) -> tuple[list[int], list[int]]:
        """By their turns; items themselves never move, for the sake of their keys."""
        turns = places(getattr(data, self.collection_name))
        return [], turns if self.lists_first_on_top else [len(turns) - 1 - turn for turn in turns]
