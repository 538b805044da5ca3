# SPDX-License-Identifier: GPL-3.0-or-later
"""The brush in space: what an ellipsoid covers, and what strokes leave behind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tyndall.air_brush import MODES, AirBrush, Stroke
from tyndall.air_tiles import VOLUME_KINDS, tile_block, tile_count

AMOUNT, INTENSITY = VOLUME_KINDS["amount"], VOLUME_KINDS["intensity"]
SIDE_M = 8.0
#: A box of 8 m around the origin.
WORLD_FROM_UNIT = np.array([[SIDE_M, 0, 0, -4], [0, SIDE_M, 0, -4], [0, 0, SIDE_M, -4], [0, 0, 0, 1]], float)
VOXELS = 64
VOXEL_M = SIDE_M / VOXELS
UP = np.array([0.0, 0.0, 1.0])
HARD = AirBrush(value=0.75, radius_m=1.0, depth_m=1.0, hardness=1.0)
SOFT = replace(HARD, hardness=0.3)


def even(value: float = 0.0, voxels: int = VOXELS) -> NDArray[np.float32]:
    return np.full((voxels,) * 3, value, np.float32)


def begin(brush: AirBrush, before: NDArray[np.float32] | None = None, normal: NDArray[np.float64] = UP) -> Stroke:
    return Stroke(even() if before is None else before, AMOUNT, WORLD_FROM_UNIT, normal, brush)


def stroke(brush: AirBrush, *places_m: object, before: NDArray[np.float32] | None = None) -> NDArray[np.float32]:
    """Through places, with full pressure."""
    painting = begin(brush, before)
    for place_m in places_m:
        painting.move_to(np.asarray(place_m, float))
    return painting.values


def centres_m() -> NDArray[np.float64]:
    """(3, nz, ny, nx): x, y, z."""
    at = (np.arange(VOXELS) + 0.5) * VOXEL_M - SIDE_M / 2
    z, y, x = np.meshgrid(at, at, at, indexing="ij")
    return np.stack([x, y, z])


@pytest.mark.parametrize(("radius_m", "depth_m"), [(2.0, 2.0), (2.5, 0.8), (0.9, 3.0)])
def test_a_hard_dab_has_the_volume_of_its_ellipsoid(radius_m: float, depth_m: float) -> None:
    """4/3 pi r^2 d, up to the voxels that its surface crosses: their error is random."""
    painted = stroke(replace(HARD, radius_m=radius_m, depth_m=depth_m), (0.1, -0.2, 0.3)) != 0.0
    expected_m3 = 4.0 / 3.0 * np.pi * radius_m**2 * depth_m
    surface_voxels = 4.0 * np.pi * max(radius_m, depth_m) ** 2 / VOXEL_M**2
    assert abs(painted.sum() * VOXEL_M**3 - expected_m3) < 3.0 * np.sqrt(surface_voxels) * VOXEL_M**3


def test_a_soft_dab_holds_what_its_falloff_integrates_to() -> None:
    """Of a ball: 4 pi r^3 times the integral of falloff(q) q^2, found by a fine sum."""
    q = (np.arange(100_000) + 0.5) / 100_000
    t = np.clip((q - SOFT.hardness) / (1.0 - SOFT.hardness), 0.0, 1.0)
    expected_m3 = 4.0 * np.pi * 2.0**3 * np.mean((1.0 - t * t * (3.0 - 2.0 * t)) * q * q) * SOFT.value
    painted = stroke(replace(SOFT, radius_m=2.0, depth_m=2.0), (0.1, -0.2, 0.3))
    assert painted.sum(dtype=float) * VOXEL_M**3 == pytest.approx(expected_m3, rel=1e-4)


def test_the_ellipsoid_is_as_deep_along_the_normal_as_the_brush_says() -> None:
    """Whichever way the view looks: each voxel, against its distance in the ellipsoid's own axes."""
    random = np.random.default_rng(1)
    place_m = np.array([0.3, -0.2, 0.1])
    for _ in range(5):
        normal = random.normal(size=3)
        painting = begin(replace(HARD, radius_m=2.0, depth_m=0.7), normal=normal)
        painting.move_to(place_m)
        offset = centres_m() - place_m[:, None, None, None]
        along = np.tensordot(normal / np.linalg.norm(normal), offset, 1)
        distance = np.sqrt(((offset**2).sum(0) - along**2) / 2.0**2 + along**2 / 0.7**2)
        is_clear = np.abs(distance - 1.0) > 1e-5
        assert np.array_equal((painting.values != 0.0)[is_clear], (distance < 1.0)[is_clear])


def test_a_dab_is_symmetric() -> None:
    """In the middle of the box, under all mirrors and turns of the cube, up to rounding."""
    painted = stroke(SOFT, (0.0, 0.0, 0.0))
    assert painted.max() == pytest.approx(SOFT.value)
    for same in (painted[::-1], painted[:, ::-1], painted[..., ::-1], painted.transpose(1, 0, 2), painted.T):
        assert np.abs(same - painted).max() < 1e-5


