# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights that are not worth a ray at every sample are asked at some alone: fewer rays, the same picture in the mean."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, lit_square, placed, square, translation, unit_cube
from tyndall import Progress
from tyndall.renderer import Film, RenderConfig, Session
from tyndall.scene_description import Light, LightKind, SceneDescription

SIZE_PX = (48, 32)
#: Of a lamp; the strongest outshines the others.
POWERS = (40.0, *[1.0 + 0.1 * lamp for lamp in range(15)])


def hall() -> SceneDescription:
    """A ring of lamps above a block on a floor."""
    lamps = tuple(
        Light(
            name=f"lamp {index}",
            kind=LightKind.POINT,
            strength=(power, 0.8 * power, 0.6 * power),
            world_from_light=translation(3.0 * math.cos(0.4 * index), 3.0 * math.sin(0.4 * index), 3.0),
            radius_m=0.3,
        )
        for index, power in enumerate(POWERS)
    )
    floor = placed(square(), np.diag([3.0, 3.0, 1.0, 1.0]))
    return lit_square(instances=(floor, placed(unit_cube(), np.diag([0.5, 0.5, 0.5, 1.0]))), lights=lamps)


def rendered(scene: SceneDescription, session: Session | None = None, **settings: object) -> Film:
    session = session or Session()
    session.update(scene, Progress())
    config = RenderConfig(pixel_samples=16)
    return session.render(camera_above(size_px=SIZE_PX), replace(config, **settings), Progress())  # type: ignore[arg-type]


def combined(film: Film) -> np.ndarray:
    return film.planes["Combined"][..., :3].astype(np.float64)


def rays(film: Film) -> float:
    return float(film.statistics["counts"]["direct light: shadow rays per surface point"])


@pytest.mark.parametrize("noise_threshold", [0.0, 0.005])
def test_fewer_rays_find_the_same_light(noise_threshold: float) -> None:
    scene = hall()
    all_asked = rendered(scene, noise_threshold=noise_threshold)
    in_turns = rendered(scene, noise_threshold=noise_threshold, lights_take_turns=True)
    assert rays(all_asked) >= len(POWERS)
    assert rays(in_turns) <= (0.75 if noise_threshold else 0.5) * rays(all_asked)
    converged = combined(rendered(scene, pixel_samples=256))
    for film in (all_asked, in_turns):
        assert combined(film).mean() == pytest.approx(converged.mean(), rel=0.004)
        blocks = [picture.reshape(8, 4, 12, 4, 3).mean((1, 3)) for picture in (combined(film), converged)]
        assert np.abs(blocks[0] - blocks[1]).max() < 0.08 * converged.mean()


def test_few_samples_ask_every_light() -> None:
    scene = hall()
    few = rendered(scene, pixel_samples=4)
    assert np.array_equal(combined(few), combined(rendered(scene, pixel_samples=4, lights_take_turns=True)))


def test_one_light_has_no_turns() -> None:
    scene = hall()
    alone = replace(scene, lights=scene.lights[:1])
    assert np.array_equal(combined(rendered(alone)), combined(rendered(alone, lights_take_turns=True)))


def test_kept_surfaces_and_tiles_have_the_same_bits() -> None:
    scene = hall()
    whole = combined(rendered(scene, lights_take_turns=True))
    kept = Session(kept_pictures=2)
    for _ in range(2):
        assert np.array_equal(combined(rendered(scene, kept, lights_take_turns=True)), whole)
    dimmer = replace(scene, lights=(replace(scene.lights[0], strength=(30.0, 20.0, 10.0)), *scene.lights[1:]))
    assert np.array_equal(
        combined(rendered(dimmer, kept, lights_take_turns=True)), combined(rendered(dimmer, lights_take_turns=True))
    )
    tile = rendered(scene, lights_take_turns=True, region_px=(9, 5, 30, 22), is_tile=True)
    assert np.array_equal(combined(tile), whole[5:22, 9:30])


def test_what_is_shown_on_the_way_has_asked_every_light() -> None:
    """Of several times as many samples as a turn has, each picture on the way has all of the light."""
    shown: list[float] = []
    session = Session()
    session.update(hall(), Progress())
    config = RenderConfig(pixel_samples=16, lights_take_turns=True)  # of many more, strong ones get rays instead
    camera = camera_above(size_px=(600, 400))
    film = session.render(camera, config, Progress(), on_update=lambda film: shown.append(float(combined(film).mean())))
    assert shown
    assert rays(film) < len(POWERS)
    assert shown == pytest.approx([float(combined(film).mean())] * len(shown), rel=0.02)
