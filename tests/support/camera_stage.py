# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage to look at from its middle, all around, and the same picture of it by ours and by Cycles.

The pictures' pixels are box-filtered squares: compared are the mean and blocks.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon.panoramas import panorama_settings

from .cycles_reference import block_means, prepare_cycles, rendered_pixels, save_side_by_side
from .small_scenes import cube, empty_scene, light, material, node, plane

PICTURES = Path(__file__).parents[2] / "out" / "camera_agreement"
SIZE_PX = 90
SAMPLES = 256


def glow(name: str, *color: float) -> bpy.types.Material:
    return material(name, lambda new, _: node(new, "ShaderNodeEmission", Color=(*color, 1)).outputs[0])


def build_stage(size_px: int = SIZE_PX) -> bpy.types.Scene:
    """Coloured cubes that glow all around, one above and one below, on a grey floor under a hard sun."""
    scene = empty_scene(size_px)
    scene.render.resolution_percentage = 100
    grey = material("Grey", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.5, 0.5, 1)).outputs[0])
    plane(-1.5, grey, half_side=20)
    for index, turn in enumerate(np.linspace(0.0, 2 * math.pi, 7, endpoint=False)):
        box = cube(f"Box{index}", glow(f"Glow{index}", 0.2 + 0.1 * index, 0.8 - 0.1 * index, 0.3))
        box.location = (4 * math.cos(turn), 4 * math.sin(turn), 0.4 * index - 1)
        box.scale, box.rotation_euler = (0.5, 0.6, 0.7), (0.3 * index, 0.2, 0.1)
    high = cube("High", glow("Sky", 1, 1, 0.2))
    high.location, high.scale = (0.4, 0.3, 3), (0.5, 0.5, 0.5)
    sun = light("SUN", (0, 0, 5), energy=3.0)
    sun.data.angle, sun.rotation_euler = 0.0, (0.6, 0.5, 0.0)
    scene.camera.location, scene.camera.rotation_euler = (0.1, -0.2, 0.3), (1.4, 0.1, 0.6)
    scene.camera.data.clip_start = 0.01
    return scene


def panorama(scene: bpy.types.Scene, longitude: tuple[float, float], latitude: tuple[float, float]) -> None:
    scene.camera.data.type = "PANO"
    settings = panorama_settings(scene.camera.data)
    settings.panorama_type = "EQUIRECTANGULAR"
    settings.longitude_min, settings.longitude_max = longitude
    settings.latitude_min, settings.latitude_max = latitude


def lens(scene: bpy.types.Scene, kind: str, **focus: Any) -> None:
    data = scene.camera.data
    data.type, data.lens, data.ortho_scale = kind, 30.0, 6.0
    data.dof.use_dof = True
    for name, value in focus.items():
        setattr(data.dof, name, value)


def ours(scene: bpy.types.Scene, samples: int = SAMPLES) -> NDArray[np.float64]:
    scene.render.engine, settings = "TYNDALL", scene.tyndall
    settings.pixel_samples, settings.noise_threshold = samples, 0.0
    settings.pixel_filter, settings.filter_width_px = "BOX", 1.0
    return rendered_pixels(scene)


def cycles(scene: bpy.types.Scene, samples: int = SAMPLES) -> NDArray[np.float64]:
    prepare_cycles(scene, samples, seed=1)
    scene.cycles.pixel_filter_type = "BOX"
    return rendered_pixels(scene)


def agree(
    name: str, here: NDArray[np.float64], there: NDArray[np.float64], mean_bound: float = 0.003, bound: float = 0.01
) -> None:
    save_side_by_side(PICTURES / f"{name}.png", here, there)
    level = float(there.mean())
    assert level > 0.01
    assert here.mean() == pytest.approx(level, rel=mean_bound)
    off = np.abs(block_means(here) - block_means(there)) / level
    assert np.median(off) < bound
    assert np.quantile(off, 0.99) < 8 * bound


def fog(density: float, anisotropy: float) -> None:
    scatter = {"Density": density, "Anisotropy": anisotropy}
    medium = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", **scatter).outputs[0])
    cube("Fog", medium).scale = (9, 9, 6)
