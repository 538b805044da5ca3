# SPDX-License-Identifier: GPL-3.0-or-later
"""The film's exposure, which Cycles keeps with a scene, multiplies light as it does there, and nothing else."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.pass_pictures import render_passes
from support.small_scenes import cube, empty_scene, light, material, node


def test_exposure_multiplies_light_and_leaves_alpha_and_data_alone(tmp_path: Path) -> None:
    """A cube that covers a part of a transparent film; each pass is that of Cycles."""
    scene = empty_scene()
    scene.camera.data.ortho_scale = 4.0
    scene.render.film_transparent = True
    made_of = material("Glow", lambda new, _: node(new, "ShaderNodeEmission", Color=(0.9, 0.5, 0.2, 1)).outputs[0])
    cube("Cube", made_of)
    layer = scene.view_layers[0]
    layer.use_pass_emit = layer.use_pass_z = layer.use_pass_diffuse_color = True
    plain = render_passes(scene, tmp_path, "TYNDALL", is_filtered=False)
    scene.cycles.film_exposure = 0.7
    ours, theirs = (render_passes(scene, tmp_path, engine, is_filtered=False) for engine in ("TYNDALL", "CYCLES"))
    assert {"Combined", "Emission" if bpy.app.version >= (5, 0, 0) else "Emit"} <= ours.planes.keys()
    for name, plane in ours.planes.items():
        assert plane == pytest.approx(theirs.planes[name], rel=1e-4, abs=1e-5), name
    light_before, light_after = (picture.planes["Combined"] for picture in (plain, ours))
    assert light_after[..., :3] == pytest.approx(0.7 * light_before[..., :3], rel=1e-6)
    assert (light_after[..., 3] == light_before[..., 3]).all()
    assert light_before[..., 3].min() < light_before[..., 3].max()


def test_a_lit_floor_is_as_bright_as_in_cycles() -> None:
    scene = empty_scene()
    cube("Cube", material("Grey", lambda new, _: node(new, "ShaderNodeBsdfDiffuse").outputs[0]))
    light("SUN", (0, 0, 5), energy=3.0)
    scene.cycles.film_exposure = 2.5
    theirs = cycles_pixels(scene, samples=1, seed=1)
    assert theirs.mean() == pytest.approx(0.8 * 3.0 / 3.14159265 * 2.5, rel=1e-3)
    assert tyndall_pixels(scene) == pytest.approx(theirs, rel=1e-4)
