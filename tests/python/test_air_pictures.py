# SPDX-License-Identifier: GPL-3.0-or-later
"""What who paints the air sees of it: in its place, in its colour, strong where the plane cuts it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tyndall import air_pictures
from tyndall.air_pictures import picture, strength
from tyndall.air_tiles import VOLUME_KINDS

#: Looks down the z axis, without perspective: x and y of clip space are those of the unit cube; near is z = 1.
UNIT_FROM_CLIP = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, -0.5, 0.5], [0, 0, 0, 1]], float)
SIZE_PX = (8, 6)


def plane_at(z: float) -> NDArray[np.float64]:
    return np.array([0.0, 0.0, 1.0, -z])


def painted() -> NDArray[np.float32]:
    """8 x 6 x 10 voxels: 1 at x = 2, y = 1, z = 7, and -1 at x = 5, y = 4, z = 3."""
    values = np.zeros((10, 6, 8), np.float32)
    values[7, 1, 2], values[3, 4, 5] = 1.0, -1.0
    return values


def test_paint_is_seen_at_its_place_in_its_colour() -> None:
    seen = picture(painted(), "amount", UNIT_FROM_CLIP, plane_at(0.5), SIZE_PX)
    assert seen.shape == (6, 8, 4)
    assert sorted(zip(*np.nonzero(seen[..., 3]), strict=True)) == [(1, 2), (4, 5)]
    warm, cool = seen[1, 2], seen[4, 5]
    assert warm[:3] / warm[3] == pytest.approx(air_pictures.ABOVE, abs=1e-6)
    assert cool[:3] / cool[3] == pytest.approx(air_pictures.BELOW, abs=1e-6)


def test_paint_that_the_plane_cuts_is_stronger() -> None:
    for z, strong, faint in ((0.75, (1, 2), (4, 5)), (0.35, (4, 5), (1, 2))):
        seen = picture(painted(), "amount", UNIT_FROM_CLIP, plane_at(z), SIZE_PX)
        assert seen[strong][3] > 2.0 * seen[faint][3] > 0.0


def test_paint_along_the_view_shows_its_strongest() -> None:
    values = np.zeros((10, 6, 8), np.float32)
    values[:, 0, 0] = np.linspace(-0.2, 0.5, 10)
    alone = np.zeros_like(values)
    alone[9, 0, 0] = 0.5
    seen, expected = (picture(one, "amount", UNIT_FROM_CLIP, plane_at(2.0), SIZE_PX) for one in (values, alone))
    assert seen[0, 0] == pytest.approx(expected[0, 0])


def test_nothing_of_a_box_that_is_not_in_the_view_is_seen() -> None:
    """Beside it, and behind the viewer."""
    for moved in (np.array([2.0, 0, 0]), np.array([0, 0, 2.0])):
        unit_from_clip = UNIT_FROM_CLIP.copy()
        unit_from_clip[:3, 3] += moved
        assert not picture(painted(), "amount", unit_from_clip, plane_at(0.5), SIZE_PX).any()


def test_a_viewer_within_the_box_sees_what_is_before_them() -> None:
    """Between the two spots, looking down: the lower one."""
    unit_from_clip = UNIT_FROM_CLIP.copy()
    unit_from_clip[2] = [0.0, 0.0, -0.25, 0.25]  # z = 0.5 is near
    seen = picture(painted(), "amount", unit_from_clip, plane_at(0.2), SIZE_PX)
    assert list(zip(*np.nonzero(seen[..., 3]), strict=True)) == [(4, 5)]


def test_strength_is_nothing_at_neutral_and_never_more_than_one() -> None:
    for name, kind in VOLUME_KINDS.items():
        values = np.linspace(kind.lowest, kind.highest, 101).astype(np.float32)
        strengths = strength(values, name)
        assert np.abs(strengths).max() <= 1.0, name
        assert (np.diff(strengths) > 0.0).all(), name
        assert strength(np.float32([kind.neutral]), name)[0] == 0.0, name
