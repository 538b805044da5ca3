# SPDX-License-Identifier: GPL-3.0-or-later
"""What was painted over cameras, and the map that a light has now, as a fit takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall.light_map_fit import LightMap, StrokeView
from tyndall.linear_colours import linear_colours

from .cameras import read_camera
from .images import ImageReader, without_pixels

if TYPE_CHECKING:
    import bpy
    from numpy.typing import NDArray

    from ..properties.light_map_fit import TyndallFitView
    from .reports import Reports


def read_views(
    views: list[TyndallFitView], depsgraph: bpy.types.Depsgraph, size_px: tuple[int, int], reports: Reports
) -> list[StrokeView]:
    """Of a frame of ``size_px``, those that can be used; what is missing is reported, and the others stay."""
    found = []
    for view in views:
        culprit = f'View "{view.name}"'
        if view.camera is None:
            reports.add(culprit, "left out: it has no camera, or that was deleted")
        elif view.strokes is None:
            reports.add(culprit, "left out: it has no strokes: Paint Strokes makes an image for them")
        elif (reason := without_pixels(view.strokes)) is not None:
            reports.add(culprit, f"left out: its {reason}")
        else:
            texels = unassociated_texels(view.strokes, reports, culprit)
            try:
                camera = read_camera(
                    view.camera.evaluated_get(depsgraph), depsgraph.scene_eval.render, size_px, reports
                )
            except ValueError as error:
                reports.add(culprit, f"left out: {error}")
                continue
            found.append(StrokeView(name=view.name, camera=camera, texels=texels))
    return found


def read_current_map(light: bpy.types.Light, reports: Reports) -> LightMap | None:
    """The light's gobo, which the fit stays close to; None: white. One that is not square cannot be that."""
    settings = light.tyndall
    image, culprit = settings.gobo_image, f'Light "{light.name}"'
    if image is None or without_pixels(image) is not None:
        return None
    width, height = image.size
    if width != height:
        reports.add(culprit, f'the fit begins with white: its gobo "{image.name}" is {width} x {height}, not square')
        return None
    texels = unassociated_texels(image, reports, culprit)
    share = settings.gobo_strength
    multiplier = 1.0 - share + share * texels[..., 3:] * texels[..., :3]  # a gobo is black where it is transparent
    if light.type != "SUN":
        return LightMap(texels=multiplier)
    return LightMap(texels=multiplier, size_m=settings.gobo_size_m, centre_m=tuple(settings.gobo_offset_m))


def unassociated_texels(image: bpy.types.Image, reports: Reports, culprit: str) -> NDArray[np.float32]:
    """(height, width, 4), rows bottom to top, scene-linear, not multiplied with alpha."""
    read = ImageReader().read(image, reports, culprit)
    assert read is not None  # noqa: S101  callers have asked for its pixels
    texels = read.pixels.astype(np.float32)
    if read.pixels.dtype == np.uint8:
        texels[..., :3], texels[..., 3] = linear_colours(read), texels[..., 3] / 255.0
    return texels