def test_a_box_that_is_scaled_and_turned_is_painted_where_the_world_says() -> None:
    """A ball in metres, in a box of 8 m by 4 m by 2 m that is turned by a third: where it is, and how large."""
    turn = np.eye(4)
    turn[:2, :2] = np.array([[0.5, -(0.75**0.5)], [0.75**0.5, 0.5]])
    world_from_unit = turn @ np.diag([1.0, 0.5, 0.25, 1.0]) @ WORLD_FROM_UNIT
    painting = Stroke(even(), AMOUNT, world_from_unit, UP, replace(HARD, radius_m=0.8, depth_m=0.8))
    place_m = (turn @ [1.0, 0.5, 0.1, 1.0])[:3]
    painting.move_to(place_m)
    z, y, x = np.nonzero(painting.values)
    unit = np.stack([x, y, z, np.full(len(x), VOXELS - 0.5)]) + 0.5
    seen_m = (world_from_unit @ (unit / VOXELS))[:3]
    assert np.linalg.norm(seen_m - place_m[:, None], axis=0).max() <= 0.8 + 1e-5
    assert np.abs(seen_m.mean(1) - place_m).max() < 0.01
    voxel_m3 = SIDE_M**3 / 8.0 / VOXELS**3
    assert len(x) * voxel_m3 == pytest.approx(4.0 / 3.0 * np.pi * 0.8**3, rel=0.02)


def test_a_hard_brush_at_full_opacity_sets_the_value_exactly() -> None:
    """Whatever was there; beyond it, nothing has changed by a bit."""
    before = np.random.default_rng(2).uniform(-1.0, 1.0, (VOXELS,) * 3).astype(np.float32)
    after = stroke(HARD, (0.5, 0.5, 0.5), (1.0, 0.5, 0.5), before=before)
    is_painted = after != before
    assert set(after[is_painted].tolist()) == {0.75}
    assert 0.0 < is_painted.mean() < 0.1


def test_the_eraser_restores_neutral_exactly() -> None:
    before = np.random.default_rng(3).uniform(0.0, 9.0, (VOXELS,) * 3).astype(np.float32)
    painting = Stroke(before, INTENSITY, WORLD_FROM_UNIT, UP, replace(HARD, mode="ERASE", radius_m=9.0, depth_m=9.0))
    painting.move_to(np.zeros(3))
    assert (painting.values == INTENSITY.neutral).all()


def test_what_the_modes_do_at_half_coverage() -> None:
    """In the middle of the brush, from 0.5 and with a value of 0.25."""
    expected = {"PAINT": 0.375, "ADD": 0.625, "MULTIPLY": 0.3125, "ERASE": 0.25, "SMOOTH": 0.5}
    for mode in MODES:
        after = stroke(replace(HARD, mode=mode, value=0.25, opacity=0.5), (0, 0, 0), before=even(0.5))
        assert after[32, 32, 32] == pytest.approx(expected[mode], abs=1e-6), mode


def test_nothing_leaves_the_range_of_its_volume() -> None:
    after = stroke(replace(HARD, mode="ADD", value=5.0), (0, 0, 0), before=even(0.5))
    assert after.max() == 1.0
    assert stroke(replace(HARD, value=-3.0), (0, 0, 0)).min() == -1.0


def test_smoothing_keeps_what_is_even_and_calms_what_is_not() -> None:
    """Also at the border of the box, where nothing is averaged with what is not there."""
    wide = replace(HARD, mode="SMOOTH", radius_m=9.0, depth_m=9.0)
    assert np.abs(stroke(wide, (0, 0, 0), before=even(0.7)) - 0.7).max() < 1e-6
    noise = np.random.default_rng(4).uniform(-1.0, 1.0, (VOXELS,) * 3).astype(np.float32)
    calm = stroke(wide, (0, 0, 0), before=noise)
    assert calm.std() < 0.1 * noise.std()
    assert abs(calm.mean() - noise.mean()) < 0.002


def test_a_stroke_that_crosses_itself_stays_at_its_opacity() -> None:
    """Ten times over the same place: no more than once; a second stroke covers half of the rest."""
    half = replace(HARD, value=1.0, opacity=0.5)
    path = [(0, 0, 0), (1, 0, 0)] * 5
    once = stroke(half, *path)
    assert set(once[once != 0.0].tolist()) == {0.5}
    twice = stroke(half, *path, before=once)
    assert set(twice[twice != 0.0].tolist()) == {0.75}


