# SPDX-License-Identifier: GPL-3.0-or-later
"""Make transfer functions, and change the list of a function's layers and of a layer's constraints."""

from __future__ import annotations

from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ..function_trees import (
    active_state,
    copy_function,
    copy_ramp,
    edited_function,
    keep_ramp,
    new_function,
    remove_ramp,
    why_not_editable,
)
from ..item_lists import ItemList, OrderedList
from ..properties.transfer_layers import KIND_NAMES, KINDS, TyndallTransferLayer
from ..transfer_function_presets import PRESETS, make_preset
from ..transfer_states import states_of
from .item_lists import ListOperator, MoveItem, RemoveItem, SoloItem


class FunctionOperator(ListOperator):
    """Works on the layers of the edited function."""

    empty = "The transfer function has no layers yet: add one"

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        return why_not_editable(edited_function(context))

    @classmethod
    def edited_list(cls, context: Context) -> OrderedList:
        return OrderedList(edited_function(context).tyndall, "layers", "active_layer")


class ConstraintOperator(FunctionOperator):
    """Works on the constraints of the active layer, which diffuses them."""

    empty = "The layer has no constraints yet: add or pick one"

    @classmethod
    def why_not(cls, context: Context) -> str | None:
        if (reason := super().why_not(context)) is not None:
            return reason
        layer = super().edited_list(context).active
        if layer is None or layer.kind != "DIFFUSION":
            return "Make a diffusion layer the active one"
        return None

    @classmethod
    def edited_list(cls, context: Context) -> ItemList:
        return constraints_of(super().edited_list(context).active)


def constraints_of(layer: TyndallTransferLayer) -> ItemList:
    return ItemList(layer, "constraints", "active_constraint")


def why_not_editable_scene(context: Context) -> str | None:
    """What a button says that changes which functions a scene has; None: it may."""
    return "The scene is linked: make a library override of it first" if context.scene.library is not None else None


class _SceneOperator:
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if (reason := why_not_editable_scene(context)) is not None:
            cls.poll_message_set(reason)
            return False
        return True


class TYNDALL_OT_transfer_function_new(_SceneOperator, Operator):
    """Make a new transfer function, or a copy of the one that is shown."""

    bl_idname = "tyndall.transfer_function_new"
    bl_label = "New Transfer Function"

    def execute(self, context: Context) -> set[str]:
        shown = edited_function(context)
        _show(context, new_function("Transfer Function") if shown is None else copy_function(shown))
        return {"FINISHED"}


class TYNDALL_OT_transfer_function_preset(_SceneOperator, Operator):
    """Recolour the shafts in a made way: a new transfer function, to start from."""

    bl_idname = "tyndall.transfer_function_preset"
    bl_label = "Add Transfer Function Preset"

    preset: EnumProperty(
        name="Preset",
        description="What the new transfer function is like",
        items=[(preset.identifier, preset.name, preset.description, number) for number, preset in enumerate(PRESETS)],
    )

    def execute(self, context: Context) -> set[str]:
        _show(context, make_preset(self.preset))
        return {"FINISHED"}


def _show(context: Context, tree: object) -> None:
    """Make it the function of the active state: of a first one, where the scene has none."""
    shafts = context.scene.tyndall.shafts
    if active_state(shafts) is None:
        states_of(context.scene).add("State")
    active_state(shafts).function = tree
    context.scene.update_tag()


class TYNDALL_OT_transfer_layer_add(FunctionOperator, Operator):
    """Lay another colour over the function."""

    bl_idname = "tyndall.transfer_layer_add"
    bl_label = "Add Layer"
    needs_item = False

    kind: EnumProperty(name="Kind", description="Where the layer's colours come from", items=KINDS, default="SOLID")

    def execute(self, context: Context) -> set[str]:
        layers = self.edited_list(context)
        layer = layers.add(KIND_NAMES[self.kind])
        layer.kind = self.kind
        layers.owner.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_transfer_layer_remove(FunctionOperator, RemoveItem, Operator):
    """Remove the active layer, with its ramp, keyframes and drivers."""

    bl_idname = "tyndall.transfer_layer_remove"
    bl_label = "Remove Layer"

    def execute(self, context: Context) -> set[str]:
        layers = self.edited_list(context)
        if not layers.is_of_library(layers.active):
            remove_ramp(layers.active)
        return super().execute(context)


class TYNDALL_OT_transfer_layer_duplicate(FunctionOperator, Operator):
    """Lay a copy of the active layer over it, with its present values; keyframes stay with the original."""

    bl_idname = "tyndall.transfer_layer_duplicate"
    bl_label = "Duplicate Layer"

    def execute(self, context: Context) -> set[str]:
        layers = self.edited_list(context)
        index = layers.active_index
        layer = layers.duplicate(leaving=frozenset({"ramp_node"}))
        keep_ramp(layer)
        copy_ramp(layers.items[index], layer)
        layers.owner.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_transfer_layer_move(FunctionOperator, MoveItem, Operator):
    """Change which layers the active one covers: the first of the list lies on top of all."""

    bl_idname = "tyndall.transfer_layer_move"
    bl_label = "Move Layer"
    up = 1


class TYNDALL_OT_transfer_layer_solo(FunctionOperator, SoloItem, Operator):
    """Use this layer alone, and none of the function's others; again: all that are enabled."""

    bl_idname = "tyndall.transfer_layer_solo"
    bl_label = "Solo Layer"


class TYNDALL_OT_transfer_constraint_add(ConstraintOperator, Operator):
    """Set another colour, in the middle of the function: move it from there, or pick it on the picture instead."""

    bl_idname = "tyndall.transfer_constraint_add"
    bl_label = "Add Constraint"
    needs_item = False

    def execute(self, context: Context) -> set[str]:
        constraints = self.edited_list(context)
        constraints.add("Colour")
        constraints.owner.update_tag()
        return {"FINISHED"}


class TYNDALL_OT_transfer_constraint_remove(ConstraintOperator, RemoveItem, Operator):
    """Remove the active constraint, with its keyframes and drivers."""

    bl_idname = "tyndall.transfer_constraint_remove"
    bl_label = "Remove Constraint"


CLASSES = (
    TYNDALL_OT_transfer_function_new,
    TYNDALL_OT_transfer_function_preset,
    TYNDALL_OT_transfer_layer_add,
    TYNDALL_OT_transfer_layer_remove,
    TYNDALL_OT_transfer_layer_duplicate,
    TYNDALL_OT_transfer_layer_move,
    TYNDALL_OT_transfer_layer_solo,
    TYNDALL_OT_transfer_constraint_add,
    TYNDALL_OT_transfer_constraint_remove,
)
