# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: light shafts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.types import Camera, Context, Panel

from .base import PropertiesPanel

if TYPE_CHECKING:
    from bpy.types import Object, UILayout

    from ..properties.light_shafts import TyndallLightShaftSettings


def _draw_choice(column: UILayout, shafts: TyndallLightShaftSettings, name: str, *, is_wide: bool) -> None:
    """In a narrow sidebar the label stands above: beside the field, both would be cut."""
    if not is_wide:
        column.label(text=shafts.bl_rna.properties[name].name)
    column.prop(shafts, name) if is_wide else column.prop(shafts, name, text="")


def draw_methods(layout: UILayout, shafts: TyndallLightShaftSettings, *, is_wide: bool = True) -> None:
    """Draw how shafts are found, and how finely."""
    column = layout.column(align=True)
    _draw_choice(column, shafts, "method", is_wide=is_wide)
    _draw_choice(column, shafts, "viewport_method", is_wide=is_wide)
    column = layout.column(align=True)
    target = column.column(align=True)
    target.active = shafts.resolution == 0 and shafts.method != "EXACT"
    target.prop(shafts, "error_target")
    resolution = column.column(align=True)
    resolution.active = shafts.method != "EXACT"
    resolution.prop(shafts, "resolution")


def draw_light_samples(layout: UILayout, shafts: TyndallLightShaftSettings) -> None:
    """Draw how smooth the penumbrae of shafts are."""
    column = layout.column(align=True)
    column.prop(shafts, "light_samples")
    column.prop(shafts, "world_samples")
    column.prop(shafts, "adapts_strata")
    sharing = column.column(align=True)
    sharing.active = shafts.method != "EXACT"
    sharing.prop(shafts, "shares_strata")


def draw_grids(layout: UILayout, shafts: TyndallLightShaftSettings, *, is_wide: bool = True) -> None:
    """Draw how volume grids scatter."""
    column = layout.column(align=True)
    _draw_choice(column, shafts, "grid_method", is_wide=is_wide)
    steps = column.column(align=True)
    steps.active = shafts.grid_method == "MARCH"
    if is_wide:
        steps.prop(shafts, "grid_error_target")
    else:
        steps.prop(shafts, "grid_error_target", text="Error Target")


def draw_lens_steps(layout: UILayout, shafts: TyndallLightShaftSettings, camera: Object | None) -> None:
    """Draw how smoothly shafts blur behind a lens."""
    data = None if camera is None else camera.data
    column = layout.column(align=True)
    column.active = isinstance(data, Camera) and data.type == "PERSP" and data.dof.use_dof
    column.prop(shafts, "lens_steps")


class TYNDALL_PT_light_shafts(PropertiesPanel, Panel):
    bl_label = "Light Shafts"
    bl_context = "render"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        shafts = context.scene.tyndall.shafts
        draw_methods(layout, shafts)
        draw_light_samples(layout, shafts)
        draw_grids(layout, shafts)
        draw_lens_steps(layout, shafts, context.scene.camera)
        layout.prop(shafts, "attenuates_light")
        layout.operator("tyndall.add_fog_box", icon="MOD_FLUIDSIM")


CLASSES = (TYNDALL_PT_light_shafts,)
