# SPDX-License-Identifier: GPL-3.0-or-later
"""Suns that are found in environment images: where they stand, how wide and how bright they are, and what is left."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import placed, square
from tyndall import Progress
from tyndall.environment_suns import NoDominantLightError, find_sun, without_sun
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import (
    Camera,
    CameraKind,
    Image,
    Light,
    LightKind,
    Material,
    SceneDescription,
    World,
)

SKY = np.array([0.4, 0.6, 1.0])
DISC = np.array([900.0, 800.0, 600.0])


def directions(height: int, width: int) -> NDArray[np.float64]:
    """Of texels' centres, (height, width, 3)."""
    longitude = (0.5 - (np.arange(width) + 0.5) / width) * 2 * np.pi
    latitude = ((np.arange(height) + 0.5) / height - 0.5) * np.pi
    lon, lat = np.meshgrid(longitude, latitude)
    return np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1)


def sky_with_disc(
    towards: NDArray[np.float64], half_angle_rad: float, disc: NDArray[np.float64] = DISC, height: int = 128
) -> NDArray[np.float32]:
    """An even sky with an even disc; texels at its rim by their share of it, of 8 x 8 places."""
    fine = 8
    places = directions(height * fine, 2 * height * fine)
    area = np.hypot(places[..., 0], places[..., 1])  # of a place: towards the poles they get narrow
    blocks = [
        (area * weight).reshape(height, fine, 2 * height, fine).sum(axis=(1, 3))
        for weight in (places @ towards > np.cos(half_angle_rad), 1)
    ]
    share = (blocks[0] / blocks[1])[..., None]
    return (SKY + share * (disc - SKY)).astype(np.float32)


def unit(*vector: float) -> NDArray[np.float64]:
    return np.array(vector) / np.linalg.norm(vector)


@pytest.mark.parametrize(
    "towards",
    [unit(1, 0.3, 0.5), unit(-1, 0.001, 0.2), unit(0.2, -1, -0.4), unit(0.015, 0.01, 1), unit(0.06, 0.02, -1)],
    ids=["high", "across the seam", "below", "zenith", "nadir"],
)
@pytest.mark.parametrize("half_angle_rad", [0.06, 0.2])
def test_a_disc_is_found_where_it_stands_with_its_size_and_its_light(
    towards: NDArray[np.float64], half_angle_rad: float
) -> None:
    """A disc of radiance L over a sky of S gives a plane that faces it pi sin^2 (L - S) more than the sky alone.

    Its place is right to a tenth of a texel, 0.0245 rad here, its light to 1 %, and its size to a third of a texel.
    """
    sun = find_sun(sky_with_disc(towards, half_angle_rad))
    assert np.arccos(min(1.0, sun.direction @ towards)) < 0.0025
    assert sun.irradiance == pytest.approx(np.pi * np.sin(half_angle_rad) ** 2 * (DISC - SKY), rel=0.01)
    assert sun.half_angle_rad == pytest.approx(half_angle_rad, abs=0.008)


def test_one_texel_is_a_sun_too() -> None:
    """As wide as a texel, not a point: the sun of a small image."""
    image = np.full((64, 128, 3), 0.1, np.float32)
    image[40, 30] = 1e4
    sun = find_sun(image)
    place = directions(64, 128)[40, 30]
    assert sun.direction @ place == pytest.approx(1.0, abs=1e-9)
    assert 0.01 < sun.half_angle_rad < 0.05


def test_what_is_left_has_no_sun_and_nothing_else_is_touched() -> None:
    image = sky_with_disc(unit(1, 0.3, 0.5), 0.05)
    sun = find_sun(image)
    rest = without_sun(image, sun)
    assert rest == pytest.approx(np.broadcast_to(SKY, rest.shape), rel=1e-6)
    is_kept = np.ones(image.shape[:2], bool)
    is_kept.flat[sun.texels] = False
    assert np.array_equal(rest[is_kept], image[is_kept])
    with pytest.raises(NoDominantLightError, match="equally bright"):
        find_sun(rest)


