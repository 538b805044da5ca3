# SPDX-License-Identifier: GPL-3.0-or-later
"""Places on a lens that shafts are seen through are spread evenly, whatever their number."""

from __future__ import annotations

import numpy as np
import pytest

from tyndall.lens_points import has_lens_points, lens_point, seen_through
from tyndall.scene_description import Camera, CameraKind, Lens


@pytest.mark.parametrize(("axis", "base"), [(0, 2), (1, 3)])
def test_each_stratum_has_one(axis: int, base: int) -> None:
    for count in (base, base**2, base**4):
        places = np.array([lens_point(index)[axis] for index in range(count)])
        assert sorted(np.floor(places * count + 1e-9)) == list(range(count))


def test_a_disc_of_them_has_no_side() -> None:
    radius_squared, turn = np.array([lens_point(index) for index in range(64)]).T
    at = np.sqrt(radius_squared) * np.exp(2j * np.pi * turn)
    assert abs(at.mean()) < 0.05
    assert (np.abs(at) ** 2).mean() == pytest.approx(0.5, abs=0.02)


def test_only_perspective_cameras_with_a_lens_have_some() -> None:
    lens = Lens(radius_m=0.1, focus_m=2.0)
    for kind in CameraKind:
        camera = Camera(
            kind=kind,
            world_from_camera=np.eye(4),
            window=(-0.5, 0.5, -0.5, 0.5),
            clip_m=(0.1, 100.0),
            size_px=(4, 4),
            lens=lens,
        )
        assert has_lens_points(camera) == (kind == CameraKind.PERSPECTIVE)
        seen = seen_through(camera, (0.25, 0.5)).lens
        assert seen is not None
        assert seen.air_place == (0.25, 0.5)
