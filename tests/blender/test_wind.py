# SPDX-License-Identifier: GPL-3.0-or-later
"""The wind carries the texture of the air without a jump, and in loops."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from addon.animation_paths import curves_at
from addon.properties.heterogeneity import SCALE_PATH, WIND_PATH, TyndallHeterogeneity
from support.textured_air import at, key_wind, read, textured_air
from tyndall.heterogeneity import AirNoise


@pytest.fixture
def air() -> TyndallHeterogeneity:
    """The texture of a scene at 24 frames a second, switched on."""
    return textured_air()


@pytest.mark.parametrize(("fps", "fps_base"), [(24, 1.0), (30, 1.001), (60, 1.0)])
@pytest.mark.parametrize("frame", [0, 1, 48.25, -12, 100_000])
def test_a_steady_wind_carries_the_texture_with_the_clock(
    air: TyndallHeterogeneity, fps: int, fps_base: float, frame: float
) -> None:
    """Speed times seconds since frame 0, to the subframe, at whatever frame rate."""
    render = bpy.context.scene.render
    render.fps, render.fps_base = fps, fps_base
    air.wind_m_per_s = (0.5, 0.0, -2.0)
    seconds = frame / (fps / render.fps_base)
    assert at(frame).moved_m == pytest.approx((0.5 * seconds, 0.0, -2.0 * seconds), rel=1e-6)


def test_wind_that_freshens_covers_the_area_under_its_curve(air: TyndallHeterogeneity) -> None:
    """From 0 to 6 m/s within two seconds it carries 6 m; after its last key it goes on at 6 m/s."""
    key_wind((0, 0.0), (48, 6.0))
    assert at(48).moved_m[0] == pytest.approx(6.0)
    assert at(24).moved_m[0] == pytest.approx(1.5)
    assert at(12.5).moved_m[0] == pytest.approx(6.0 * (12.5 / 48) ** 2, rel=2e-3)
    assert at(72).moved_m[0] == pytest.approx(12.0)
    assert at(-24).moved_m[0] == 0.0


def test_what_was_keyed_before_frame_0_and_after_it_counts_from_there(air: TyndallHeterogeneity) -> None:
    """Keys anywhere, on fractions of frames, too: straight pieces are integrated exactly."""
    key_wind((-10, 1.0), (6.5, 3.0), (30, -1.0))
    curve = curves_at(bpy.context.scene, WIND_PATH)[0]
    for frame in (-30.0, -4.5, 3.0, 6.5, 18.25, 30.0, 55.0):
        places = np.linspace(0.0, frame, 20_001)
        values = [curve.evaluate(place) for place in places]
        exact = float(np.sum(0.5 * (np.diff(places)) * (np.array(values[:-1]) + values[1:]))) / 24.0
        assert at(frame).moved_m[0] == pytest.approx(exact, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("interpolation", ["CONSTANT", "LINEAR", "BEZIER"])
def test_gusts_never_make_the_texture_jump(air: TyndallHeterogeneity, interpolation: str) -> None:
    """From one subframe to the next it moves no farther than the strongest wind carries it; speed times time would."""
    key_wind((1, 0.5), (100, 4.0), (101, 0.1), (150, -3.0), interpolation=interpolation)
    frames = np.arange(95.0, 160.0, 0.25)
    moved_m = np.array([at(frame).moved_m[0] for frame in frames])
    assert np.abs(np.diff(moved_m)).max() <= 4.0 * 0.25 / 24.0 * 1.01
    at_present_speed = []
    for frame in frames:
        at(frame)
        at_present_speed.append(air.wind_m_per_s[0] * frame / 24.0)
    assert np.abs(np.diff(at_present_speed)).max() > 1.0, "the wind would not tell one from the other"


def test_a_frame_has_the_same_texture_whichever_renders_first(air: TyndallHeterogeneity) -> None:
    """Backwards, by jumps, again: it depends on the frame alone, so that a farm's machines agree."""
    curve = key_wind((1, 0.5), (20, 4.0), (50, -1.0), interpolation="BEZIER")
    curve.modifiers.new("NOISE")
    frames = [1, 17, 20, 33.5, 80]
    forwards = {frame: at(frame).moved_m for frame in frames}
    assert {frame: at(frame).moved_m for frame in reversed(frames)} == forwards
    assert len(set(forwards.values())) == len(frames)