@pytest.mark.parametrize("brush", [SOFT, replace(SOFT, pressure_sizes=True, pressure_fades=True)])
def test_a_straight_stroke_does_not_depend_on_how_the_moves_are_sampled(brush: AirBrush) -> None:
    """Two moves or two hundred, at unequal steps, with a pressure that grows along the way.

    With pressure the nearest point of a part is not exactly that of the widest coverage: a radius that grows by 0.13 m
    per metre moves it by up to 0.13 m, over which the opacity grows by 2 %, and the distance shrinks by 1 %.
    """
    begin_m, end_m = np.array([-2.0, -1.0, 0.2]), np.array([2.0, 1.5, 0.2])
    strokes = []
    for shares in (np.linspace(0, 1, 2), np.linspace(0, 1, 201), np.sort(np.random.default_rng(5).random(40))):
        painting = begin(brush)
        for share in (0.0, *shares, 1.0):
            painting.move_to(begin_m + (end_m - begin_m) * share, 0.4 + 0.6 * share)
        strokes.append(painting.values)
    bound = 0.03 if brush.pressure_sizes else 1e-5
    assert max(np.abs(strokes[0] - other).max() for other in strokes[1:]) < bound


def test_a_stroke_has_no_beads() -> None:
    """Along its axis a soft stroke of two far moves is as even as the voxels let it be."""
    painted = stroke(SOFT, (-2.9375, 0.0625, 0.0625), (2.9375, 0.0625, 0.0625))
    axis = painted[32, 32, 9:55]
    assert axis == pytest.approx(np.full(46, SOFT.value), abs=1e-6)
    rim = painted[32, 37, 9:55]
    assert 0.1 < rim.mean() < 0.7
    assert np.ptp(rim) < 1e-5


def test_pressure_scales_size_and_opacity_only_where_asked() -> None:
    def painted_with(pressure: float, **switches: bool) -> NDArray[np.float32]:
        painting = begin(replace(HARD, radius_m=2.0, depth_m=2.0, **switches))
        painting.move_to(np.zeros(3), pressure)
        return painting.values

    whole = painted_with(1.0)
    assert np.array_equal(painted_with(0.5), whole)
    assert painted_with(0.5, pressure_fades=True).max() == 0.375
    smaller = painted_with(0.5, pressure_sizes=True)
    assert np.array_equal(smaller, stroke(replace(HARD, radius_m=1.0, depth_m=1.0), (0, 0, 0)))
    assert np.array_equal(painted_with(1.0, pressure_sizes=True, pressure_fades=True), whole)


def test_a_pen_that_is_pressed_on_the_way_draws_a_cone() -> None:
    """From no pressure to all of it along x: as wide at each place as the pressure there, for two moves or twenty."""
    for count in (1, 19):
        painting = begin(replace(HARD, pressure_sizes=True))
        for share in np.linspace(0.0, 1.0, count + 1):
            painting.move_to(np.array([-3.0 + 6.0 * share, VOXEL_M / 2, VOXEL_M / 2]), share)
        x_m = (np.arange(VOXELS) + 0.5) * VOXEL_M - SIDE_M / 2
        widths_m = (painting.values[32] != 0.0).sum(0) * VOXEL_M
        inside = (x_m > -2.0) & (x_m < 2.5)
        assert np.abs(widths_m - 2.0 * (x_m + 3.0) / 6.0)[inside].max() < 2.0 * VOXEL_M


def test_only_touched_tiles_change() -> None:
    """Seen at every tile, for strokes at random places; at least one that is not touched is left alone."""
    random = np.random.default_rng(6)
    for _ in range(10):
        painting = begin(SOFT)
        for place_m in random.uniform(-4.0, 4.0, (3, 3)):
            painting.move_to(place_m)
        changed = {
            index
            for index in range(tile_count(painting.values.shape))
            if painting.values[tile_block(index, painting.values.shape)].any()
        }
        assert changed <= painting.touched
        assert len(painting.touched) < tile_count(painting.values.shape)


def test_outside_the_box_nothing_changes_and_the_stroke_says_so() -> None:
    painting = begin(HARD)
    assert not painting.move_to(np.array([6.0, 0.0, 0.0]))
    assert not painting.move_to(np.array([6.0, 5.0, 0.0]))
    assert not painting.touched
    assert not painting.values.any()
    assert painting.move_to(np.array([-6.0, 0.0, 0.0]))  # right through the box
    assert painting.touched


def test_the_finest_brush_still_paints() -> None:
    """One that is smaller than a voxel holds at least one centre, wherever it is."""
    random = np.random.default_rng(7)
    fine = replace(HARD, radius_m=1e-3, depth_m=1e-3)
    for place_m in random.uniform(-4.0, 4.0, (50, 3)):
        count = int((stroke(fine, place_m) != 0.0).sum())
        assert 1 <= count <= 8


def test_what_was_there_before_is_not_written_to() -> None:
    before = even(0.25)
    before.flags.writeable = False
    stroke(HARD, (0, 0, 0), before=before)
    assert (before == 0.25).all()
