# SPDX-License-Identifier: GPL-3.0-or-later
"""Is it right? Combined equals Cycles with direct light and single scattering, within Cycles' own noise.

On every push twenty scenes, dealt out to the versions of Blender, meet every kind of light, medium, camera and occluder
at least once, by EXACT and by EPIPOLAR. The long tests change one thing at a time, and then try all pairs of a light
with a medium, an occluder or a camera: where one of the twenty fails, they tell which part of it is wrong. A failure
leaves a picture in out/cycles_agreement: ours, Cycles', and ten times the difference (red: ours is brighter).
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
    Arrangement,
    build,
)
from support.agreement_shapes import OCCLUDERS
from support.cycles_reference import (
    BLOCK_PX,
    CYCLES_SAMPLES,
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
SURFACE_SAMPLES |= {"area": 128, "area disk 50 degrees": 128, "area ellipse, scaled": 128}
SURFACE_SAMPLES |= {"spot in a can": 128, "point in a shelf": 128, "world": 256, "world image": 256}
#: Light from everywhere takes many directions: a quarter of the pixels, four times as many directions, and of Cycles 16
#: times as many samples (in 3.4 the mean of 256 was off by 0.3 %, of 1,024 by 0.01 %).
SMALL = {"world", "world image"}
#: Of lamps with something inside them each stratum is 150 discs, in as many cells of directions.
LIGHT_SAMPLES = {"spot in a can": 64, "point in a shelf": 64}
#: Their cells are as wide as the error target asks for: half as wide as with the default, where Cycles is less noisy.
FINE_ERROR_TARGET = 5e-4
#: A verdict that leaves out more pixels than this says little.
MOST_LEFT_OUT = 0.2

#: Every light, medium, camera and occluder once or more.
EVERYTHING_ONCE = (
    Arrangement("sun", "camera inside", "orthographic", "grid"),
    Arrangement("sun 2 degrees", "principled", "perspective", "instances"),
    Arrangement("sun 20 degrees", "absorption", "shifted", "monkey"),
    Arrangement("point", "g 0.8", "towards light", "alpha"),
    Arrangement("point 0.2 m", "none", "perspective", "glass"),
    Arrangement("point", "two phases", "orthographic", "monkey"),
    Arrangement("spot", "two colours", "perspective", "none"),
    Arrangement("spot blend 0.5", "sphere", "towards light", "grid"),
    Arrangement("spot 0.1 m", "dense", "shifted", "instances"),
    Arrangement("spot 120 degrees", "thin", "perspective", "grid"),
    Arrangement("spot 180 degrees", "camera inside", "orthographic", "grid"),
    Arrangement("area", "camera inside", "perspective", "grid"),
    Arrangement("area disk 50 degrees", "camera outside", "towards light", "grid"),
    Arrangement("area ellipse, scaled", "g 0.8", "orthographic", "monkey"),
    Arrangement("spot in a can", "camera inside", "perspective", "none"),
    Arrangement("point in a shelf", "camera inside", "orthographic", "none"),
    Arrangement("world", "camera outside", "perspective", "monkey"),
    Arrangement("world image", "g -0.5", "perspective", "grid"),
    Arrangement("many", "coloured", "orthographic", "glass"),
    Arrangement("sun", "emission", "perspective", "glow"),
)
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
#: Its diffuse rays do not see the glowing box (support/agreement_scenes.py), and Cycles sends such rays to the world as
#: well as to lights: half of the world's light then passes the box undimmed. Glow or not, that makes 8 % of difference;
#: with a box that diffuse rays see and that does not glow, 0.004 %.
NOT_COMPARABLE = {Arrangement(light=light, medium="emission") for light in SMALL}
PAIRS = tuple(
    [Arrangement(light=light, medium=medium) for light in LIGHTS for medium in MEDIA]
    + [Arrangement(light=light, occluder=occluder) for light in LIGHTS for occluder in OCCLUDERS]
    + [Arrangement(light=light, camera=camera) for light in LIGHTS for camera in CAMERAS]
)
METHODS = ("EXACT", "EPIPOLAR", "SHADOW_MAP")
#: Enough where a scene is judged by noise of less than a thousandth.
FEW_CYCLES_SAMPLES = 64


def check(arrangement: Arrangement, methods: tuple[str, ...], cycles_samples: int = CYCLES_SAMPLES) -> None:
    if arrangement.medium == "two phases" and bpy.app.version < (4, 0, 0):
        # There it is 4 % brighter than ours, which agrees with Cycles 4.5 and 5.0; what it does is not known.
        pytest.skip("Cycles 3.4 disagrees with Cycles 4.5 about overlapping media of two phase functions")
    is_small = arrangement.light in SMALL
    scene = build(arrangement, *((48, 27) if is_small else (96, 54)))
    world_samples = 1024 if is_small else 512
    if is_small:
        cycles_samples = max(cycles_samples, 16 * FEW_CYCLES_SAMPLES)
    cycles = cycles_pixels(scene, cycles_samples, seed=1), cycles_pixels(scene, cycles_samples, seed=2)
    on_edges = pixels_on_edges(scene)
    if arrangement.light in LIGHT_SAMPLES and cycles_samples > FEW_CYCLES_SAMPLES:
        scene.tyndall.shafts.error_target = FINE_ERROR_TARGET
    surface_samples = SURFACE_SAMPLES.get(arrangement.light, 1)
    samples = {
        "surface_samples": surface_samples,
        "light_samples": LIGHT_SAMPLES.get(arrangement.light, min(256, 2 * cycles_samples)),
        "world_samples": world_samples,
    }
    firsts = tyndall_pixels(scene, methods, **samples)
    seconds = firsts  # a light without a size is not sampled
    if arrangement.light in SURFACE_SAMPLES:
        seconds = tyndall_pixels(scene, methods, **samples, seed=1)
    failures = []
    for method, first, second in zip(methods, firsts, seconds, strict=True):
        verdict = agreement((first, second), cycles, on_edges, cycles_samples)
        print(f"{arrangement}, {method}: {verdict}")
        if not verdict.holds:
            failures.append(f"{method}: {verdict}")
            name = re.sub(r"\W+", "_", f"{bpy.app.version_string} {arrangement} {method}")
            save_side_by_side(PICTURES / f"{name}.png", (first + second) / 2, (cycles[0] + cycles[1]) / 2)
    assert on_edges.mean() < MOST_LEFT_OUT
    assert not failures, "\n".join(failures)


def test_everything_is_met_once() -> None:
    """No light, medium, camera or occluder is left to the long tests alone."""
    for kinds, met in (
        (LIGHTS, {each.light for each in EVERYTHING_ONCE}),
        (MEDIA, {each.medium for each in EVERYTHING_ONCE}),
        (CAMERAS, {each.camera for each in EVERYTHING_ONCE}),
        (OCCLUDERS, {each.occluder for each in EVERYTHING_ONCE}),
    ):
        assert met == set(kinds)


@pytest.mark.dealt
@pytest.mark.parametrize("arrangement", EVERYTHING_ONCE, ids=str)
def test_equals_cycles(arrangement: Arrangement) -> None:
    """EXACT is the truth of all our other tests; here it, and the method of final renders, meet another renderer."""
    check(arrangement, ("EXACT", "EPIPOLAR"), FEW_CYCLES_SAMPLES)


@pytest.mark.long
@pytest.mark.parametrize("arrangement", ONE_BY_ONE, ids=str)
def test_each_alone_equals_cycles(arrangement: Arrangement) -> None:
    """One thing differs from the plainest scene; all methods, with their default settings."""
    check(arrangement, METHODS)


@pytest.mark.long
@pytest.mark.parametrize(
    "arrangement", [pair for pair in dict.fromkeys(PAIRS) if pair not in {*ONE_BY_ONE, *NOT_COMPARABLE}], ids=str
)
def test_pairs_equal_cycles(arrangement: Arrangement) -> None:
    """Lights with every medium, every occluder and every camera."""
    check(arrangement, ("EXACT",))


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