def test_wind_can_be_keyed_along_one_axis_alone(air: TyndallHeterogeneity) -> None:
    """The others blow steadily; a curve that is muted does not count."""
    key_wind((0, 0.0), (48, 6.0), axis=2)
    air.wind_m_per_s[0] = 1.0
    assert at(48).moved_m == pytest.approx((2.0, 0.0, 6.0))
    curves_at(bpy.context.scene, WIND_PATH)[0].mute = True
    air.wind_m_per_s[2] = 3.0
    assert at(48).moved_m == pytest.approx((2.0, 0.0, 6.0))
    assert at(24).moved_m == pytest.approx((1.0, 0.0, 3.0))


def test_wind_without_a_past_is_taken_as_steady_and_says_so(air: TyndallHeterogeneity) -> None:
    """A driver knows the present only. The report names the scene, and what to do."""
    bpy.context.scene.driver_add(WIND_PATH, 0).driver.expression = "2.0"
    bpy.context.scene.frame_set(48)
    heterogeneity, lines = read()
    assert heterogeneity.moved_m == (4.0, 0.0, 0.0)
    assert len(lines) == 1
    assert lines[0].startswith('Scene "Scene": its wind is driven')
    assert lines[0].endswith("Keyframe it, or drive the offset instead")


def test_wind_in_a_strip_is_taken_as_steady_and_says_so(air: TyndallHeterogeneity) -> None:
    """As if it were driven; not once its track is muted."""
    key_wind((0, 1.0), (48, 1.0))
    animation = bpy.context.scene.animation_data
    track = animation.nla_tracks.new()
    track.strips.new("Gust", 0, animation.action)
    animation.action = None
    bpy.context.scene.frame_set(24)
    heterogeneity, lines = read()
    assert heterogeneity.moved_m[0] == pytest.approx(1.0)
    assert len(lines) == 1
    track.mute = True
    assert read()[1] == ()


@pytest.mark.parametrize("wind_m_per_s", [(1.0, 0.1, 0.0), (-4.2, 1.8, 3.0), (0.01, -0.02, 0.0)])
def test_a_looped_wind_covers_whole_periods_of_the_noise(
    air: TyndallHeterogeneity, wind_m_per_s: tuple[float, ...]
) -> None:
    """From the first frame to the one after the last; no others but none at all are nearer to what it was."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps, scene.render.fps_base = 11, 250, 30, 1.001
    air.scale_m, air.wind_m_per_s = 1.5, wind_m_per_s
    wanted_m = np.subtract(at(251).moved_m, at(11).moved_m)
    assert bpy.ops.tyndall.loop_wind() == {"FINISHED"}
    way_m = np.subtract(at(251).moved_m, at(11).moved_m)
    counts = np.stack(np.meshgrid(*[np.arange(-5, 6)] * 3), axis=-1).reshape(-1, 3)
    ways_m = counts[counts.any(axis=1)] @ AirNoise(scale_m=1.5).periods_m
    nearest_m = ways_m[np.linalg.norm(ways_m - wanted_m, axis=1).argmin()]
    assert way_m == pytest.approx(nearest_m, abs=1e-4)
    bpy.ops.tyndall.loop_wind()  # again: it loops already
    assert np.subtract(at(251).moved_m, at(11).moved_m) == pytest.approx(way_m, abs=1e-5)


def test_only_a_wind_that_stays_can_be_looped(air: TyndallHeterogeneity) -> None:
    """The button says what stands against it: nothing to carry, no wind, one that is keyed, noise that grows."""
    scene = bpy.context.scene
    assert not bpy.ops.tyndall.loop_wind.poll(), "there is no wind"
    air.wind_m_per_s = (1.0, 0.0, 0.0)
    assert bpy.ops.tyndall.loop_wind.poll()
    for path in (WIND_PATH, SCALE_PATH):
        scene.keyframe_insert(path, frame=1)
        with pytest.raises(RuntimeError, match="is animated: a loop needs one that stays"):
            bpy.ops.tyndall.loop_wind()
        scene.animation_data_clear()
    scene.driver_add(WIND_PATH, 0)
    assert not bpy.ops.tyndall.loop_wind.poll()
    scene.animation_data_clear()
    air.is_enabled = False
    assert not bpy.ops.tyndall.loop_wind.poll()
