# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a light's occluder edits: in its own properties, and in the 3D view's sidebar beside what it shapes."""

from __future__ import annotations

from bpy.types import Context, Light, Menu, Panel, UILayout, UIList

from ..edited_light import edited_light
from ..item_lists import having_a_say
from ..operators.occluder_edits import active_edit
from ..properties.occluder_edits import KIND_ICONS, TyndallHoleNoise, TyndallOccluderEdit
from .base import SidebarPanel, draw_text, is_wide_region
from .item_lists import SwitchedItemRows
from .light import LightPanel, draw_edited_light

#: What the size of an edit is, by kind; holes have none.
_SIZE_LABELS = {"CLOSE": "Hole Size", "EPIPOLAR_CLOSE": "Hole Length", "SILHOUETTE": "Grow By"}


class TYNDALL_UL_occluder_edits(SwitchedItemRows, UIList):
    kind_icons = KIND_ICONS
    collection_name = "occluder_edits"
    solo_operator = "tyndall.occluder_edit_solo"


class TYNDALL_MT_occluder_edits(Menu):
    bl_label = "Occluder Edit Specials"

    def draw(self, context: Context) -> None:
        self.layout.operator("tyndall.occluder_edit_duplicate", text="Duplicate", icon="DUPLICATE")
        self.layout.operator("tyndall.occluder_edit_solo", text="Solo", icon="SOLO_ON").index = -1


def draw_edits(layout: UILayout, context: Context, light: Light) -> None:
    """Draw the list, and under it what the active edit reads."""
    settings = light.tyndall
    edit = active_edit(light)
    row = layout.row()
    row.template_list(
        "TYNDALL_UL_occluder_edits",
        "",
        settings,
        "occluder_edits",
        settings,
        "active_occluder_edit",
        rows=5 if edit else 3,
    )
    column = row.column(align=True)
    column.operator_menu_enum("tyndall.occluder_edit_add", "kind", text="", icon="ADD")
    column.operator("tyndall.occluder_edit_remove", text="", icon="REMOVE")
    if edit is None:
        draw_text(layout, context, "Reshape its shafts: add an edit of what stands in the light's way", icon="INFO")
        return
    column.separator()
    column.menu("TYNDALL_MT_occluder_edits", text="", icon="DOWNARROW_HLT")
    column.separator()
    column.operator("tyndall.occluder_edit_move", text="", icon="TRIA_UP").direction = "UP"
    column.operator("tyndall.occluder_edit_move", text="", icon="TRIA_DOWN").direction = "DOWN"
    if not settings.scatters_in_media:
        draw_text(layout, context, "Scatter in Media is off: only edits for surfaces show", icon="ERROR")
    column = layout.column()
    column.active = edit in having_a_say(settings.occluder_edits)
    column.use_property_split = is_wide_region(context)
    draw_edit(column, light, edit, is_wide=is_wide_region(context))


def draw_edit(layout: UILayout, light: Light, edit: TyndallOccluderEdit, *, is_wide: bool) -> None:
    """Draw the settings that an edit of its kind reads, for this kind of light."""

    def draw_choice(column: UILayout, name: str) -> None:
        column.prop(edit, name) if is_wide else column.prop(edit, name, text="")

    column = layout.column()
    draw_choice(column, "kind")
    if edit.kind == "CLOSE":
        draw_choice(column, "shape")
    column = layout.column(align=True)
    if edit.kind == "HOLES":
        draw_noise(column, edit.noise)
        layout.column().prop(edit, "affects_surfaces")
    else:
        column.prop(edit, "size_m", text=_SIZE_LABELS[edit.kind])
        layout.column().prop(edit, "affects_surfaces", text="Shadow Surfaces")
    if light.type != "SUN":
        layout.column().prop(edit, "distance_m")
    column = layout.column()
    draw_choice(column, "target")
    if edit.target == "OBJECT":
        draw_choice(column, "target_object")
    elif edit.target == "COLLECTION":
        draw_choice(column, "target_collection")
    column = layout.column()
    draw_mask(column, edit, is_wide=is_wide)
    if edit.mask_image is not None:
        draw_choice(column, "mask_channel")
        if light.type == "SUN":
            column.prop(edit, "mask_size_m", text="Width" if is_wide else "Mask Width")
    layout.operator("tyndall.show_light_depth", icon="IMAGE_DATA")


def draw_mask(column: UILayout, edit: TyndallOccluderEdit, *, is_wide: bool) -> None:
    if is_wide:
        column.template_ID(edit, "mask_image", new="image.new", open="image.open", text="Mask")
    else:
        column.label(text="Mask")
        column.template_ID(edit, "mask_image", new="image.new", open="image.open")


def draw_noise(column: UILayout, noise: TyndallHoleNoise) -> None:
    column.prop(noise, "probability")
    column.prop(noise, "scale_m")
    column.prop(noise, "octaves")
    persistence = column.column(align=True)
    persistence.active = noise.octaves > 1
    persistence.prop(noise, "persistence")
    column.separator()
    column.prop(noise, "sway")
    turn = column.column(align=True)
    turn.active = noise.sway > 0.0
    turn.prop(noise, "turn_rad")
    column.prop(noise, "seed")


class TYNDALL_PT_occluder_edits(LightPanel, Panel):
    bl_label = "Occluder Edits"

    def draw(self, context: Context) -> None:
        draw_edits(self.layout, context, context.light)


class TYNDALL_PT_sidebar_occluder_edits(SidebarPanel, Panel):
    bl_label = "Shape the Shafts"

    def draw(self, context: Context) -> None:
        layout = self.layout
        light = edited_light(context)
        draw_edited_light(layout, context)
        if light is None:
            draw_text(layout, context, "Make a light active, or choose one here, to shape its shafts", icon="INFO")
            return
        draw_edits(layout, context, light)


CLASSES = (
    TYNDALL_UL_occluder_edits,
    TYNDALL_MT_occluder_edits,
    TYNDALL_PT_occluder_edits,
)
SIDEBAR_CLASSES = (TYNDALL_PT_sidebar_occluder_edits,)
