# SPDX-License-Identifier: GPL-3.0-or-later
"""A tiny scene in Cycles and in ours, without noise of pixels' areas: for node trees and units.

Pictures that are judged by Cycles' noise, block by block, are cycles_reference.py's.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from .exr import read_planes

FloatArray = NDArray[np.float64]


def tyndall_pixels(scene: bpy.types.Scene, surface_samples: int = 1, mode: str = "RGB") -> FloatArray:
    """Render in ours, through the pixels' centres: (height, width, 3, or 4 of RGBA), rows bottom to top."""
    scene.render.engine = "TYNDALL"
    ours = scene.tyndall
    ours.pixel_samples, ours.pixel_filter, ours.filter_width_px = surface_samples, "BOX", 0.01
    ours.noise_threshold = 0.0
    ours.shafts.method = "EXACT"
    ours.shafts.adapts_strata = False
    return _pixels(scene, mode)


def cycles_pixels(
    scene: bpy.types.Scene, samples: int, seed: int, mode: str = "RGB", *, is_marched: bool = True
) -> FloatArray:
    """Render in Cycles, the same way: direct light and single scattering through any number of transparent surfaces.

    ``is_marched``: volumes that vary, in 5.0, too; where they are not, it builds a tree of each for 3 s.
    """
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed = "CPU", samples, seed
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.volume_bounces = 0
    if hasattr(cycles, "volume_biased"):
        cycles.volume_biased = is_marched
    cycles.transparent_max_bounces = 1024
    cycles.sample_clamp_direct = cycles.light_sampling_threshold = 0.0
    # The box filter of Cycles is one pixel wide whatever its setting says; this one is a point.
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    return _pixels(scene, mode)


def _pixels(scene: bpy.types.Scene, mode: str) -> FloatArray:
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode = "OPEN_EXR", mode
    settings.color_depth, settings.exr_codec = "32", "NONE"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        return read_planes(Path(scene.render.filepath))[""].astype(np.float64)
