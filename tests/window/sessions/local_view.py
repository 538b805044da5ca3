# SPDX-License-Identifier: GPL-3.0-or-later
"""Local view, as the / key calls it, of a rendered viewport: without the haze, and back."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from support.beam_scene import build_beam_scene


def session(window: Any) -> Iterator[float]:
    from addon.engine import viewport

    yield from window.calm()
    scene = build_beam_scene()
    area, region = window.area("VIEW_3D"), window.region("VIEW_3D")
    space = area.spaces[0]
    space.overlay.show_overlays = space.show_gizmo = False
    space.region_3d.view_perspective = "CAMERA"
    space.shading.type = "RENDERED"
    fog = scene.objects["Fog Box"]

    def worker() -> Any:
        return next(iter(viewport.open_viewports.values())).worker

    def finished_level() -> Iterator[float]:
        """The mean of the picture, once it is complete."""
        yield 0.2
        yield from window.until(lambda: bool(viewport.open_viewports))
        yield from window.until(lambda: worker().picture is not None and not worker().status, at_most_s=300)
        yield from window.calm()
        return float(worker().picture.rgba[..., :3].mean())

    def toggle_local_view() -> None:
        with bpy.context.temp_override(window=window.bpy_window, area=area, region=region):
            bpy.ops.view3d.localview(frame_selected=False)

    def select(is_selected: Any) -> None:
        for thing in scene.objects:
            thing.select_set(is_selected(thing))

    levels = window.facts["levels"] = {}
    levels["whole"] = yield from finished_level()
    select(lambda thing: thing != fog)
    toggle_local_view()
    levels["without the fog"] = yield from finished_level()
    window.screenshot("local_view_without_fog")
    toggle_local_view()
    levels["whole again"] = yield from finished_level()
    select(lambda thing: thing == fog or thing.type == "LIGHT")
    toggle_local_view()
    levels["fog and lamp alone"] = yield from finished_level()
    window.screenshot("local_view_of_fog")
    with bpy.context.temp_override(window=window.bpy_window, area=area, region=region):
        select(lambda thing: thing == fog)
        bpy.ops.view3d.localview_remove_from()
    levels["lamp alone"] = yield from finished_level()
    toggle_local_view()
    fog.hide_set(True)
    levels["fog hidden by its eye"] = yield from finished_level()
