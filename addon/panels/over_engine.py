# SPDX-License-Identifier: GPL-3.0-or-later
"""Light shafts over the picture of another engine: in the Render properties of every engine, and in the sidebar."""

from __future__ import annotations

from bpy.types import Context, Panel, UILayout

from .. import over_engine
from ..amounts import duration_text
from ..last_render import statistics_of
from ..over_engine.compositor import compose_node
from .base import ENGINE, PropertiesPanel, SidebarPanel, draw_text, draw_value, is_wide_region
from .statistics import grouped_reports

_REPORTS_SHOWN = 4
#: Inputs of the node in the compositor that are settings.
_SETTINGS = ("Strength", "Mask")


class _OverEnginePanel:
    bl_label = "Light Shafts over This Engine"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Under every other engine; under ours where that would draw light shafts twice."""
        return bool(context.engine != ENGINE or over_engine.is_set_up(context.scene))

    def draw_header(self, context: Context) -> None:
        if over_engine.is_set_up(context.scene):
            self.layout.prop(context.scene.tyndall.over_engine, "is_enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        scene = context.scene
        if not over_engine.is_set_up(scene):
            if (reason := over_engine.why_not(scene)) is not None:
                draw_text(layout, context, reason, icon="INFO")
                return
            draw_text(
                layout,
                context,
                "F12 renders with this engine, and Tyndall adds its light shafts in the compositor: picture x "
                "transmittance + light of the air.",
            )
            layout.operator("tyndall.over_engine_set_up", text="Set Up", icon="NODE_COMPOSITING")
            return
        problems = over_engine.problems(scene)
        for problem in problems:
            draw_text(layout, context, problem, icon="ERROR")
        if problems:
            layout.operator("tyndall.over_engine_set_up", text="Set Up Again", icon="FILE_REFRESH")
        column = layout.column()
        column.use_property_split = is_wide_region(context)
        column.active = scene.tyndall.over_engine.is_enabled
        _draw_settings(column, context)
        row = layout.row(align=True)
        row.operator("tyndall.leave_fog", text="Leave Fog to the Shafts", icon="MOD_FLUIDSIM")
        row.operator("tyndall.over_engine_remove", text="Remove", icon="X")
        _draw_last_render(layout, context)


def _draw_settings(layout: UILayout, context: Context) -> None:
    scene = context.scene
    node = compose_node(scene)
    for name in _SETTINGS if node is not None and node.node_tree is not None else ():
        socket = node.inputs[name]
        if socket.is_linked:
            layout.label(text=f'{name}: from "{socket.links[0].from_node.name}"', icon="NODE")
        else:
            layout.prop(socket, "default_value", text=name)
    settings = scene.tyndall
    layout.prop(settings, "pixel_samples", text="Samples")
    layout.prop(settings.shafts, "method")
    if len(scene.view_layers) > 1:
        layout.prop_search(settings.over_engine, "view_layer", scene, "view_layers")


def _draw_last_render(layout: UILayout, context: Context) -> None:
    statistics = statistics_of(context.scene.name)
    if statistics is None:
        return
    seconds = sum(stage["seconds"] for stage in statistics.get("stages", ()))
    draw_value(layout, context, "Light shafts of the last render", duration_text(seconds))
    for skipped in statistics.get("skipped", ()):
        draw_text(layout, context, f"Skipped {skipped['what']}: {skipped['reason']}", icon="REMOVE")
    for report in grouped_reports(statistics.get("reports", ()))[:_REPORTS_SHOWN]:
        draw_text(layout, context, report, icon="ERROR")


class TYNDALL_PT_over_engine(_OverEnginePanel, PropertiesPanel, Panel):
    bl_context = "render"


class TYNDALL_PT_over_engine_sidebar(_OverEnginePanel, SidebarPanel, Panel):
    bl_label = "Output: over This Engine"


CLASSES = (TYNDALL_PT_over_engine, TYNDALL_PT_over_engine_sidebar)
