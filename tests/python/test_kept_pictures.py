# SPDX-License-Identifier: GPL-3.0-or-later
"""A session recolours a picture that it has kept, and only where nothing else has changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.plain_scenes import camera_above, lit_square, placed, square, translation, unit_cube
from tyndall import Progress
from tyndall.renderer import Film, RenderConfig, Session
from tyndall.scene_description import Material, Medium, ScatterLobe, SceneDescription
from tyndall.transfer_functions import (
    Axis,
    Constraint,
    Layer,
    LayerKind,
    ParameterAxis,
    TransferFunction,
    Use,
    WeightedFunction,
)

RED = Layer(name="red", colour=(1.0, 0.0, 0.0, 1.0))
GREEN = Layer(name="green", colour=(0.0, 1.0, 0.0, 0.5))


def foggy_square() -> SceneDescription:
    fog = Material(name="fog", has_surface=False, medium=0)
    description = lit_square()
    box = placed(unit_cube(), translation(0, 0, 1), materials=(len(description.materials),))
    return replace(
        description,
        instances=(*description.instances, box),
        materials=(*description.materials, fog),
        media=(Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.1, 0.1, 0.1)),)),),
    )


def config_of(*layers: Layer, **settings: object) -> RenderConfig:
    function = replace(TransferFunction(name="function", layers=layers), **settings)
    return RenderConfig(
        pixel_samples=4, passes=frozenset({"Shafts"}), transfer_functions=(WeightedFunction(function=function),)
    )


def render(session: Session, config: RenderConfig) -> Film:
    return session.render(camera_above(), config, Progress())


def is_recoloured(film: Film) -> bool:
    return [stage["name"] for stage in film.statistics["stages"]] == ["transfer functions"]


@pytest.fixture
def session() -> Session:
    kept = Session(kept_pictures=1)
    kept.update(foggy_square(), Progress())
    return kept


def test_other_layers_on_a_kept_picture_are_what_they_would_have_rendered(session: Session) -> None:
    assert not is_recoloured(render(session, config_of(RED)))
    changed = config_of(RED, GREEN, use=Use.TINT)
    assert session.has_picture(camera_above(), changed)
    recoloured = render(session, changed)
    assert is_recoloured(recoloured)
    fresh = Session()
    fresh.update(foggy_square(), Progress())
    rendered = render(fresh, changed)
    assert not is_recoloured(rendered)
    for name, plane in rendered.planes.items():
        assert np.array_equal(plane, recoloured.planes[name])
    assert recoloured.planes["Shafts"][..., 1].max() > 0.0


def test_other_axes_views_points_and_samples_are_rendered(session: Session) -> None:
    render(session, config_of(RED))
    followed = Layer(name="picked", kind=LayerKind.DIFFUSION, constraints=(Constraint(point=(0.0, 0.0, 0.0)),))
    for other in (
        config_of(RED, y=ParameterAxis(axis=Axis.HEIGHT)),
        config_of(RED, followed),
        replace(config_of(RED), pixel_samples=5),
        replace(config_of(RED), passes=frozenset()),
    ):
        assert not session.has_picture(camera_above(), other)
    assert not session.has_picture(replace(camera_above(), clip_m=(0.2, 900.0)), config_of(RED))
    assert session.has_picture(camera_above(), config_of(GREEN))


def test_a_changed_scene_forgets_its_pictures(session: Session) -> None:
    render(session, config_of(RED))
    session.update(foggy_square(), Progress())
    assert session.has_picture(camera_above(), config_of(RED))
    moved = foggy_square()
    session.update(replace(moved, instances=(placed(square(), translation(0, 0, 0.1)), moved.instances[1])), Progress())
    assert not session.has_picture(camera_above(), config_of(RED))


def test_no_picture_is_kept_unasked() -> None:
    session = Session()
    session.update(foggy_square(), Progress())
    render(session, config_of(RED))
    assert not session.has_picture(camera_above(), config_of(RED))


def test_a_layer_that_cannot_be_used_is_left_out_by_name(session: Session) -> None:
    broken = Layer(name="broken", colour=(float("nan"), 0.0, 0.0, 1.0))
    film = render(session, config_of(RED, broken))
    assert any('"function"' in line and '"broken"' in line for line in film.statistics["reports"])
    for name, plane in render(session, config_of(RED)).planes.items():
        assert np.array_equal(plane, film.planes[name])


def test_a_ray_is_where_the_picture_shows_it(session: Session) -> None:
    config = config_of(RED, y=ParameterAxis(axis=Axis.DEPTH, range_m=(0.0, 20.0)))
    found = session.ray_parameters(camera_above(), config, np.array([[4.5, 4.5], [0.5, 7.5]], np.float32), Progress())
    depth = session.render(camera_above(), RenderConfig(pixel_samples=1, passes=frozenset({"Depth"})), Progress())
    assert found.shape == (2, 2)
    assert found[0, 1] == pytest.approx(depth.planes["Depth"][4, 4, 0] / 20.0, rel=1e-5)
