# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky textures look and shine as in Cycles: behind the scene, on a plane and a ball, and the sun's disc itself."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from addon import last_render
from addon.sync.hosek_sky import coefficients, sky_xyz
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.sky_scenes import MODELS, errors, sky, under
from support.small_scenes import read as sent
from tyndall.scene_description import LightKind, SceneDescription

BOUND = 0.01
ELEVATIONS_DEG = [60.0, 14.0, 2.0, -3.0]
#: Turbidity, albedo of the ground, elevation.
HOSEK_SKIES = [
    (1.0, 0.0, 60.0), (2.2, 0.3, 40.0), (3.5, 0.5, 14.0), (5.7, 1.0, 2.0), (7.4, 0.2, 0.5), (9.6, 0.7, 75.0),
    (10.0, 1.0, 25.0), (2.2, 0.3, 90.0), (2.2, 0.3, -3.0),
]  # fmt: skip


def read_with(reader: SceneReader) -> SceneDescription:
    return reader.read(bpy.context.evaluated_depsgraph_get(), Reports(), lambda: None)


@pytest.mark.dealt
@pytest.mark.parametrize("elevation_deg", ELEVATIONS_DEG)
@pytest.mark.parametrize("model", [*MODELS, "PREETHAM"])
def test_every_direction_of_a_sky_is_seen_as_in_cycles(model: str, elevation_deg: float) -> None:
    """To 0.3 % of its mean where it fades below the horizon, closer elsewhere."""
    scene = under(sky(model, elevation_deg), has_things=False)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, 1, seed=1)
    assert ours == pytest.approx(cycles, rel=2e-3, abs=5e-3 * float(cycles.mean()))


@pytest.mark.dealt
@pytest.mark.parametrize("elevation_deg", ELEVATIONS_DEG)
@pytest.mark.parametrize("model", MODELS)
def test_things_below_a_sky_are_lit_as_in_cycles(model: str, elevation_deg: float) -> None:
    """Its sun casts their shadows."""
    scene = under(sky(model, elevation_deg))
    mean, median = errors(tyndall_pixels(scene, 64), cycles_pixels(scene, 256, seed=1))
    print(f"mean {mean:.4f}, median block {median:.4f}")
    assert mean <= BOUND
    assert median <= BOUND


@pytest.mark.parametrize("model", MODELS)
def test_the_disc_is_seen_as_cycles_draws_it(model: str) -> None:
    """Darker towards its limb, redder below; 40 pixels wide, a pixel of its rim may fall in or out."""
    scene = under(sky(model, 3.0, sun_size=math.radians(2.0)), has_things=False)
    scene.camera.data.angle = math.radians(2.5)
    scene.camera.rotation_euler = (math.radians(93.0), 0.0, -0.7)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, 1, seed=1)
    assert cycles.max() > 20.0 * np.median(cycles[:, :4])
    close = np.isclose(ours, cycles, rtol=0.01).all(axis=2)
    assert close.mean() > 0.98


@pytest.mark.dealt
@pytest.mark.parametrize("model", MODELS)
def test_the_sun_of_a_sky_is_one_light_and_an_object_may_stand_for_it(model: str) -> None:
    """It is not lit twice: without its disc the sky has no such light, and an object takes its place."""
    scene = under(sky(model, 30.0, sun_size=0.02))
    [sun] = sent().lights
    assert sun.kind is LightKind.SUN
    assert sun.half_angle_rad == pytest.approx(0.01)
    assert sun.world_from_light[:3, 2] == pytest.approx(
        [math.cos(0.5236) * math.sin(0.7), math.cos(0.5236) * math.cos(0.7), 0.5], abs=2e-3
    )
    before = tyndall_pixels(scene)
    assert bpy.ops.tyndall.sun_from_world() == {"FINISHED"}
    [made] = sent().lights
    assert made.name == scene.world.tyndall.sun.name
    assert made.strength == pytest.approx(sun.strength, rel=1e-3)
    assert tyndall_pixels(scene) == pytest.approx(before, rel=0.02, abs=0.02 * float(before.mean()))
    scene.world.tyndall.takes_sun = False
    assert len(sent().lights) == 2
    next(one for one in scene.world.node_tree.nodes if one.type == "TEX_SKY").sun_disc = False
    assert [one.name for one in sent().lights] == [made.name]


