# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that glow and many lamps light surfaces, gloss too, as in Cycles, with direct light alone."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from support.cycles_reference import agreement, cycles_pixels, pixels_on_edges, save_side_by_side, tyndall_pixels
from support.many_light_scenes import LIT_BY, build_lit_by

PICTURES = Path(__file__).parents[2] / "out" / "many_lights"
SAMPLES = 64
_MARKS = {"200 lamps": pytest.mark.long}
#: Each lamp costs Cycles the same, and gloss each lamp once more.
_FEWER_SAMPLES = {"200 lamps": SAMPLES // 2, "40 spots and points": SAMPLES // 4, "40 over gloss": SAMPLES // 8}


# Seen to fail, of spots and points: with spots' cones that leave out the points beside them.
@pytest.mark.dealt
@pytest.mark.parametrize(
    "light",
    [pytest.param(light, marks=_MARKS.get(light, ())) for light in LIT_BY if "0 points" not in light],
)
def test_equals_cycles(light: str) -> None:
    """The mean within 1 %, as is the median block, beyond what is noise."""
    scene = build_lit_by(light)
    ours_samples = _FEWER_SAMPLES.get(light, SAMPLES)
    samples = 4 * ours_samples
    cycles = cycles_pixels(scene, samples, seed=1), cycles_pixels(scene, samples, seed=2)
    on_edges = pixels_on_edges(scene)
    ours = [tyndall_pixels(scene, ("EXACT",), surface_samples=ours_samples, seed=seed)[0] for seed in (0, 1)]
    verdict = agreement((ours[0], ours[1]), cycles, on_edges, samples)
    print(f"{light}: {verdict}")
    name = f"{bpy.app.version_string} {light}".replace(" ", "_")
    save_side_by_side(PICTURES / f"{name}.png", (ours[0] + ours[1]) / 2, (cycles[0] + cycles[1]) / 2)
    assert abs(verdict.mean_error) <= 0.01 + 3 * verdict.mean_sigma
    assert verdict.median_error <= 0.01 + 2 * verdict.median_sigma
