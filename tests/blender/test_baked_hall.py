# SPDX-License-Identifier: GPL-3.0-or-later
"""A hall that nobody here made, with no light but the sun of its Sky Texture: it falls where Cycles' does.

The scene lies beside the repository, in ../shared/data/blend; the test is skipped where it does not.
"""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import numpy as np
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.sky_scenes import errors
from support.small_scenes import material, node
from support.small_scenes import read as sent
from tyndall.scene_description import LightKind

REPOSITORY = Path(__file__).parents[2]
HALL = "data/blend/baked_hall/scene.blend"


def hall_path() -> Path | None:
    roots = [REPOSITORY.parent / "shared", Path(os.environ.get("TYNDALL_SHARED", "/nowhere"))]
    return next((root / HALL for root in roots if (root / HALL).exists()), None)


@pytest.mark.long
def test_the_sun_of_the_sky_falls_into_the_hall_where_cycles_has_it() -> None:
    """All in white: materials, most of whose images are missing, are other tests' matter."""
    path = hall_path()
    if path is None:
        pytest.skip(f"there is no {HALL} beside the repository")
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 128, 72, 100
    scene.render.use_border = False
    scene.camera.data.type = "PERSP"  # its own is a panorama
    white = material("White", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs[0])
    bpy.context.view_layer.material_override = white
    ours, cycles = tyndall_pixels(scene, 32), cycles_pixels(scene, 192, seed=1)
    scene.render.engine = "TYNDALL"
    [sun] = sent().lights
    assert sun.kind is LightKind.SUN
    mean, _ = errors(ours, cycles)  # blocks that only sky lights, through openings, are noise in both
    threshold = 0.5 * np.percentile(cycles.mean(axis=2), 99)
    lit, ours_lit = (picture.mean(axis=2) > threshold for picture in (cycles, ours))
    in_sun = ours[lit].mean() / cycles[lit].mean()
    print(f"mean {mean:.4f}, in the sun {in_sun:.4f}, otherwise lit {(lit != ours_lit).mean():.4f} of {lit.mean():.4f}")
    assert 0.01 < lit.mean() < 0.9
    assert (lit != ours_lit).mean() < 0.002
    assert in_sun == pytest.approx(1.0, abs=0.01)
    assert mean <= 0.01
