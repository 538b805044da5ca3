# SPDX-License-Identifier: GPL-3.0-or-later
"""Is it right? Combined equals Cycles with direct light and single scattering, within Cycles' own noise.

Every kind of light, medium, camera and occluder is compared once with the rest of the scene kept plain; all pairs of a
light with a medium, an occluder or a camera are among the long tests. A failure leaves a picture in
out/cycles_agreement: ours, Cycles', and ten times the difference (red: ours is brighter).
"""

from __future__ import annotations

import re
from pathlib import Path

import bpy
import numpy as np
import pytest

from support.agreement_scenes import (
    CAMERAS,
    LIGHTS,
    MEDIA,
    OCCLUDERS,
    Arrangement,
    build,
)
from support.cycles_reference import (
    BLOCK_PX,
    agreement,
    block_means,
    cycles_pixels,
    pixels_on_edges,
    save_side_by_side,
    tyndall_pixels,
)

PICTURES = Path(__file__).parents[2] / "out" / "cycles_agreement"
#: Ours per pixel, on surfaces: under a light with a size they are sampled, as in Cycles.
SURFACE_SAMPLES = {"point 0.2 m": 128, "spot 0.1 m": 128, "sun 2 degrees": 128, "sun 20 degrees": 256, "many": 64}
SURFACE_SAMPLES |= {"world": 512, "world image": 512}
#: A verdict that leaves out more pixels than this says little.
MOST_LEFT_OUT = 0.2

PLAIN = Arrangement()
ONE_BY_ONE = tuple(
    dict.fromkeys(
        [Arrangement(light=light) for light in LIGHTS]
        + [Arrangement(medium=medium) for medium in MEDIA]
        + [Arrangement(camera=camera) for camera in CAMERAS]
        + [Arrangement(occluder=occluder) for occluder in OCCLUDERS]
        # Where a light's and a camera's geometry meet, or a light's and a medium's: cases of their own in the code.
        + [Arrangement(light=light, camera="orthographic") for light in ("point", "spot")]
        + [Arrangement(light=light, camera="towards light") for light in ("sun", "spot")]
        + [Arrangement(light="point", medium=medium) for medium in ("camera outside", "two colours", "g 0.8")]
        + [
            Arrangement(light="spot", medium="sphere", occluder="alpha"),
            Arrangement(light="point", occluder="glass"),
        ]
        + [
            Arrangement(light="point", occluder="alpha"),
        ]
    )
)
#: Other versions than 4.5 differ in how scenes reach us and in a few formulas (spot lights), not in the core.
FEW = tuple(
    [
        Arrangement(light=light)
        for light in (
            "sun",
            "point",
            "point 0.2 m",
            "spot",
            "spot blend 0.5",
            "world image",
        )
    ]
    + [Arrangement(medium=medium) for medium in ("principled", "emission", "two colours")]
    + [Arrangement(camera="shifted"), Arrangement(camera="orthographic")]
    + [Arrangement(occluder=occluder) for occluder in ("instances", "alpha", "glass")]
)
PAIRS = tuple(
    [Arrangement(light=light, medium=medium) for light in LIGHTS for medium in MEDIA]
    + [Arrangement(light=light, occluder=occluder) for light in LIGHTS for occluder in OCCLUDERS]
    + [Arrangement(light=light, camera=camera) for light in LIGHTS for camera in CAMERAS]
)
HERE = ONE_BY_ONE if bpy.app.version[:2] == (4, 5) else FEW
#: Minutes of Cycles: scripts/test.sh --all judges them.
pytestmark = pytest.mark.long


def check(arrangement: Arrangement, method: str = "EXACT") -> None:
    scene = build(arrangement)
    cycles = cycles_pixels(scene, seed=1), cycles_pixels(scene, seed=2)
    on_edges = pixels_on_edges(scene)
    ours_first = tyndall_pixels(scene, method, surface_samples=SURFACE_SAMPLES.get(arrangement.light, 1))
    ours_second = ours_first  # a light without a size is not sampled
    if arrangement.light in SURFACE_SAMPLES:
        ours_second = tyndall_pixels(scene, method, surface_samples=SURFACE_SAMPLES[arrangement.light], seed=1)
    verdict = agreement((ours_first, ours_second), cycles, on_edges)
    print(f"{arrangement}, {method}: {verdict}")
    if not verdict.holds:
        name = re.sub(r"\W+", "_", f"{bpy.app.version_string} {arrangement} {method}")
        save_side_by_side(PICTURES / f"{name}.png", (ours_first + ours_second) / 2, (cycles[0] + cycles[1]) / 2)
    assert on_edges.mean() < MOST_LEFT_OUT
    assert verdict.holds, str(verdict)


@pytest.mark.parametrize("arrangement", HERE, ids=str)
def test_equals_cycles(arrangement: Arrangement) -> None:
    """EXACT is the truth of all our other tests; here it meets another renderer."""
    check(arrangement)


@pytest.mark.parametrize("method", ["EPIPOLAR", "SHADOW_MAP"])
@pytest.mark.parametrize("light", ["sun", "point", "spot"])
def test_faster_methods_equal_cycles_too(light: str, method: str) -> None:
    """With their default settings: their error is smaller than what the bounds allow."""
    check(Arrangement(light=light), method)


@pytest.mark.long
@pytest.mark.parametrize("arrangement", [pair for pair in dict.fromkeys(PAIRS) if pair not in HERE], ids=str)
def test_pairs_equal_cycles(arrangement: Arrangement) -> None:
    """Lights with every medium and every occluder."""
    check(arrangement)


def test_verdict_accepts_noise_and_rejects_a_bias() -> None:
    """The judge itself: a picture that differs by noise passes, one that is half a percent too bright does not."""
    random = np.random.default_rng(1)
    truth = 0.2 + random.random((90, 90, 3))
    first, second, ours = (truth * (1 + 0.02 * random.normal(size=truth.shape)) for _ in range(3))
    assert agreement((truth, truth), (first, second)).holds
    assert not agreement((truth * 1.005, truth * 1.005), (first, second)).holds
    spoiled = truth.copy()
    spoiled[:BLOCK_PX, :BLOCK_PX] *= 1.05  # one block in a hundred
    assert not agreement((spoiled, spoiled), (first, second)).holds
    assert abs(block_means(ours).mean() / ours.mean() - 1) < 1e-12
