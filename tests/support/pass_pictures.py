# SPDX-License-Identifier: GPL-3.0-or-later
"""All passes of a scene, of ours and of Cycles, as files hold them: with filters, samples and settings alike."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from addon.engine.passes import register_passes

from .exr import read_planes, read_stamps


@dataclass(frozen=True)
class PassPictures:
    planes: dict[str, NDArray[np.float32]]  #: By the name of the pass, without the layer's: (height, width, channels).
    stamps: dict[str, str]


def render_passes(
    scene: bpy.types.Scene,
    folder: Path,
    engine: str,
    samples: int = 64,
    *,
    is_filtered: bool = True,
    seed: int = 0,
    bounces: int = 0,
) -> PassPictures:
    """``bounces``: of Cycles alone."""
    scene.render.engine = engine
    scene.render.use_compositing = False
    width_px = 1.5 if is_filtered else 0.01
    ours, cycles = scene.tyndall, scene.cycles
    ours.pixel_samples, ours.pixel_filter, ours.filter_width_px = samples, "BLACKMAN_HARRIS", width_px
    ours.noise_threshold, ours.seed = 0.0, seed
    cycles.device, cycles.samples, cycles.seed = "CPU", samples, seed
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces, cycles.volume_bounces = bounces, 0
    cycles.transparent_max_bounces = 1024
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", width_px
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth, settings.exr_codec = "32", "NONE"
    scene.render.filepath = str(folder / f"{engine}{seed}.exr")
    bpy.ops.render.render(write_still=True, scene=scene.name)
    path = Path(scene.render.filepath)
    planes = {name.partition(".")[2]: plane for name, plane in read_planes(path).items()}
    return PassPictures(planes, read_stamps(path))


def passes_of_both(scene: bpy.types.Scene) -> tuple[set[tuple[str, str, str]], set[tuple[str, str, str]]]:
    """Names, channels and kinds of the passes of the first view layer: of ours, and of the running Cycles."""

    class Recorder:
        def __init__(self) -> None:
            self.found: set[tuple[str, str, str]] = set()

        def register_pass(self, _scene: object, _layer: object, *args: str) -> None:
            name, _, channels, kind = args
            self.found.add((name, channels, kind))

    import _cycles  # noqa: F401, PLC0415 - in every build that these tests run in
    from cycles.engine import list_render_passes  # noqa: PLC0415 - the add-on of the running Blender

    layer, ours = scene.view_layers[0], Recorder()
    register_passes(ours, scene, layer)
    return ours.found, set(list_render_passes(scene, layer))
