# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture of the air through a session: what it multiplies, what it leaves alone, and what it refuses."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import camera_above, lit_square, placed, square, translation, unit_cube
from tyndall import InvalidInput, Progress
from tyndall.heterogeneity import AirNoise, Heterogeneity, PaintedAir
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import Material, Medium, ScatterLobe, SceneDescription
from tyndall.transfer_functions import Layer, TransferFunction, Use, WeightedFunction

NOISE = AirNoise(scale_m=0.5, resolution=32)
#: The whole of foggy_plates().
BOX = ((4.0, 0.0, 0.0, -2.0), (0.0, 4.0, 0.0, -2.0), (0.0, 0.0, 4.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def foggy_plates(place: NDArray[np.float64] | None = None) -> SceneDescription:
    """A square under a box of fog, 4 m high, half of it in the shadow of a plate."""
    at = np.eye(4) if place is None else place
    fog = Material(name="fog", has_surface=False, medium=0)
    description = lit_square()
    scaled = np.diag([2.0, 2.0, 4.0, 1.0])
    return replace(
        description,
        instances=(
            placed(square(), at, at @ translation(-1.2, 0, 3)),
            placed(unit_cube(), at @ scaled, materials=(len(description.materials),)),
        ),
        materials=(*description.materials, fog),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.1, 0.1, 0.1)),)),),
    )


def config_of(heterogeneity: Heterogeneity | None, **changes: object) -> RenderConfig:
    config = RenderConfig(
        pixel_samples=1,
        passes=frozenset({"Shafts", "Depth"}),
        shafts=ShaftConfig(method="EXACT"),
        heterogeneity=heterogeneity,
    )
    return replace(config, **changes)


def render(session: Session, config: RenderConfig) -> Film:
    return session.render(camera_above(size_px=(24, 24)), config, Progress())


@pytest.fixture
def session() -> Session:
    kept = Session(kept_pictures=2)
    kept.update(foggy_plates(), Progress())
    return kept


def painted(key: str, **values: float) -> PaintedAir:
    arrays = {name: np.full((3, 4, 5), value, np.float32) for name, value in values.items()}
    return PaintedAir(key=key, world_from_unit=BOX, **arrays)


def test_noise_textures_the_shafts_and_nothing_else(session: Session) -> None:
    plain = render(session, config_of(None)).planes
    textured = render(session, config_of(Heterogeneity(noise=NOISE))).planes
    assert np.array_equal(plain["Depth"], textured["Depth"])
    assert np.abs(textured["Shafts"] - plain["Shafts"]).max() > 0.03 * plain["Shafts"].max()
    surfaces = plain["Combined"][..., :3] - plain["Shafts"]
    assert textured["Combined"][..., :3] - textured["Shafts"] == pytest.approx(surfaces, abs=1e-6)


@pytest.mark.parametrize(
    "neutral",
    [
        Heterogeneity(noise=NOISE, amount=0.0),
        Heterogeneity(noise=NOISE, amount=0.0, level=3.0, moved_m=(1.0, 2.0, 3.0), upsampling=4, step_count=7),
        Heterogeneity(noise=NOISE, amount=0.0, painted=painted("levels", level=2.0, intensity=1.0, amount=-0.5)),
    ],
)
def test_without_an_amount_no_bit_of_the_picture_changes(session: Session, neutral: Heterogeneity) -> None:
    plain = render(session, config_of(None)).planes
    film = render(session, config_of(neutral))
    for name, plane in plain.items():
        assert np.array_equal(plane, film.planes[name])
    assert {"what": "heterogeneity", "reason": "it is 1 everywhere"} in film.statistics["skipped"]


