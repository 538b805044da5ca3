# SPDX-License-Identifier: GPL-3.0-or-later
"""A light map is fitted to painted pictures: their places in the scene, their alpha, and what can be wrong there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, placed, square, sun, translation, unit_cube
from tyndall import Cancelled, InvalidInput, Progress
from tyndall.light_map_fit import LightMap, LightMapFit, LightMapFitConfig, StrokeView
from tyndall.renderer import RenderConfig, Session, ShaftConfig
from tyndall.scene_description import (
    EditKind,
    Light,
    LightBody,
    LightKind,
    Material,
    Medium,
    OccluderEdit,
    ScatterLobe,
    SceneDescription,
)

WIDE = np.diag([4.0, 4.0, 1.0, 1.0])
CONFIG = LightMapFitConfig(resolution=64, shafts=ShaftConfig(method="EXACT"))


def fog_on_the_ground(*lights: Light) -> SceneDescription:
    """A metre of fog, 8 m wide, on the ground; the camera looks straight down at it."""
    return SceneDescription(
        instances=(placed(square(), WIDE), placed(unit_cube(), WIDE, materials=(1,))),
        materials=(Material(name="grey"), Material(name="fog", has_surface=False, medium=0)),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.05,) * 3),)),),
        lights=lights or (sun(),),
    )


def session_of(description: SceneDescription) -> Session:
    session = Session()
    session.update(description, Progress())
    return session


def strokes(texels: np.ndarray, name: str = "Strokes") -> StrokeView:
    return StrokeView(name=name, camera=camera_above(size_px=(64, 64)), texels=texels.astype(np.float32))


def left_red_right_blue(width: int = 64, height: int = 64) -> np.ndarray:
    texels = np.zeros((height, width, 4))
    texels[:, : width // 2] = (1.0, 0.1, 0.1, 1.0)
    texels[:, width // 2 :] = (0.1, 0.1, 1.0, 1.0)
    return texels


def fitted(view: StrokeView, config: LightMapFitConfig = CONFIG, current: LightMap | None = None) -> LightMapFit:
    session = session_of(fog_on_the_ground())
    fit = LightMapFit(session, session_name(), [view], Progress(), current=current, config=config)
    fit.iterate(40, Progress())
    return fit


def session_name() -> str:
    return sun().name


def colour_at(light_map: LightMap, x_m: float, y_m: float) -> np.ndarray:
    """The texel below a point of the ground, for a sun straight above its own origin."""
    count = len(light_map.texels)
    places = ((np.array((x_m, y_m)) - light_map.centre_m) / light_map.size_m + 0.5) * count
    column, row = places.astype(int)
    return light_map.texels[row, column]


@pytest.mark.parametrize("method", ["EXACT", "EPIPOLAR", "SHADOW_MAP"])
def test_what_is_painted_over_the_left_lies_in_the_map_on_the_left(method: str) -> None:
    fit = fitted(strokes(left_red_right_blue()), replace(CONFIG, shafts=ShaftConfig(method=method)))
    assert fit.residuals[-1] < 0.1 * fit.residuals[0]
    assert (np.diff(fit.objectives, axis=0) <= 0).all()
    for x_m, expected in ((-0.5, (1.0, 0.1, 0.1)), (0.5, (0.1, 0.1, 1.0))):
        assert colour_at(fit.light_map, x_m, 0.1) == pytest.approx(expected, abs=0.05)
    assert fit.statistics["counts"]["light map fit: stroke pixels"] == 64 * 64


def test_a_picture_of_another_size_lies_over_the_same_frame() -> None:
    same = fitted(strokes(left_red_right_blue())).light_map
    half = fitted(strokes(left_red_right_blue(32, 16))).light_map
    assert (half.size_m, half.centre_m) == (same.size_m, same.centre_m)
    for x_m in (-0.5, 0.5):
        assert colour_at(half, x_m, 0.1) == pytest.approx(colour_at(same, x_m, 0.1), abs=0.1)


def test_alpha_is_the_weight_of_a_pixel_and_colours_are_not_multiplied_with_it() -> None:
    faint = left_red_right_blue()
    faint[..., 3] = 0.25
    assert np.allclose(
        fitted(strokes(faint)).light_map.texels, fitted(strokes(left_red_right_blue())).light_map.texels, atol=1e-3
    )
    faint[:, 32:, 3] = 0.0
    assert colour_at(fitted(strokes(faint)).light_map, 0.5, 0.1) == pytest.approx((1.0,) * 3, abs=0.01)


def test_where_much_is_painted_neighbours_are_taken_together() -> None:
    few = fitted(strokes(left_red_right_blue()), replace(CONFIG, most_pixels=300))
    assert 200 < few.statistics["counts"]["light map fit: stroke pixels"] <= 300
    assert colour_at(few.light_map, -0.5, 0.1) == pytest.approx((1.0, 0.1, 0.1), abs=0.1)


def test_a_fit_that_starts_from_a_map_keeps_its_place_and_what_no_stroke_sees() -> None:
    first = fitted(strokes(left_red_right_blue())).light_map
    mark = first.texels.copy()
    mark[0, 0] = (0.0, 0.5, 0.25)
    again = fitted(strokes(left_red_right_blue()), current=replace(first, texels=mark)).light_map
    assert (again.size_m, again.centre_m) == (first.size_m, first.centre_m)
    assert again.texels[0, 0] == pytest.approx((0.0, 0.5, 0.25))


@pytest.mark.parametrize("method", ["EXACT", "EPIPOLAR", "SHADOW_MAP"])
def test_strokes_see_what_edits_leave_of_the_light(method: str) -> None:
    """Two shutters leave a gap of a metre; an edit that fills holes closes it for the air."""
    shutters = [translation(side * 20.5, 0, 1.2) @ np.diag([20.0, 40.0, 1.0, 1.0]) for side in (-1, 1)]
    open_air = fog_on_the_ground()
    hidden = replace(placed(square("shutter"), *shutters), is_camera_visible=False)
    open_air = replace(open_air, instances=(*open_air.instances, hidden))
    close = OccluderEdit(name="close", kind=EditKind.CLOSE, size_m=1.5)
    closed = replace(open_air, lights=(replace(sun(), occluder_edits=(close,)),))
    config = replace(CONFIG, shafts=ShaftConfig(method=method, resolution=1024))
    view = strokes(left_red_right_blue())
    seen = LightMapFit(session_of(open_air), session_name(), [view], Progress(), config=config).statistics["counts"]
    assert 0 < seen["light map fit: seen texels"] < 0.5 * 64**2  # the gap's
    with pytest.raises(InvalidInput, match="sees air that light"):
        LightMapFit(session_of(closed), session_name(), [view], Progress(), config=config)


def test_a_fit_can_be_stopped_and_goes_on() -> None:
    session = session_of(fog_on_the_ground())
    fit = LightMapFit(session, session_name(), [strokes(left_red_right_blue())], Progress(), config=CONFIG)
    fit.iterate(3, Progress())
    before = fit.light_map.texels
    stopped = Progress()
    stopped.cancel()
    with pytest.raises(Cancelled):
        fit.iterate(3, stopped)
    assert np.array_equal(fit.light_map.texels, before)
    assert fit.iterate(3, Progress())
    assert len(fit.residuals) == 7


def test_what_cannot_be_fitted_is_named() -> None:
    globe = replace(lamp(LightKind.POINT), name="Globe", radius_m=0.2, body=LightBody.SPHERE)
    session = session_of(fog_on_the_ground(sun(), globe))
    view = strokes(left_red_right_blue())

    def refusal(light_name: str, views: list[StrokeView], **settings: object) -> str:
        with pytest.raises(InvalidInput) as caught:
            LightMapFit(session, light_name, views, Progress(), config=replace(CONFIG, **settings))  # type: ignore[arg-type]
        return str(caught.value)

    name = session_name()
    assert "nothing is painted" in refusal(name, [])
    assert "nothing is painted" in refusal(name, [strokes(np.zeros((8, 8, 4)))])
    assert "nothing is painted" in refusal(name, [strokes(np.full((8, 8, 4), np.nan))])
    assert "nothing is painted" in refusal(name, [strokes(np.zeros((0, 0, 4)))])
    assert '"Globe" glows as a sphere' in refusal("Globe", [view])
    assert '"Moon" is not in the scene' in refusal("Moon", [view])
    assert "resolution is 8" in refusal(name, [view], resolution=8)
    assert "regularisation is -1" in refusal(name, [view], regularisation=-1.0)
    not_square = LightMap(texels=np.ones((4, 8, 3), np.float32), size_m=1.0)
    with pytest.raises(InvalidInput, match="a light map is square, not 8 x 4"):
        LightMapFit(session, name, [view], Progress(), current=not_square)


def lamp(kind: LightKind) -> Light:
    """Three metres above the fog, beside its middle, turned around its beam."""
    turn = np.eye(4)
    turn[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    return Light(
        name="Lamp",
        kind=kind,
        strength=(30.0,) * 3,
        world_from_light=translation(0.3, 0.2, 3.0) @ turn,
        spot_half_angle_rad=0.9,
        spot_blend=0.2,
    )


def shafts_of(description: SceneDescription) -> np.ndarray:
    config = RenderConfig(passes=frozenset({"Shafts"}), shafts=ShaftConfig(method="EXACT"), pixel_samples=1)
    film = session_of(description).render(camera_above(size_px=(64, 64)), config, Progress())
    return film.planes["Shafts"]


@pytest.mark.parametrize("kind", [LightKind.SPOT, LightKind.POINT])
def test_a_lamp_throws_what_was_painted_over_its_shafts(kind: LightKind) -> None:
    own = lamp(kind)
    session = session_of(fog_on_the_ground(own))
    fit = LightMapFit(session, "Lamp", [strokes(left_red_right_blue())], Progress(), config=CONFIG)
    fit.iterate(60, Progress())
    assert fit.residuals[-1] < 0.15 * fit.residuals[0]
    assert (np.diff(fit.objectives, axis=0) <= 0).all()
    thrown = replace(own, texture=fit.light_map.texture_of(own, "fitted"))
    share = shafts_of(fog_on_the_ground(thrown)) / shafts_of(fog_on_the_ground(own))
    # But for the rim, and for the border, which a lamp throws as wide as the fog is high.
    assert share[16:48, 8:26].mean(axis=(0, 1)) == pytest.approx((1.0, 0.1, 0.1), abs=0.06)
    assert share[16:48, 40:58].mean(axis=(0, 1)) == pytest.approx((0.1, 0.1, 1.0), abs=0.06)


@pytest.mark.parametrize("kind", [LightKind.SPOT, LightKind.POINT])
def test_a_lamps_picture_is_where_the_next_fit_begins_and_stays_where_nobody_painted(kind: LightKind) -> None:
    own = lamp(kind)
    corner = strokes(np.zeros((64, 64, 4)))
    corner.texels[:20, :20] = (0.0, 1.0, 0.0, 1.0)
    grey = LightMap(texels=np.full((32, 32, 3), 0.5, np.float32))
    tinted = replace(own, texture=grey.texture_of(own, "grey"))
    fit = LightMapFit(session_of(fog_on_the_ground(tinted)), "Lamp", [corner], Progress(), current=grey, config=CONFIG)
    white = fit.residuals[0]
    assert white == pytest.approx(0.5, abs=1e-3)  # (0.5, 0.5, 0.5) where (0, 1, 0) was asked for: the map's own light
    fit.iterate(20, Progress())
    texels = fit.light_map.texels
    assert texels.shape == (64, 64, 3)
    unmoved = np.all(texels == 0.5, axis=-1)
    assert 0.5 < unmoved.mean() < 0.99
    assert texels[~unmoved][:, 1].mean() > 0.7
    assert texels[~unmoved][:, 0].mean() < 0.3
