# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions: in the 3D view's sidebar beside what they colour, and in the Render properties."""

from __future__ import annotations

from bpy.types import Context, Menu, NodeTree, Panel, UILayout, UIList

from ..function_trees import active_state, edited_function, ramp_of
from ..item_lists import having_a_say, in_order, places
from ..properties.light_shafts import TyndallLightShaftSettings
from ..properties.transfer_functions import (
    AXIS_NAMES,
    RANGED_AXES,
    ParameterAxis,
    TyndallTransferFunction,
    TyndallTransferState,
)
from ..properties.transfer_layers import KIND_ICONS, TyndallTransferConstraint, TyndallTransferLayer
from ..transfer_function_presets import PRESETS
from ..transfer_function_preview import picture_of
from ..transfer_states import shares
from .base import PropertiesPanel, SidebarPanel, draw_text, is_wide_region
from .item_lists import SwitchedItemRows

#: Of a function's picture, in rows of the interface.
_PICTURE_SCALE = 7.0


class TYNDALL_UL_transfer_states(UIList):
    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        data: TyndallLightShaftSettings,
        item: TyndallTransferState,
        icon: int,
        active_data: object,
        active_property: str,
    ) -> None:
        place = in_order(data.transfer_states).index(item)
        share = dict(shares(data.transfer_state, len(data.transfer_states))).get(place, 0.0)
        row = layout.row(align=True)
        row.active = share > 0.0
        if item.function is None:
            row.label(text="Physical", icon="WORLD")
        else:
            row.prop(item.function, "name", text="", emboss=False, icon="COLOR")
        if share > 0.0:
            shown = row.row()
            shown.ui_units_x = 2.0
            shown.label(text=f"{share:.0%}")

    def filter_items(self, context: Context, data: object, propname: str) -> tuple[list[int], list[int]]:
        return [], places(getattr(data, propname))


class TYNDALL_UL_transfer_layers(SwitchedItemRows, UIList):
    kind_icons = KIND_ICONS
    collection_name = "layers"
    solo_operator = "tyndall.transfer_layer_solo"
    lists_first_on_top = False


class TYNDALL_UL_transfer_constraints(UIList):
    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        data: TyndallTransferLayer,
        item: TyndallTransferConstraint,
        icon: int,
        active_data: object,
        active_property: str,
    ) -> None:
        row = layout.row(align=True)
        row.prop(item, "name", text="", emboss=False, icon="TRACKER" if item.is_tracked else "DOT")
        colour = row.row()
        colour.ui_units_x = 2.0
        colour.prop(item, "colour", text="")


class TYNDALL_MT_transfer_function_presets(Menu):
    bl_label = "Presets"

    def draw(self, context: Context) -> None:
        for preset in PRESETS:
            self.layout.operator("tyndall.transfer_function_preset", text=preset.name).preset = preset.identifier


class TYNDALL_MT_transfer_layers(Menu):
    bl_label = "Layer Specials"

    def draw(self, context: Context) -> None:
        self.layout.operator("tyndall.transfer_layer_duplicate", text="Duplicate", icon="DUPLICATE")
        self.layout.operator("tyndall.transfer_layer_solo", text="Solo", icon="SOLO_ON").index = -1
        self.layout.operator("tyndall.transfer_layer_paint", icon="BRUSH_DATA")


def _draw_functions(layout: UILayout, context: Context) -> None:
    """Draw which functions the scene has, and how the active one is used."""
    shafts = context.scene.tyndall.shafts
    state = active_state(shafts)
    if state is None:
        draw_text(layout, context, "Recolour the shafts: start from a preset, or from nothing", icon="INFO")
        column = layout.column(align=True)
        column.menu("TYNDALL_MT_transfer_function_presets", text="New from Preset", icon="PRESET")
        column.operator("tyndall.transfer_function_new", text="New", icon="ADD")
        column.operator("tyndall.transfer_state_add", text="Choose", icon="NODETREE")
        return
    layout.template_ID(state, "function", new="tyndall.transfer_function_new")
    layout.menu("TYNDALL_MT_transfer_function_presets", text="New from Preset", icon="PRESET")
    if state.function is not None:
        _draw_picture(layout, context, state.function)
    column = layout.column(align=True)
    column.use_property_split = is_wide_region(context)
    column.prop(shafts, "transfer_mix")
    if state.function is not None:
        function = state.function.tyndall
        column.prop(function, "use", text="Use" if is_wide_region(context) else "")
        if function.use == "REPLACE":
            column.prop(function, "strength")