@pytest.mark.parametrize("upsampling", [1, 4])
def test_painted_intensity_scales_the_shafts_inside_its_box(session: Session, upsampling: int) -> None:
    plain = render(session, config_of(None)).planes["Shafts"]
    wanted = Heterogeneity(noise=NOISE, amount=0.0, upsampling=upsampling, painted=painted("strong", intensity=2.5))
    assert render(session, config_of(wanted)).planes["Shafts"] == pytest.approx(2.5 * plain, rel=1e-5)
    beside = replace(painted("beside", intensity=2.5), world_from_unit=tuple(map(tuple, translation(50, 0, 0))))
    wanted = replace(wanted, painted=beside)
    assert render(session, config_of(wanted)).planes["Shafts"] == pytest.approx(plain, rel=1e-5)


def test_light_that_a_transfer_function_replaces_keeps_the_texture(session: Session) -> None:
    layer = Layer(name="red", colour=(1.0, 0.5, 0.25, 1.0))
    functions = (WeightedFunction(function=TransferFunction(name="red", layers=(layer,), use=Use.REPLACE)),)
    air = Heterogeneity(noise=NOISE)
    plain = render(session, config_of(None)).planes["Shafts"]
    textured = render(session, config_of(air)).planes["Shafts"]
    replaced = render(session, config_of(None, transfer_functions=functions)).planes["Shafts"]
    both = render(session, config_of(air, transfer_functions=functions)).planes["Shafts"]
    lit = plain[..., 0] > 1e-3
    assert lit.sum() > 100
    assert both[lit] == pytest.approx((replaced * textured / np.maximum(plain, 1e-9))[lit], rel=1e-4)
    # Another layer on the kept picture: the same as rendered anew.
    green = replace(layer, colour=(0.0, 1.0, 0.0, 1.0))
    changed = (WeightedFunction(function=replace(functions[0].function, layers=(green,))),)
    assert session.has_picture(camera_above(size_px=(24, 24)), config_of(air, transfer_functions=changed))
    kept = render(session, config_of(air, transfer_functions=changed)).planes["Shafts"]
    fresh = Session()
    fresh.update(foggy_plates(), Progress())
    assert np.array_equal(kept, render(fresh, config_of(air, transfer_functions=changed)).planes["Shafts"])


def test_another_texture_is_another_picture(session: Session) -> None:
    air = Heterogeneity(noise=NOISE, painted=painted("some", amount=-0.2))
    config = config_of(air, transfer_functions=(WeightedFunction(function=TransferFunction(name="none")),))
    render(session, config)
    camera = camera_above(size_px=(24, 24))
    assert session.has_picture(camera, config)
    same_key = replace(air, painted=painted("some", amount=-0.9))  # keys tell what is painted, not the arrays
    assert session.has_picture(camera, replace(config, heterogeneity=same_key))
    for other in (
        None,
        replace(air, moved_m=(0.1, 0.0, 0.0)),
        replace(air, painted=painted("more", amount=-0.2)),
        replace(air, painted=replace(painted("some", amount=-0.2), world_from_unit=tuple(map(tuple, np.eye(4))))),
    ):
        assert not session.has_picture(camera, replace(config, heterogeneity=other))


def test_a_scene_far_from_the_origin_has_the_same_air() -> None:
    far = (80000.0, -30000.0, 500.0)
    place = translation(*far)
    box = tuple(map(tuple, place @ np.array(BOX)))
    pictures = []
    for description, camera, moved_m, matrix in (
        (foggy_plates(), camera_above(size_px=(24, 24)), (0.0, 0.0, 0.0), BOX),
        (foggy_plates(place), camera_above(place, size_px=(24, 24)), far, box),
    ):
        half = replace(painted(f"{moved_m}", amount=-1.0), world_from_unit=matrix)
        half.amount[:, :, :2] = 0.0  # type: ignore[index]
        session = Session()
        session.update(description, Progress())
        air = Heterogeneity(noise=NOISE, moved_m=moved_m, painted=half)
        pictures.append(session.render(camera, config_of(air), Progress()).planes["Shafts"])
    # The scene's own space begins elsewhere: floats know its places to some 1e-6 m, noise to 1e-5 of a feature.
    assert pictures[1] == pytest.approx(pictures[0], rel=2e-3)