@pytest.mark.dealt
@pytest.mark.parametrize(("turbidity", "albedo", "elevation_deg"), HOSEK_SKIES)
def test_every_direction_of_a_hosek_wilkie_sky_is_seen_as_in_cycles(
    turbidity: float, albedo: float, elevation_deg: float
) -> None:
    scene = under(sky("HOSEK_WILKIE", elevation_deg, turbidity=turbidity, ground_albedo=albedo), has_things=False)
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, 1, seed=1)
    assert ours == pytest.approx(cycles, rel=2e-3, abs=5e-3 * float(cycles.mean()))
    assert "HOSEK" not in " ".join(last_render.statistics_of("Scene")["reports"]).upper()


@pytest.mark.dealt
@pytest.mark.parametrize("elevation_deg", [60.0, 14.0, 2.0])
def test_a_plane_below_a_hosek_wilkie_sky_is_lit_as_in_cycles(elevation_deg: float) -> None:
    """It has no sun of its own: the light is the sky's."""
    scene = under(sky("HOSEK_WILKIE", elevation_deg, turbidity=3.3, ground_albedo=0.4))
    assert not sent().lights
    mean, median = errors(tyndall_pixels(scene, 64), cycles_pixels(scene, 256, seed=1))
    print(f"mean {mean:.4f}, median block {median:.4f}")
    assert mean <= BOUND
    assert median <= BOUND


def test_a_ground_that_throws_light_back_makes_a_hosek_wilkie_sky_brighter() -> None:
    """A sky of half the albedo lies nearly in the middle. Haze whitens it."""
    dark, half, bright = (found_sky(4.0, albedo) for albedo in (0.0, 0.5, 1.0))
    assert (bright > dark).all()
    assert half == pytest.approx(0.5 * (dark + bright), rel=0.1)
    clear, hazy = found_sky(2.0, 0.3), found_sky(9.0, 0.3)
    assert (clear[..., 2] / clear[..., 0]).mean() > 1.2 * (hazy[..., 2] / hazy[..., 0]).mean()


def test_a_hosek_wilkie_sky_has_no_steps_and_is_positive() -> None:
    """Between whole turbidities, and to a sun overhead. On the horizon, one opposite is a little below black."""
    for albedo in (0.0, 0.6, 1.0):
        for elevation_deg in (0.5, 3.0, 30.0, 90.0):
            assert (found_sky(2.6, albedo, elevation_deg) > 0.0).all()
    for turbidity in range(2, 10):
        below, above = (found_sky(turbidity + step, 0.3) for step in (-1e-4, 1e-4))
        assert below == pytest.approx(above, rel=1e-2)
    assert found_sky(11.0, 0.3) == pytest.approx(found_sky(10.0, 0.3))


def found_sky(turbidity: float, albedo: float, elevation_deg: float = 35.0) -> NDArray[np.float64]:
    """XYZ in directions all over the sky."""
    height, azimuth = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(0.0, math.pi, 17))
    sun = math.radians(elevation_deg)
    cosine = height * math.sin(sun) + np.sqrt(1.0 - height**2) * np.cos(azimuth) * math.cos(sun)
    return sky_xyz(coefficients(turbidity, albedo, elevation_deg), height, np.arccos(np.clip(cosine, -1.0, 1.0)))


def test_a_sky_that_did_not_change_is_baked_once() -> None:
    under(sky(MODELS[0], 20.0))
    reader = SceneReader()
    first, second = (read_with(reader) for _ in range(2))
    assert first.world.image is second.world.image