def _draw_picture(layout: UILayout, context: Context, tree: NodeTree) -> None:
    icon, reason = picture_of(tree, context.view_layer.depsgraph)
    if reason is not None:
        draw_text(layout, context, reason, icon="ERROR")
        return
    column = layout.column(align=True)
    above = column.row()
    above.alignment = "CENTER"
    above.label(text=f"Up: {AXIS_NAMES[tree.tyndall.y.axis]}")
    column.template_icon(icon_value=icon, scale=_PICTURE_SCALE)
    below = column.row()
    below.alignment = "CENTER"
    below.label(text=f"Right: {AXIS_NAMES[tree.tyndall.x.axis]}")


def _draw_axis(layout: UILayout, axis: ParameterAxis, label: str) -> None:
    column = layout.column(align=True)
    column.label(text=label)
    column.prop(axis, "axis", text="")
    if axis.axis == "MASK":
        column.template_ID(axis, "mask", new="image.new", open="image.open")
        return
    ends = {"AVERAGE_VISIBILITY": ("full_visibility",), **dict.fromkeys(RANGED_AXES, ("low_m", "high_m"))}
    if axis.axis in ends:
        column.prop(axis, "fits_range")
        for name in () if axis.fits_range else ends[axis.axis]:
            column.prop(axis, name)


def _draw_layers(layout: UILayout, context: Context, function: TyndallTransferFunction) -> None:
    row = layout.row()
    row.template_list(
        "TYNDALL_UL_transfer_layers", "", function, "layers", function, "active_layer", rows=5 if function.layers else 3
    )
    column = row.column(align=True)
    column.operator_menu_enum("tyndall.transfer_layer_add", "kind", text="", icon="ADD")
    column.operator("tyndall.transfer_layer_remove", text="", icon="REMOVE")
    if not function.layers:
        draw_text(layout, context, "Without a layer the shafts stay physical: add one", icon="INFO")
        return
    column.separator()
    column.menu("TYNDALL_MT_transfer_layers", text="", icon="DOWNARROW_HLT")
    column.separator()
    column.operator("tyndall.transfer_layer_move", text="", icon="TRIA_UP").direction = "UP"
    column.operator("tyndall.transfer_layer_move", text="", icon="TRIA_DOWN").direction = "DOWN"
    if function.active_layer < len(function.layers):
        layer = function.layers[function.active_layer]
        column = layout.column()
        column.active = layer in having_a_say(function.layers)
        _draw_layer(column, context, layer)


def _draw_layer(layout: UILayout, context: Context, layer: TyndallTransferLayer) -> None:
    """Draw the settings that a layer of its kind reads."""
    is_wide = is_wide_region(context)
    column = layout.column(align=True)
    column.use_property_split = is_wide
    for name in ("kind", "blend_mode"):
        column.prop(layer, name) if is_wide else column.prop(layer, name, text="")
    column.prop(layer, "opacity")
    if layer.kind == "SOLID":
        layout.prop(layer, "colour", text="")
    elif layer.kind == "GRADIENT":
        _draw_gradient(layout, layer, is_wide=is_wide)
    elif layer.kind == "DIFFUSION":
        _draw_constraints(layout, context, layer)
    else:
        layout.template_ID(layer, "image", new="image.new", open="image.open")


def _draw_gradient(layout: UILayout, layer: TyndallTransferLayer, *, is_wide: bool) -> None:
    if ramp_of(layer) is None:
        layout.label(text="Its ramp was removed: change the kind", icon="ERROR")
    else:
        layout.template_color_ramp(layer.id_data.nodes[layer.ramp_node], "color_ramp", expand=is_wide)
    if layer.id_data.override_library is not None:
        layout.label(text="Ramps of an override are not saved", icon="ERROR")
    layout.prop(layer, "shape", text="")
    row = layout.row()
    row.column(align=True).prop(layer, "start")
    row.column(align=True).prop(layer, "end")


def _draw_constraints(layout: UILayout, context: Context, layer: TyndallTransferLayer) -> None:
    layout.prop(layer, "smoothness")
    row = layout.row()
    row.template_list("TYNDALL_UL_transfer_constraints", "", layer, "constraints", layer, "active_constraint", rows=3)
    column = row.column(align=True)
    column.operator("tyndall.transfer_constraint_add", text="", icon="ADD")
    column.operator("tyndall.transfer_constraint_remove", text="", icon="REMOVE")
    column.separator()
    column.operator("tyndall.pick_constraint", text="", icon="EYEDROPPER")
    if layer.active_constraint >= len(layer.constraints):
        draw_text(layout, context, "Set a colour at a place: add a constraint", icon="INFO")
        return
    constraint = layer.constraints[layer.active_constraint]
    layout.prop(constraint, "colour", text="")
    column = layout.column(align=True)
    column.active = not constraint.is_tracked
    column.prop(constraint, "position")
    layout.prop(constraint, "is_tracked")
    if constraint.is_tracked:
        layout.prop(constraint, "tracked_object", text="")