@pytest.mark.parametrize("upsampling", [1, 2, 8])
def test_a_region_is_a_crop_of_the_textured_picture(session: Session, upsampling: int) -> None:
    config = config_of(Heterogeneity(noise=NOISE, upsampling=upsampling), pixel_samples=2)
    full = render(session, config).planes["Combined"]
    crop = render(session, replace(config, region_px=(5, 7, 18, 21))).planes["Combined"]
    assert np.array_equal(crop, full[7:21, 5:18])


@pytest.mark.parametrize(
    ("changes", "culprit"),
    [
        ({"amount": 1.5}, "amount of heterogeneity is 1.5"),
        ({"amount": float("nan")}, "amount of heterogeneity is nan"),
        ({"level": 9.0}, "level of heterogeneity is 9"),
        ({"intensity": -1.0}, "intensity of heterogeneity is -1"),
        ({"step_count": 0}, "step_count of heterogeneity is 0"),
        ({"step_count": -3}, "step_count of heterogeneity is -3"),
        ({"upsampling": 3}, "upsampling of heterogeneity is 3"),
        ({"upsampling": 32}, "upsampling of heterogeneity is 32"),
        ({"weighting": "SOME"}, 'weighting of heterogeneity is "SOME"'),
        ({"moved_m": (0.0, float("inf"), 0.0)}, "moved_m of the air"),
        ({"noise": AirNoise(scale_m=0.0)}, "scale_m of the air's noise is 0"),
        ({"noise": AirNoise(octaves=9)}, "octaves of the air's noise is 9"),
        ({"noise": AirNoise(octaves=-1)}, "octaves of the air's noise is -1"),
        ({"noise": AirNoise(contrast=-1.0)}, "contrast of the air's noise is -1"),
        ({"noise": AirNoise(persistence=2.0)}, "persistence of the air's noise is 2"),
        ({"noise": AirNoise(resolution=100)}, "resolution of the air's noise is 100"),
        ({"noise": AirNoise(resolution=1024)}, "resolution of the air's noise is 1024"),
    ],
)
def test_a_number_out_of_its_range_is_named(session: Session, changes: dict[str, object], culprit: str) -> None:
    with pytest.raises(InvalidInput, match=culprit.replace("(", r"\(")):
        render(session, config_of(replace(Heterogeneity(noise=NOISE), **changes)))


def broken_paint() -> list[tuple[PaintedAir, str]]:
    with_nan = painted("nan", amount=0.5)
    with_nan.amount[2, 1, 3] = np.nan  # type: ignore[index]
    flat = tuple(map(tuple, np.diag([1.0, 1.0, 0.0, 1.0])))
    infinite = tuple(map(tuple, np.diag([1.0, np.inf, 1.0, 1.0])))
    return [
        (with_nan, r"the painted amount is nan at voxel \(3, 1, 2\)"),
        (painted("level", level=9.0), "the painted level is 9 at voxel"),
        (painted("intensity", intensity=-0.5), "the painted intensity is -0.5 at voxel"),
        (replace(painted("flat", amount=0.5), world_from_unit=flat), "flat"),
        (replace(painted("infinite", amount=0.5), world_from_unit=infinite), "not finite"),
        (replace(painted("picture"), amount=np.zeros((4, 4), np.float32)), r"amount must be .* shape \(n, n, n\)"),
    ]


@pytest.mark.parametrize(("paint", "culprit"), broken_paint())
def test_painted_air_that_cannot_be_used_is_left_out_by_name(session: Session, paint: PaintedAir, culprit: str) -> None:
    air = Heterogeneity(noise=NOISE)
    film = render(session, config_of(replace(air, painted=paint)))
    (report,) = [line for line in film.statistics["reports"] if line.startswith("Painted air is left out: ")]
    assert re.search(culprit, report)
    assert np.array_equal(film.planes["Shafts"], render(session, config_of(air)).planes["Shafts"])
