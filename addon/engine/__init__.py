# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: what Blender calls, handed on to one module per task.

This package imports the native core; the add-on loads it only where that works.
"""

from __future__ import annotations

import bpy
from bpy.types import Context, Depsgraph, RenderEngine, Scene, ViewLayer

from . import final, passes, preview, sessions, viewport


class TyndallRenderEngine(RenderEngine):
    bl_idname = "TYNDALL"
    bl_label = "Tyndall"
    bl_use_preview = True  # of materials, worlds and lights, as icons, too
    bl_use_postprocess = True  # compositor and sequencer
    bl_use_shading_nodes_custom = False  # otherwise artists lose the standard nodes
    bl_use_eevee_viewport = True  # material preview shading is EEVEE's
    bl_use_spherical_stereo = False

    def render(self, depsgraph: Depsgraph) -> None:
        if self.is_preview:
            preview.render(self, depsgraph)
        else:
            final.render(self, depsgraph)

    def view_update(self, context: Context, depsgraph: Depsgraph) -> None:
        viewport.view_update(self, context, depsgraph)

    def view_draw(self, context: Context, depsgraph: Depsgraph) -> None:
        viewport.view_draw(self, context, depsgraph)

    def update_render_passes(self, scene: Scene, view_layer: ViewLayer) -> None:
        passes.register_passes(self, scene, view_layer)


def register() -> None:
    bpy.utils.register_class(TyndallRenderEngine)
    sessions.register()
    viewport.register()


def unregister() -> None:
    viewport.unregister()
    sessions.unregister()
    bpy.utils.unregister_class(TyndallRenderEngine)
