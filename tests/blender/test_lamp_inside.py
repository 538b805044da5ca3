# SPDX-License-Identifier: GPL-3.0-or-later
"""The air within a lamp: from 4.0 on, without Soft Falloff, its sphere lights that as in Cycles."""

from __future__ import annotations

import bpy
import pytest

from support.cycles_reference import prepare_cycles, rendered_pixels
from support.small_scenes import cube, empty_scene, light, material, node


@pytest.mark.dealt
@pytest.mark.skipif(bpy.app.version < (4, 1, 0), reason="there lamps are discs, or their spheres were never compared")
@pytest.mark.parametrize("is_disc", [False, True])
def test_a_lamp_in_fog_is_as_bright_as_in_cycles(*, is_disc: bool) -> None:
    """Of a ball nearly half of the light is its inside's, which was dark; its strata are blurred at its surface."""
    scene = empty_scene(size_px=17)
    scene.camera.data.ortho_scale = 1.02
    fog = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.01).outputs[0])
    cube("Fog", fog).scale = (2.0, 2.0, 2.0)
    lamp = light("POINT", (0.0, 0.0, 0.0), energy=100.0, shadow_soft_size=0.3, use_soft_falloff=is_disc)
    assert lamp.data.use_soft_falloff == is_disc
    settings = scene.tyndall
    settings.pixel_samples, settings.noise_threshold, settings.shafts.light_samples = 16, 0.0, 1024
    ours = rendered_pixels(scene)
    prepare_cycles(scene, 1024, 1)
    cycles = rendered_pixels(scene)
    middle = slice(5, 12), slice(5, 12)
    assert ours.mean() == pytest.approx(cycles.mean(), rel=0.02 if is_disc else 0.04)
    assert ours[middle].mean() == pytest.approx(cycles[middle].mean(), rel=0.02 if is_disc else 0.06)
