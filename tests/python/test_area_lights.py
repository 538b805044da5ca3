# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights by way of a scene description: sizes, scales, mirrors, spreads, and what they cannot do."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, lit_square, placed, square, translation, unit_cube
from tyndall import InvalidInput, Progress
from tyndall.light_map_fit import LightMapFit, StrokeView
from tyndall.renderer import RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    Extension,
    Image,
    Light,
    LightKind,
    LightProjection,
    LightTexture,
    Material,
    Medium,
    ScatterLobe,
    SceneDescription,
    TextureUse,
)

ROOF = np.diag([1.0, 1.0, 1.0, 1.0]) @ translation(0, 0, 1.5)


def panel(matrix: np.ndarray = ROOF, **changes: object) -> Light:
    """Above the square, 1 m x 0.5 m, shining down."""
    light = Light(
        name="Panel", kind=LightKind.AREA, strength=(2.0, 1.0, 0.5), world_from_light=matrix, size_m=(1.0, 0.5)
    )
    return replace(light, **changes)  # type: ignore[arg-type]


def picture(*lights: Light, samples: int = 64) -> np.ndarray:
    session = Session()
    session.update(lit_square(lights=lights), Progress())
    film = session.render(camera_above(), RenderConfig(pixel_samples=samples), Progress())
    return film.planes["Combined"][..., :3]


def test_light_arrives_as_the_sum_over_its_surface_says() -> None:
    """In a pixel in the middle, 0.07 m wide, by adding up 200 x 100 points of the light."""
    session = Session()
    session.update(lit_square(lights=(panel(),)), Progress())
    config = RenderConfig(pixel_samples=1024, region_px=(32, 32, 33, 33), pixel_filter="BOX", filter_width_px=1.0)
    seen = session.render(camera_above(size_px=(65, 65)), config, Progress()).planes["Combined"][0, 0, :3]
    x, y = np.meshgrid((np.arange(200) + 0.5) / 200 - 0.5, ((np.arange(100) + 0.5) / 100 - 0.5) * 0.5)
    irradiance = np.mean(1.5**2 / (x**2 + y**2 + 1.5**2) ** 2) * np.array((2.0, 1.0, 0.5))
    assert seen == pytest.approx(irradiance * 0.8 / math.pi, rel=2e-3)


def test_a_scale_makes_it_larger_not_brighter() -> None:
    """So does a larger size; a mirror along one of its sides changes nothing, one along its axis turns it round."""
    scaled = picture(panel(ROOF @ np.diag([2.0, 3.0, 5.0, 1.0])))
    assert picture(panel(size_m=(2.0, 1.5))) == pytest.approx(scaled, rel=1e-4)
    assert picture(panel(ROOF @ np.diag([-2.0, 3.0, 1.0, 1.0]))).mean() == pytest.approx(scaled.mean(), rel=0.01)
    assert not picture(panel(ROOF @ np.diag([1.0, 1.0, -1.0, 1.0]))).any()


def test_a_narrow_spread_lights_what_lies_before_it_alone() -> None:
    """The corners are 2.2 m from the middle; with 4 degrees, the beam is as wide as the panel and 0.1 m more."""
    wide, narrow = picture(panel()), picture(panel(spread_rad=math.radians(4.0)))
    assert narrow[0, 0].max() == 0.0
    assert narrow[3, 3].max() > 2.0 * wide[3, 3].max()


@pytest.mark.parametrize("bad", [{"size_m": (0.0, 1.0)}, {"size_m": (math.nan, 1.0)}, {"spread_rad": math.nan}])
def test_what_has_no_area_is_left_out_and_named(bad: dict[str, object]) -> None:
    session = Session()
    session.update(lit_square(lights=(panel(**bad),)), Progress())
    film = session.render(camera_above(), RenderConfig(pixel_samples=1), Progress())
    assert not film.planes["Combined"][..., :3].any()
    assert any("Panel" in line for line in film.statistics["reports"])


def test_a_picture_that_does_not_lie_on_it_is_refused_with_its_name() -> None:
    image = Image(key="image", name="image", pixels=np.ones((2, 2, 4), np.float32), is_srgb=False)
    session = Session()
    session.update(lit_square(lights=(panel(texture=LightTexture(use=TextureUse(image=image))),)), Progress())
    film = session.render(camera_above(), RenderConfig(pixel_samples=1), Progress())
    (line,) = [line for line in film.statistics["reports"] if "Panel" in line]
    assert "area lights, and no others, show a picture where the light leaves them" in line


def foggy(*lights: Light) -> SceneDescription:
    wide = np.diag([4.0, 4.0, 1.0, 1.0])
    return SceneDescription(
        instances=(placed(square(), wide), placed(unit_cube(), wide, materials=(1,))),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.05,) * 3),)),),
        lights=lights,
    )


def test_its_map_cannot_be_painted() -> None:
    session = Session()
    session.update(foggy(panel()), Progress())
    view = StrokeView(name="Strokes", camera=camera_above(size_px=(16, 16)), texels=np.ones((16, 16, 4), np.float32))
    with pytest.raises(InvalidInput, match=r"Panel.*area light"):
        LightMapFit(session, "Panel", [view], Progress())


def slide() -> LightTexture:
    """Red on one side, blue on the other."""
    pixels = np.zeros((2, 2, 4), np.float32)
    pixels[:, 0, 0] = pixels[:, 1, 2] = pixels[..., 3] = 1.0
    image = Image(key="halves", name="halves", pixels=pixels, is_srgb=False)
    return LightTexture(use=TextureUse(image=image, extension=Extension.EXTEND), projection=LightProjection.EMITTER)


@pytest.mark.parametrize(("spread", "texture"), [(180.0, slide()), (20.0, None)])
def test_the_methods_agree_about_its_shafts(spread: float, texture: LightTexture | None) -> None:
    session = Session()
    session.update(foggy(panel(spread_rad=math.radians(spread), texture=texture)), Progress())

    def shafts(method: str) -> np.ndarray:
        config = ShaftConfig(method=method, light_samples=16, shares_strata=False, resolution=1024)
        wanted = RenderConfig(pixel_samples=4, shafts=config, passes=frozenset({"Shafts"}))
        film = session.render(camera_above(), wanted, Progress())
        return film.planes["Shafts"]

    exact = shafts("EXACT")
    assert exact.min() >= 0.0
    assert exact.mean() > 1e-4
    for method in ("EPIPOLAR", "SHADOW_MAP"):
        assert np.abs(shafts(method) - exact).mean() < 0.005 * exact.mean()
    if texture is not None:  # a red half and a blue one are the light, and nothing of it is green
        session.update(foggy(panel(spread_rad=math.radians(spread))), Progress())
        (red, green, blue), plain = (
            one.reshape(-1, 3).mean(axis=0) / (2.0, 1.0, 0.5) for one in (exact, shafts("EXACT"))
        )
        assert green == 0.0
        assert red + blue == pytest.approx(plain[0], rel=0.01)
