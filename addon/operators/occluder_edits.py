# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a light's occluder edits: add, remove, duplicate, move, solo.

An edit never moves in its collection, because its keys go by its index: moving changes ``order``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.props import EnumProperty, IntProperty
from bpy.types import Context, Light, Operator, PropertyGroup

from ..animation_paths import forget_item
from ..edited_light import edited_light, why_not_editable
from ..properties.occluder_edits import KIND_NAMES, KINDS, edits_in_order, unique_name

if TYPE_CHECKING:
    from ..properties.occluder_edits import TyndallOccluderEdit

_NOT_COPIED = frozenset({"rna_type", "name", "order", "is_solo"})
#: Of a new edit, metres: what shows in a scene of human size.
_NEW_SIZES_M = {"CLOSE": 0.5, "EPIPOLAR_CLOSE": 0.5, "SILHOUETTE": 0.2, "HOLES": 0.5}


class _ListOperator:
    """What all of them share: a light whose list may be changed, and an edit that is its active one."""

    bl_options = {"REGISTER", "UNDO"}
    needs_edit = True

    @classmethod
    def poll(cls, context: Context) -> bool:
        light = edited_light(context)
        if (reason := why_not_editable(light)) is not None:
            cls.poll_message_set(reason)
        elif light.library is not None:
            cls.poll_message_set("The light is linked: make a library override of it first")
        elif cls.needs_edit and active_edit(light) is None:
            cls.poll_message_set("The light has no occluder edits yet: add one")
        else:
            return True
        return False


def active_edit(light: Light) -> TyndallOccluderEdit | None:
    """The edit whose settings are shown."""
    settings = light.tyndall
    if settings.active_occluder_edit >= len(settings.occluder_edits):
        return None
    edit: TyndallOccluderEdit = settings.occluder_edits[settings.active_occluder_edit]
    return edit


def _new_edit(light: Light, name: str) -> TyndallOccluderEdit:
    """Make a new edit, the active one from now on, whose turn comes right after that of the one before."""
    settings = light.tyndall
    before = active_edit(light)
    place = edits_in_order(light).index(before) + 1 if before is not None else 0
    _number(edits_in_order(light), gap_at=place)
    edit: TyndallOccluderEdit = settings.occluder_edits.add()
    edit.name = unique_name(light, name, besides=edit)
    edit.order = place
    settings.active_occluder_edit = len(settings.occluder_edits) - 1
    return edit


def _number(edits: list[TyndallOccluderEdit], gap_at: int | None = None) -> None:
    """Write the order of a list into its edits, and leave a number free."""
    for place, edit in enumerate(edits):
        order = place + (gap_at is not None and place >= gap_at)
        if edit.order != order:
            edit.order = order


def _copy_settings(source: PropertyGroup, target: PropertyGroup) -> None:
    for rna in source.bl_rna.properties:
        if rna.identifier in _NOT_COPIED:
            continue
        value = getattr(source, rna.identifier)
        if isinstance(value, PropertyGroup):
            _copy_settings(value, getattr(target, rna.identifier))
        else:
            setattr(target, rna.identifier, value)


def _is_of_library(light: Light, edit: TyndallOccluderEdit) -> bool:
    """Whether an override has it from its library: such items cannot be removed, only switched off."""
    override = light.override_library
    return override is not None and edit.name in override.reference.tyndall.occluder_edits


class TYNDALL_OT_occluder_edit_add(_ListOperator, Operator):
    """Edit what stands between this light and the air, to shape its shafts."""

    bl_idname = "tyndall.occluder_edit_add"
    bl_label = "Add Occluder Edit"
    needs_edit = False

    kind: EnumProperty(name="Kind", description="What is done to the occluders", items=KINDS, default="CLOSE")

    def execute(self, context: Context) -> set[str]:
        light = edited_light(context)
        edit = _new_edit(light, KIND_NAMES[self.kind])
        edit.kind = self.kind
        edit.size_m = _NEW_SIZES_M[self.kind]
        light.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_occluder_edit_remove(_ListOperator, Operator):
    """Remove the active edit, with its keyframes and drivers."""

    bl_idname = "tyndall.occluder_edit_remove"
    bl_label = "Remove Occluder Edit"

    def execute(self, context: Context) -> set[str]:
        light = edited_light(context)
        settings = light.tyndall
        edit = active_edit(light)
        if _is_of_library(light, edit):
            self.report({"ERROR"}, f'"{edit.name}" comes from the library: switch it off instead')
            return {"CANCELLED"}
        index = settings.active_occluder_edit
        in_order = edits_in_order(light)
        place = in_order.index(edit)
        rest = in_order[:place] + in_order[place + 1 :]
        _number(rest)
        neighbour = rest[min(place, len(rest) - 1)].name if rest else ""
        forget_item(light, "tyndall.occluder_edits", index)
        settings.occluder_edits.remove(index)
        settings.active_occluder_edit = max(settings.occluder_edits.find(neighbour), 0)
        light.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_occluder_edit_duplicate(_ListOperator, Operator):
    """Add a copy of the active edit right after it, with its present values; keyframes stay with the original."""

    bl_idname = "tyndall.occluder_edit_duplicate"
    bl_label = "Duplicate Occluder Edit"

    def execute(self, context: Context) -> set[str]:
        light = edited_light(context)
        settings = light.tyndall
        index = settings.active_occluder_edit
        edit = _new_edit(light, settings.occluder_edits[index].name)
        _copy_settings(settings.occluder_edits[index], edit)
        light.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_occluder_edit_move(_ListOperator, Operator):
    """Make the active edit earlier or later. What one has filled, the next can open again."""

    bl_idname = "tyndall.occluder_edit_move"
    bl_label = "Move Occluder Edit"

    direction: EnumProperty(
        name="Direction",
        items=(("UP", "Up", "Make it earlier", 0), ("DOWN", "Down", "Make it later", 1)),
        default="UP",
    )

    def execute(self, context: Context) -> set[str]:
        light = edited_light(context)
        in_order = edits_in_order(light)
        place = in_order.index(active_edit(light))
        other = place + (1 if self.direction == "DOWN" else -1)
        if not 0 <= other < len(in_order):
            return {"CANCELLED"}
        in_order[place], in_order[other] = in_order[other], in_order[place]
        _number(in_order)
        light.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_occluder_edit_solo(_ListOperator, Operator):
    """Make this edit alone, and none of the light's others; again: all that are enabled."""

    bl_idname = "tyndall.occluder_edit_solo"
    bl_label = "Solo Occluder Edit"

    index: IntProperty(name="Index", description="Of the edit in the light's list; -1: the active one", default=-1)

    def execute(self, context: Context) -> set[str]:
        light = edited_light(context)
        settings = light.tyndall
        index = settings.active_occluder_edit if self.index < 0 else self.index
        if index >= len(settings.occluder_edits):
            self.report({"ERROR"}, f'Light "{light.name}" has no occluder edit {index}')
            return {"CANCELLED"}
        solo = not settings.occluder_edits[index].is_solo
        for other, edit in enumerate(settings.occluder_edits):
            edit.is_solo = solo and other == index
        light.update_tag()
        return {"FINISHED"}


CLASSES = (
    TYNDALL_OT_occluder_edit_add,
    TYNDALL_OT_occluder_edit_remove,
    TYNDALL_OT_occluder_edit_duplicate,
    TYNDALL_OT_occluder_edit_move,
    TYNDALL_OT_occluder_edit_solo,
)
