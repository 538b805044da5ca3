# SPDX-License-Identifier: GPL-3.0-or-later
"""A rendered viewport through a fisheye, whose field changes, a lens that is refused, and then no camera at all."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from support.beam_scene import build_beam_scene


def session(window: Any) -> Iterator[float]:
    from addon.engine import viewport
    from addon.engine.viewport_camera import camera_frame_px
    from addon.panoramas import panorama_settings

    yield from window.calm()
    scene = build_beam_scene()
    space, region = window.area("VIEW_3D").spaces[0], window.region("VIEW_3D")
    space.overlay.show_overlays = space.show_gizmo = False
    camera = scene.camera.data
    camera.type = "PANO"
    lens = panorama_settings(camera)
    lens.panorama_type, lens.fisheye_fov, lens.fisheye_lens = "FISHEYE_EQUISOLID", 3.0, 12.0
    space.region_3d.view_perspective = "CAMERA"
    space.shading.type = "RENDERED"

    def worker() -> Any:
        return next(iter(viewport.open_viewports.values())).worker

    def seen_share() -> Iterator[float]:
        """Of the region, where there is any light, once the picture is complete."""
        yield 0.2
        yield from window.until(lambda: bool(viewport.open_viewports))
        yield from window.until(lambda: worker().picture is not None and not worker().status, at_most_s=300)
        yield from window.calm()
        return float((worker().picture.rgba[..., :3].max(axis=2) > 0.0).mean())

    shares = window.facts["shares"] = {}
    shares["fisheye"] = yield from seen_share()
    with bpy.context.temp_override(window=window.bpy_window, area=window.area("VIEW_3D"), region=region):
        left, bottom, right, top = camera_frame_px(bpy.context, (region.width, region.height))
    window.facts["width_over_sensor"] = max(right - left, top - bottom) / camera.sensor_width
    window.facts["region_px"] = region.width * region.height
    window.screenshot("fisheye")
    lens.fisheye_fov = 1.5
    camera.update_tag()  # of settings that an add-on keeps, Blender tells what an artist changes, not a script
    shares["narrow"] = yield from seen_share()
    window.screenshot("fisheye_narrow")
    space.overlay.show_overlays = True  # among which the message is
    lens.panorama_type, lens.latitude_min = "EQUIRECTANGULAR", lens.latitude_max
    camera.update_tag()
    opened = next(iter(viewport.open_viewports.values()))
    yield from window.until(lambda: opened.status.startswith("Camera"))
    yield from window.calm()
    window.facts["refusal"] = opened.status
    window.screenshot("fisheye_refused")
    space.overlay.show_overlays = False
    space.region_3d.view_perspective = "PERSP"
    shares["no camera"] = yield from seen_share()
