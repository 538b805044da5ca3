# SPDX-License-Identifier: GPL-3.0-or-later
"""The air within a lamp: from 4.0 on, without Soft Falloff, its sphere lights that as in Cycles."""

from __future__ import annotations

import bpy
import pytest

from support.cycles_reference import prepare_cycles, rendered_pixels
from support.small_scenes import cube, empty_scene, light, material, node


@pytest.mark.dealt
@pytest.mark.skipif(bpy.app.version < (4, 1, 0), reason="there lamps are discs, or their spheres were never compared")
@pytest.mark.parametrize(("kind", "is_disc"), [("POINT", False), ("POINT", True), ("SPOT", False)])
def test_a_lamp_in_fog_is_as_bright_as_in_cycles(kind: str, *, is_disc: bool) -> None:
    """Of a ball nearly half of the light is its inside's, a spot light's too: there its cone counts for nothing."""
    scene = empty_scene(size_px=17)
    scene.camera.data.ortho_scale = 1.02
    fog = material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.01).outputs[0])
    cube("Fog", fog).scale = (2.0, 2.0, 2.0)
    lamp = light(kind, (0.0, 0.0, 0.0), energy=100.0, shadow_soft_size=0.3, use_soft_falloff=is_disc)
    lamp.rotation_euler = (1.5, 0.0, 0.4)
    if kind == "SPOT":  # of rays that air draws by itself within a spot light Cycles loses some
        lamp.data.cycles.use_multiple_importance_sampling = False
    settings = scene.tyndall
    settings.pixel_samples, settings.noise_threshold, settings.shafts.light_samples = 16, 0.0, 64
    settings.shafts.adapts_strata = False
    settings.pixel_filter, settings.filter_width_px = "BOX", 1.0
    ours = rendered_pixels(scene)
    prepare_cycles(scene, 1024, 1)
    scene.cycles.pixel_filter_type = "BOX"
    cycles = rendered_pixels(scene)
    middle = slice(5, 12), slice(5, 12)
    assert ours.mean() == pytest.approx(cycles.mean(), rel=0.02)
    assert ours[middle].mean() == pytest.approx(cycles[middle].mean(), rel=0.03)