def test_a_clipped_sun_of_bytes_is_found() -> None:
    """Photographs end at 1: the sun there is what is clipped, among clouds of half its brightness."""
    image = np.clip(sky_with_disc(unit(1, 1, 1), 0.06) * 0.4, 0.0, 1.0)
    sun = find_sun(image)
    assert sun.half_angle_rad == pytest.approx(0.06, abs=0.0123)  # every texel that it touches


@pytest.mark.parametrize("name", ["uniform", "black", "gradient", "half", "noise", "broken"])
def test_an_image_without_a_dominant_light_says_so(name: str) -> None:
    """One message, whatever it is that the image has instead."""
    z = directions(64, 128)[..., 2:]
    image = {
        "uniform": np.full((64, 128, 3), 0.7),
        "black": np.zeros((64, 128, 3)),
        "gradient": np.broadcast_to(1.0 + z, (64, 128, 3)),
        "half": np.broadcast_to(np.where(z > 0, 9.0, 0.1), (64, 128, 3)),
        "noise": 0.5 + 0.1 * np.random.default_rng(1).random((64, 128, 3)),
        "broken": np.full((64, 128, 3), np.nan),
    }[name]
    with pytest.raises(NoDominantLightError):
        find_sun(image.astype(np.float32))


def test_the_threshold_says_how_much_of_a_glow_belongs_to_the_sun() -> None:
    towards = unit(1, 0.3, 0.5)
    angle_rad = np.arccos(np.clip(directions(256, 512) @ towards, -1, 1))[..., None]
    glow = (SKY + 500.0 * np.exp(-((angle_rad / 0.1) ** 2))).astype(np.float32)
    narrow, wide = find_sun(glow, 0.5), find_sun(glow, 0.1)
    assert narrow.half_angle_rad < wide.half_angle_rad
    assert (narrow.irradiance < wide.irradiance).all()


def irradiance(world: World, light: Light | None, normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """On a white plane with that normal, W/m^2; 16,384 shadow rays."""
    side = np.cross(normal, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    place = np.eye(4)
    place[:3, 0], place[:3, 1], place[:3, 2] = side, np.cross(normal, side), normal
    above = place.copy()
    above[:3, 3] = 3 * normal
    description = SceneDescription(
        instances=(placed(square(), place),),
        materials=(Material(name="white", diffuse=(1.0, 1.0, 1.0)),),
        lights=() if light is None else (light,),
        world=world,
    )
    session = Session()
    session.update(description, Progress())
    camera = Camera(
        kind=CameraKind.ORTHOGRAPHIC,
        world_from_camera=above,
        window=(-0.1, 0.1, -0.1, 0.1),
        clip_m=(0.1, 100.0),
        size_px=(8, 8),
    )
    film = session.render(camera, RenderConfig(pixel_samples=256), Progress())
    mean: NDArray[np.float64] = film.planes["Combined"][..., :3].mean(axis=(0, 1)) * np.pi
    return mean


def test_a_surface_that_faces_the_sun_receives_as_much_as_from_the_image() -> None:
    """By Tyndall's own light: the image alone, and its sun with what is left of it. A tilted surface does, too."""
    towards = unit(0.4, 0.3, 0.8)
    image = sky_with_disc(towards, 0.05)
    sun = find_sun(image)
    place = np.eye(4)
    place[:3, 2] = sun.direction
    place[:3, 0] = np.cross([0, 1, 0], sun.direction) / np.linalg.norm(np.cross([0, 1, 0], sun.direction))
    place[:3, 1] = np.cross(sun.direction, place[:3, 0])
    light = Light(
        name="Sun",
        kind=LightKind.SUN,
        strength=tuple(sun.irradiance),
        world_from_light=place,
        half_angle_rad=sun.half_angle_rad,
    )

    def world(pixels: NDArray[np.float32]) -> World:
        rgba = np.concatenate([pixels, np.ones_like(pixels[..., :1])], axis=-1)
        return World(radiance=(1.0, 1.0, 1.0), image=Image(key="sky", name="sky", pixels=rgba, is_srgb=False))

    for normal in (towards, unit(1, 0, 0.3)):
        whole = irradiance(world(image), None, normal)
        parts = irradiance(world(without_sun(image, sun)), light, normal)
        assert parts == pytest.approx(whole, rel=0.005)
    assert irradiance(world(without_sun(image, sun)), None, towards) == pytest.approx(np.pi * SKY, rel=0.005)