def _draw_states(layout: UILayout, context: Context) -> None:
    shafts = context.scene.tyndall.shafts
    row = layout.row()
    row.template_list(
        "TYNDALL_UL_transfer_states", "", shafts, "transfer_states", shafts, "active_transfer_state", rows=3
    )
    column = row.column(align=True)
    column.operator("tyndall.transfer_state_add", text="", icon="ADD")
    column.operator("tyndall.transfer_state_remove", text="", icon="REMOVE")
    layout.prop(shafts, "transfer_state")
    layout.operator("tyndall.transfer_state_key", icon="KEY_HLT")


def _is_on(context: Context) -> bool:
    return bool(context.scene.tyndall.shafts.use_transfer_functions)


class _Functions:
    bl_label = "Transfer Functions"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.tyndall.shafts, "use_transfer_functions", text="")

    def draw(self, context: Context) -> None:
        self.layout.active = _is_on(context)
        _draw_functions(self.layout, context)


class _Layers:
    bl_label = "Layers"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and edited_function(context) is not None

    def draw(self, context: Context) -> None:
        self.layout.active = _is_on(context)
        _draw_layers(self.layout, context, edited_function(context).tyndall)


class _Axes:
    bl_label = "Axes"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and edited_function(context) is not None

    def draw(self, context: Context) -> None:
        self.layout.active = _is_on(context)
        function = edited_function(context).tyndall
        _draw_axis(self.layout, function.x, "X: left to right")
        _draw_axis(self.layout, function.y, "Y: bottom to top")
        column = self.layout.column(align=True)
        column.label(text="About the light")
        column.prop(context.scene.tyndall.shafts, "transfer_light", text="")


class _States:
    bl_label = "Over Time"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and len(context.scene.tyndall.shafts.transfer_states) > 0

    def draw(self, context: Context) -> None:
        self.layout.active = _is_on(context)
        _draw_states(self.layout, context)


class _RenderTab(PropertiesPanel):
    bl_context = "render"


class TYNDALL_PT_transfer_functions(_Functions, _RenderTab, Panel):
    bl_parent_id = "TYNDALL_PT_light_shafts"
    bl_options = {"DEFAULT_CLOSED"}


class TYNDALL_PT_transfer_layers(_Layers, _RenderTab, Panel):
    bl_parent_id = "TYNDALL_PT_transfer_functions"


class TYNDALL_PT_transfer_axes(_Axes, _RenderTab, Panel):
    bl_parent_id = "TYNDALL_PT_transfer_functions"


class TYNDALL_PT_transfer_states(_States, _RenderTab, Panel):
    bl_parent_id = "TYNDALL_PT_transfer_functions"


class TYNDALL_PT_sidebar_transfer_functions(_Functions, SidebarPanel, Panel):
    bl_parent_id = "TYNDALL_PT_sidebar_colour"
    bl_options = {"DEFAULT_CLOSED"}


class TYNDALL_PT_sidebar_transfer_layers(_Layers, SidebarPanel, Panel):
    bl_parent_id = "TYNDALL_PT_sidebar_transfer_functions"


class TYNDALL_PT_sidebar_transfer_axes(_Axes, SidebarPanel, Panel):
    bl_parent_id = "TYNDALL_PT_sidebar_transfer_functions"


class TYNDALL_PT_sidebar_transfer_states(_States, SidebarPanel, Panel):
    bl_parent_id = "TYNDALL_PT_sidebar_transfer_functions"


CLASSES = (
    TYNDALL_UL_transfer_states,
    TYNDALL_UL_transfer_layers,
    TYNDALL_UL_transfer_constraints,
    TYNDALL_MT_transfer_function_presets,
    TYNDALL_MT_transfer_layers,
    TYNDALL_PT_transfer_functions,
    TYNDALL_PT_transfer_layers,
    TYNDALL_PT_transfer_axes,
    TYNDALL_PT_transfer_states,
)
SIDEBAR_CLASSES = (
    TYNDALL_PT_sidebar_transfer_functions,
    TYNDALL_PT_sidebar_transfer_layers,
    TYNDALL_PT_sidebar_transfer_axes,
    TYNDALL_PT_sidebar_transfer_states,
)
