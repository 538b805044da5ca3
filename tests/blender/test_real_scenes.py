# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of other people open, render and agree with Cycles; docs/real-scenes.md shows them.

They lie beside the repository, in ../shared/data/blend.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from support.cycles_reference import block_means, prepare_cycles, rendered_pixels
from support.real_scenes import REAL_SCENES, RealScene

SMALL_PX, WIDTH_PX, BLOCK_PX = 48, 192, 8
MEAN_BOUND, MEDIAN_BOUND = 0.01, 0.01
FLOOR_SHARE = 1e-3  #: Of the picture's mean: what is darker counts as so dark.

each_scene = pytest.mark.parametrize("real", REAL_SCENES, ids=lambda real: real.name)


def opened(real: RealScene, width_px: int) -> bpy.types.Scene:
    if bpy.app.version < real.oldest:
        pytest.skip(f"{bpy.app.version_string} itself crashes while it reads {real.path}")
    if real.found() is None:
        pytest.skip(f"../shared/data/blend/{real.path} is not there")
    return real.open(width_px)


def ours(scene: bpy.types.Scene, samples: int) -> np.ndarray:
    scene.render.engine = "TYNDALL"
    scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = samples, 0.0
    scene.tyndall.pixel_filter, scene.tyndall.filter_width_px = "BOX", 1.0
    return rendered_pixels(scene)


@pytest.mark.dealt
@each_scene
def test_it_opens_and_renders(real: RealScene) -> None:
    picture = ours(opened(real, SMALL_PX), 1)
    assert np.isfinite(picture).all()
    assert picture.mean() > 0.0
    assert picture.std() > 0.01 * picture.mean()  # something stands before the world


@pytest.mark.long
@each_scene
def test_it_agrees_with_cycles(real: RealScene) -> None:
    """Direct light and emission; where ``differences`` names what is not the same light, that is as it was measured."""
    scene = opened(real, WIDTH_PX)
    mine = ours(scene, 64)
    pictures = []
    for seed in (1, 2):
        prepare_cycles(scene, 128, seed)
        scene.cycles.pixel_filter_type = "BOX"
        pictures.append(rendered_pixels(scene))
    first, second = (block_means(picture, BLOCK_PX) for picture in pictures)
    reference = (first + second) / 2
    scale = np.maximum(reference, FLOOR_SHARE * reference.mean())
    error = float(np.median(np.abs(block_means(mine, BLOCK_PX) - reference) / scale))
    noise = float(np.median(np.abs(first - second) / 2 / scale))
    mean_error = float(block_means(mine, BLOCK_PX).sum() / reference.sum() - 1)
    mean_noise = abs(float(first.sum() - second.sum()) / 2 / float(reference.sum()))
    print(f"{real.name}: mean {mean_error:+.3%} (noise {mean_noise:.3%}), median {error:.3%} (noise {noise:.3%})")
    assert abs(mean_error) <= max(MEAN_BOUND, real.mean_bound) + 3 * mean_noise
    assert error <= max(MEDIAN_BOUND, real.median_bound) + noise
