# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean of films that share a frame's samples is the film of all of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from support.plain_scenes import camera_above, lit_square, placed, square, sun, translation, unit_cube
from tyndall import InvalidInput, Progress
from tyndall.film_means import OF_ONE_FILM, FilmMean, passes_of_parts
from tyndall.renderer import DATA_PASSES, PASSES, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import Material, Medium, ScatterLobe, SceneDescription, World

ALL_PASSES = frozenset(PASSES) - {"Unshadowed"} | frozenset(DATA_PASSES)


def foggy_scene() -> SceneDescription:
    """A square and a box under a sun with a size, in a box of fog, under a world that shines as well."""
    fog = replace(unit_cube(), key="fog")
    return lit_square(
        instances=(
            placed(square(), np.eye(4)),
            placed(unit_cube(), translation(0.3, 0.2, 0.4) @ np.diag([0.4, 0.4, 0.5, 1.0]), materials=(1,)),
            placed(fog, translation(0, 0, -0.5) @ np.diag([3.0, 3.0, 3.0, 1.0]), materials=(2,)),
        ),
        materials=(
            Material(name="grey"),
            Material(name="other"),
            Material(name="fog", has_surface=False, medium=0),
        ),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.3,) * 3, asymmetry_g=0.0),)),),
        world=World(name="world", radiance=(0.2, 0.3, 0.4)),
        lights=(replace(sun(), half_angle_rad=0.3),),
    )


def config_of(**changes: object) -> RenderConfig:
    config = RenderConfig(
        pixel_samples=12,
        passes=ALL_PASSES,
        shafts=ShaftConfig(method="EXACT", light_samples=12, world_samples=24),
        seed=3,
    )
    return replace(config, **changes)  # type: ignore[arg-type]


def mean_of_parts(session: Session, config: RenderConfig, edges: list[int]) -> dict[str, np.ndarray]:
    mean = FilmMean()
    for first, end in pairwise(edges):
        part = replace(config, first_sample=first, sample_count=end - first, passes=passes_of_parts(config.passes))
        film = session.render(camera_above(size_px=(24, 16)), part, Progress())
        mean.add(film.planes, end - first, is_middle=first == 0)
    return mean.mean()


@pytest.mark.parametrize("edges", [[0, 12], [0, 4, 8, 12], [0, 1, 2, 3, 5, 8, 12]])
def test_parts_of_the_samples_make_the_whole_frame(edges: list[int]) -> None:
    """Each sample of the whole is in one part: pixel filter, lights' strata and mattes are the same.

    Seen to fail with the strata of lights dealt out by the samples of a part.
    """
    session = Session()
    session.update(foggy_scene(), Progress())
    whole = session.render(camera_above(size_px=(24, 16)), config_of(), Progress()).planes
    parts = mean_of_parts(session, config_of(), edges)
    assert whole.keys() == parts.keys() - {"Unshadowed"}
    for name, plane in whole.items():
        if name.startswith("Crypto"):  # ids of ranks without a share may be in any order
            assert np.allclose(np.sort(parts[name][..., 1::2]), np.sort(plane[..., 1::2]), atol=1e-6), name
            shown = plane[..., 1::2] > 1e-3
            assert np.array_equal(parts[name][..., 0::2][shown], plane[..., 0::2][shown]), name
        else:
            assert np.allclose(parts[name], plane, rtol=1e-5, atol=1e-6), name


@pytest.mark.parametrize("method", ["EPIPOLAR", "SHADOW_MAP"])
def test_rows_and_maps_of_parts_are_laid_out_anew(method: str) -> None:
    """For the rays of a part's first sample: the same picture within the error of these methods."""
    session = Session()
    session.update(foggy_scene(), Progress())
    config = config_of(shafts=ShaftConfig(method=method, light_samples=12, world_samples=24, resolution=256))
    whole = session.render(camera_above(size_px=(24, 16)), config, Progress()).planes["Shafts"]
    parts = mean_of_parts(session, config, [0, 4, 8, 12])["Shafts"]
    assert np.sqrt(((parts - whole) ** 2).mean()) < 0.01 * whole.mean()
    assert abs(parts.mean() / whole.mean() - 1) < 2e-3


