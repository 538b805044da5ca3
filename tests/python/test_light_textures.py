# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures before lights reach the native side, are kept, and never cost their light."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, lit_square, placed, square, sun
from tyndall import Progress
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import Image, Light, LightTexture, SceneDescription, TextureUse


def picture(colour: tuple[float, float, float] = (0.25, 0.5, 1.0)) -> Image:
    pixels = np.ones((4, 4, 4), np.float32)
    pixels[..., :3] = colour
    return Image(key=str(colour), name="Gobo", pixels=pixels)


def described(light: Light) -> SceneDescription:
    return lit_square(instances=(placed(square(), np.diag([20.0, 20.0, 1.0, 1.0])),), lights=(light,))


def mean_colour(session: Session) -> np.ndarray:
    film = session.render(camera_above(), RenderConfig(pixel_samples=1), Progress())
    return film.planes["Combined"][..., :3].mean(axis=(0, 1))


def test_a_picture_of_one_colour_tints_its_light_and_is_sent_once() -> None:
    session = Session()
    plain = sun()
    session.update(described(plain), Progress())
    white = mean_colour(session)
    texture = LightTexture(use=TextureUse(image=picture()))
    session.update(described(replace(plain, texture=texture)), Progress())
    np.testing.assert_allclose(mean_colour(session), white * (0.25, 0.5, 1.0), rtol=1e-5)
    assert session.statistics["counts"]["images sent"] == 1
    faded = replace(texture, offset=(0.5, 0.5, 0.5), gain=0.5 * np.eye(3))
    session.update(described(replace(plain, texture=faded)), Progress())
    np.testing.assert_allclose(mean_colour(session), white * (0.625, 0.75, 1.0), rtol=1e-5)
    assert session.statistics["counts"]["images sent"] == 0
    assert session.statistics["counts"]["images reused"] == 1


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"width_m": 0.0}, "size_m"),
        ({"width_m": float("nan")}, "size_m"),
        ({"centre_m": (float("inf"), 0.0)}, "its centre is not finite"),
        ({"gain": np.full((3, 3), np.nan)}, "its colours are not finite"),
        ({"axes_from_world": np.full((3, 3), np.nan)}, "its mapping is not finite"),
    ],
)
def test_a_picture_that_cannot_be_laid_out_leaves_its_light_white(change: dict[str, object], says: str) -> None:
    session = Session()
    plain = sun()
    session.update(described(plain), Progress())
    white = mean_colour(session)
    broken = replace(LightTexture(use=TextureUse(image=picture())), **change)
    session.update(described(replace(plain, texture=broken)), Progress())
    np.testing.assert_array_equal(mean_colour(session), white)
    film = session.render(camera_above(), RenderConfig(pixel_samples=1), Progress())
    (report,) = [line for line in film.statistics["reports"] if "texture" in line]
    assert report.startswith(f'Light "{plain.name}": its texture is left out: ')
    assert says in report
