# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups: the view layer's list of them, and which one an object or the world is in."""

from __future__ import annotations

from bpy.types import Context, Object, Panel, UILayout, World

from .base import PropertiesPanel


class TYNDALL_PT_light_groups(PropertiesPanel, Panel):
    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_parent_id = "TYNDALL_PT_passes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layer = context.view_layer
        row = self.layout.row()
        row.template_list("UI_UL_list", "lightgroups", layer, "lightgroups", layer, "active_lightgroup_index", rows=3)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        column.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")
        column.separator()
        column.menu("VIEWLAYER_MT_lightgroup_sync", icon="DOWNARROW_HLT", text="")


def _draw_group(layout: UILayout, context: Context, owner: Object | World) -> None:
    layout.use_property_split = True
    layout.use_property_decorate = False
    row = layout.row(align=True)
    row.prop_search(owner, "lightgroup", context.view_layer, "lightgroups", text="Light Group")
    adding = row.column(align=True)
    adding.enabled = bool(owner.lightgroup) and owner.lightgroup not in context.view_layer.lightgroups
    adding.operator("scene.view_layer_add_lightgroup", icon="ADD", text="").name = owner.lightgroup


class TYNDALL_PT_object_light_group(PropertiesPanel, Panel):
    bl_label = "Light Group"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.object is not None

    def draw(self, context: Context) -> None:
        _draw_group(self.layout, context, context.object)


class TYNDALL_PT_world_light_group(PropertiesPanel, Panel):
    bl_label = "Light Group"
    bl_context = "world"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and context.world is not None

    def draw(self, context: Context) -> None:
        _draw_group(self.layout, context, context.world)


CLASSES = (TYNDALL_PT_light_groups, TYNDALL_PT_object_light_group, TYNDALL_PT_world_light_group)
