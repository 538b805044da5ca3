# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures keep to their formulas at any scale, distance, optical depth and size of lights; see docs/numerics.md."""

from __future__ import annotations

import pytest

from support.numeric_stress import (
    Place,
    area_lamp_error,
    grazing_sun_error,
    lamp_in_fog_error,
    light_along_view_error,
    shaft_error,
    sphere_lamp_error,
    wide_sun_error,
)

METHODS = {"EXACT": 2e-5, "EPIPOLAR": 3e-5, "SHADOW_MAP": 3e-4}
#: Half a float's digits of the distance are rounding; what matters is how many of a scene's sizes fit in.
ROUNDING = 2e-7

each_method = pytest.mark.parametrize("method", METHODS)


# Seen to fail: by powers of ten, where light runs along a face of the fog and pieces keep their slope when rounded.
@each_method
@pytest.mark.parametrize("optical_depth", [1e-6, 1.0, 4.0, 40.0])
def test_shafts_at_any_optical_depth(method: str, optical_depth: float) -> None:
    assert shaft_error(method, Place(), optical_depth).worst < METHODS[method]


# Seen to fail, by up to 60: where terms as steep as they are short took the digits of all others with them.
@each_method
def test_shafts_in_a_mesh_of_fog_along_whose_walls_the_light_runs(method: str) -> None:
    """Rounding turns walls by 1e-7 against the light, one way or the other."""
    for rotation in range(0, 12, 2):
        for scale_m in (0.37, 1.0):
            place = Place(scale_m, rotation=rotation)
            assert shaft_error(method, place, 8.0, is_box=False).worst < 4e-4
            assert shaft_error(method, place, 8.0).worst < 4e-4


@each_method
@pytest.mark.parametrize("is_behind", [True, False], ids=["sun behind", "sun ahead"])
@pytest.mark.parametrize("is_box", [True, False], ids=["box", "mesh"])
def test_light_that_runs_along_the_view(method: str, *, is_behind: bool, is_box: bool) -> None:
    """No plane holds both; there are no shadows that a method could miss."""
    for rotation in range(4):
        place = Place(0.37, rotation=rotation)
        assert light_along_view_error(method, place, 4.0, is_behind=is_behind, is_box=is_box).worst < 1e-5


@each_method
@pytest.mark.parametrize("scale_m", [1e-4, 0.5, 1e7])
def test_shafts_at_any_scale(method: str, scale_m: float) -> None:
    assert shaft_error(method, Place(scale_m), 4.0).worst < METHODS[method]
    assert shaft_error(method, Place(scale_m, from_origin=1e6), 4.0).worst < METHODS[method]


@each_method
@pytest.mark.parametrize("distance", [1e2, 1e4, 1e6])
def test_shafts_from_far_away_lose_what_rounding_takes(method: str, distance: float) -> None:
    assert shaft_error(method, Place(seen_from=distance), 1.0).worst < METHODS[method] + 2.0 * ROUNDING * distance


@pytest.mark.parametrize("place", [Place(1e-4), Place(), Place(1e7), Place(from_origin=1e6), Place(seen_from=1e6)])
@pytest.mark.parametrize("elevation_deg", [60.0, 5.0, 0.5])
def test_no_plane_lies_in_its_own_shadow(place: Place, elevation_deg: float) -> None:
    assert grazing_sun_error(place, elevation_deg).worst < 2e-5


@pytest.mark.parametrize("nearest", [1.0, 1e-2, 1e-5])
def test_fog_past_a_lamp(nearest: float) -> None:
    assert lamp_in_fog_error(Place(), nearest).worst < 1e-3


@pytest.mark.parametrize("scale_m", [1e-4, 1.0, 1e7])
@pytest.mark.parametrize("size", [0.0, 1e-6, 0.1, 0.99])
def test_spheres_of_any_size_and_scale(scale_m: float, size: float) -> None:
    assert sphere_lamp_error(Place(scale_m), size).worst < 2e-5


@pytest.mark.parametrize("scale_m", [1e-4, 1.0, 1e7])
@pytest.mark.parametrize("size", [1e-6, 1.0, 100.0])
def test_areas_of_any_size_and_scale(scale_m: float, size: float) -> None:
    assert area_lamp_error(Place(scale_m), size).worst < 2e-5


@pytest.mark.parametrize("half_angle_rad", [0.0, 1e-6, 0.1, 1.5])
def test_suns_of_any_width(half_angle_rad: float) -> None:
    assert wide_sun_error(Place(), half_angle_rad).worst < 2e-5