def test_samples_that_a_pixel_has_not_are_refused() -> None:
    session = Session()
    session.update(lit_square(), Progress())
    with pytest.raises(InvalidInput, match="samples 10 to 13 are not among the 12 of a pixel"):
        session.render(camera_above(), config_of(first_sample=10, sample_count=3), Progress())


def test_pixels_stop_within_a_part() -> None:
    """A part of 8 samples has rounds of its own; where pixels stop early, the mean still weighs parts alike.

    What meets no light goes on.
    """
    session = Session()
    session.update(lit_square(), Progress())
    config = config_of(pixel_samples=16, noise_threshold=0.5, passes=frozenset({"Debug Sample Count"}))
    parts = mean_of_parts(session, config, [0, 8, 16])
    whole = session.render(camera_above(size_px=(24, 16)), config_of(pixel_samples=16), Progress()).planes
    assert parts["Debug Sample Count"].min() == pytest.approx(0.5)
    assert parts["Debug Sample Count"].max() == pytest.approx(1.0)
    assert parts["Combined"].mean() == pytest.approx(whole["Combined"].mean(), rel=0.02)


def planes_of(**values: float) -> dict[str, np.ndarray]:
    return {name.replace("_", " "): np.full((1, 1, 1), value, np.float32) for name, value in values.items()}


def test_a_share_of_light_is_weighed_by_that_light() -> None:
    """3 of 4 W/m^2 come through at one moment, none of 1 at another, and a third shows nothing that is lit."""
    mean = FilmMean()
    for shadow, unshadowed in ((0.75, 4.0), (0.0, 1.0), (0.0, 0.0)):
        mean.add(planes_of(Shadow=shadow, Unshadowed=unshadowed), 1.0, is_middle=False)
    assert mean.mean()["Shadow"].item() == pytest.approx(3 / 5)


def test_places_are_those_of_the_middle() -> None:
    """And the first film's until that has come."""
    mean = FilmMean()
    with pytest.raises(ValueError, match="no film"):
        mean.mean()
    for index, is_middle in enumerate((False, True, False)):
        mean.add(planes_of(Depth=index + 1, Mist=index), 1.0, is_middle=is_middle)
        assert mean.mean()["Depth"].item() == (1 if index == 0 else 2)
    assert mean.mean()["Mist"].item() == pytest.approx(1.0)
    assert mean.mean_with(planes_of(Depth=9, Mist=5), 1.0)["Mist"].item() == pytest.approx(2.0)
    assert mean.mean()["Mist"].item() == pytest.approx(1.0)
    assert OF_ONE_FILM.issubset(PASSES + DATA_PASSES)


def test_mattes_are_merged_by_id() -> None:
    """Brute force over random ranks: shares of an id add up, the rest counts for the last rank."""
    generator = np.random.default_rng(5)
    mean = FilmMean()
    expected: list[dict[float, float]] = [{} for _ in range(64)]
    for _ in range(3):
        plane = np.zeros((8, 8, 4), np.float32)
        for pixel, totals in enumerate(expected):
            ids = generator.permutation(np.arange(1, 3))[: generator.integers(0, 3)]
            for rank, name in enumerate(ids):
                share = float(np.float32(generator.random() / 2))
                plane[pixel // 8, pixel % 8, 2 * rank : 2 * rank + 2] = name, share
                totals[float(name)] = totals.get(float(name), 0.0) + share / 3
        mean.add({"CryptoObject00": plane}, 1.0, is_middle=False)
    found = mean.mean()["CryptoObject00"].reshape(64, 2, 2)
    for pixel, totals in enumerate(expected):
        ranked = sorted(totals.items(), key=lambda pair: -pair[1])
        for rank, (name, share) in enumerate(ranked):
            assert found[pixel, rank, 0] == name
            assert found[pixel, rank, 1] == pytest.approx(share, abs=1e-6)


def test_what_finds_no_rank_counts_for_the_last() -> None:
    mean = FilmMean()
    for ids in ((1.0, 2.0), (3.0, 4.0)):
        plane = np.array([[[ids[0], 0.5, ids[1], 0.25]]], np.float32)
        mean.add({"CryptoMaterial00": plane}, 1.0, is_middle=False)
    assert mean.mean()["CryptoMaterial00"].reshape(4).tolist() == [2.0, 0.5, 1.0, 0.25]
