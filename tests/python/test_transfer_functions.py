# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions become native ones and pictures; what cannot be used costs its layer or function, and no other."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tyndall import InvalidInput, _native
from tyndall.native_transfer_functions import build_weighted_functions, compose
from tyndall.scene_description import Image
from tyndall.transfer_functions import (
    Axis,
    BlendMode,
    Constraint,
    GradientShape,
    Layer,
    LayerKind,
    ParameterAxis,
    TransferFunction,
    WeightedFunction,
)

ORIGIN = np.zeros(3)
RED = (1.0, 0.0, 0.0, 1.0)


def solid(name: str = "solid", colour: tuple[float, float, float, float] = RED) -> Layer:
    return Layer(name=name, colour=colour)


def image(key: str = "image", shape: tuple[int, int, int] = (4, 4, 4)) -> Image:
    values = np.random.default_rng(1).random(shape, dtype=np.float32)
    return Image(key=key, name=key, pixels=values, is_srgb=False, has_alpha=True)


def built(*functions: TransferFunction) -> tuple[list[_native.WeightedFunction], list[str]]:
    reports: list[str] = []
    weighted = [WeightedFunction(function=function) for function in functions]
    return build_weighted_functions(weighted, ORIGIN, {}, reports), reports


def test_what_has_no_say_composes_to_nothing() -> None:
    for layers in ((), (replace(solid(), opacity=0.0),), (solid(colour=(1.0, 1.0, 1.0, 0.0)),)):
        assert not compose(TransferFunction(name="f", layers=layers), 3).any()


def test_a_picture_has_the_first_axis_along_its_rows_and_the_second_up() -> None:
    ramp = ((0.0, 0.0, 0.0, 1.0), RED)
    across = Layer(name="x", kind=LayerKind.GRADIENT, ramp=ramp)
    up = Layer(name="y", kind=LayerKind.GRADIENT, ramp=ramp, start=(0.5, 0.0), end=(0.5, 1.0))
    centres = (np.arange(8) + 0.5) / 8
    for layer, expected in ((across, centres[None, :]), (up, centres[:, None])):
        picture = compose(TransferFunction(name="f", layers=(layer,)), 8)
        assert picture.shape == (8, 8, 4)
        assert picture.dtype == np.float32
        np.testing.assert_allclose(picture[..., 0], np.broadcast_to(expected, (8, 8)), atol=1e-6)


def test_every_kind_of_layer_arrives_with_its_numbers() -> None:
    painted = image(shape=(16, 16, 4))
    layers = (
        Layer(name="image", kind=LayerKind.IMAGE, image=painted, opacity=0.5),
        Layer(
            name="ring",
            kind=LayerKind.GRADIENT,
            ramp=((0.0, 0.0, 0.0, 0.0), RED, (0.0, 0.0, 0.0, 0.0)),
            shape=GradientShape.RADIAL,
            start=(0.5, 0.5),
            end=(0.5, 1.0),
            mode=BlendMode.ADD,
        ),
    )
    picture = compose(TransferFunction(name="f", layers=layers[:1]), 16)
    alpha = painted.pixels[..., 3:]
    np.testing.assert_allclose(picture[..., 3:], 0.5 * alpha, atol=1e-5)
    np.testing.assert_allclose(picture[..., :3], 0.5 * alpha * painted.pixels[..., :3], atol=1e-5)
    with_ring = compose(TransferFunction(name="f", layers=layers), 16)
    added = (with_ring - picture)[..., 0]
    assert added[8, 12] > 10 * abs(added[8, 7])  # on the ring, and in its middle


def test_a_diffusion_layer_meets_its_constraints_where_they_are() -> None:
    places = {(0.25, 0.125): RED, (0.75, 0.5): (0.0, 2.0, 0.0, 0.5), (0.125, 0.875): (0.0, 0.0, 1.0, 1.0)}
    constraints = tuple(Constraint(position=place, colour=colour) for place, colour in places.items())
    layer = Layer(name="spread", kind=LayerKind.DIFFUSION, constraints=constraints)
    size = 256
    picture = compose(TransferFunction(name="f", layers=(layer,)), size)
    for (x, y), (red, green, blue, alpha) in places.items():
        i, j = int(x * size), int(y * size)  # the place is a corner between four texels
        around = picture[j - 1 : j + 1, i - 1 : i + 1].mean(axis=(0, 1))
        np.testing.assert_allclose(around, (red * alpha, green * alpha, blue * alpha, alpha), atol=5e-3)


@pytest.mark.parametrize(
    ("layer", "reason"),
    [
        (solid("broken", (math.nan, 0.0, 0.0, 1.0)), "colour is nan, outside [0, 1e+06]"),
        (
            Layer(name="broken", kind=LayerKind.DIFFUSION, constraints=(Constraint(position=(0.5, -0.5)),)),
            "constraint 0's y is -0.5, outside [0, 1]",
        ),
        (Layer(name="broken", kind=LayerKind.GRADIENT, ramp=(RED,)), "its ramp has 1 colours, not 2 or more"),
        (Layer(name="broken", kind=LayerKind.IMAGE), "image is missing"),
        (
            Layer(name="broken", kind=LayerKind.IMAGE, image=image("empty", (0, 4, 4))),
            'image "empty" has no pixels',
        ),
    ],
)
def test_a_layer_that_cannot_be_used_is_left_out_by_name_and_the_others_stay(layer: Layer, reason: str) -> None:
    function = TransferFunction(name="Dusk", layers=(solid(), layer))
    native, reports = built(function)
    assert len(native) == 1
    assert reports == [f'Transfer function "Dusk": layer "broken": {reason}; the layer is left out']
    with pytest.raises(InvalidInput, match='layer "broken"'):
        compose(function, 4)


def test_a_function_that_cannot_be_used_is_left_out_by_name_and_the_others_stay() -> None:
    masked = TransferFunction(name="Masked", x=ParameterAxis(axis=Axis.MASK))
    strong = TransferFunction(name="Strong", strength=math.inf)
    native, reports = built(masked, TransferFunction(name="Fine"), strong)
    assert len(native) == 1
    assert reports == [
        'Transfer function "Masked" is left out: x axis\'s mask is missing',
        'Transfer function "Strong" is left out: strength is inf, outside [0, 1e+06]',
    ]
    heavy = [WeightedFunction(function=TransferFunction(name="Heavy"), weight=math.nan)]
    assert build_weighted_functions(heavy, ORIGIN, {}, reports) == []
    assert reports[-1] == 'Transfer function "Heavy" is left out: weight is nan, outside [0, 1]'


def test_pixels_that_are_not_finite_become_black_with_a_report() -> None:
    painted = image()
    painted.pixels[1, 2, 0] = np.nan
    function = TransferFunction(name="f", layers=(Layer(name="l", kind=LayerKind.IMAGE, image=painted),))
    _, reports = built(function)
    assert reports == ['Image "image": 1 pixels that are not finite are drawn black']
    assert np.isfinite(compose(function, 4)).all()


def test_images_are_sent_once_and_leave_with_the_last_that_uses_them() -> None:
    textures: dict[str, _native.Texture] = {}

    def send(*keys: str) -> None:
        layers = tuple(Layer(name=key, kind=LayerKind.IMAGE, image=image(key)) for key in keys)
        function = TransferFunction(name="f", layers=layers)
        build_weighted_functions([WeightedFunction(function=function)], ORIGIN, textures, [])

    send("a", "b", "a")
    assert set(textures) == {"a", "b"}
    first = textures["a"]
    send("a")
    assert set(textures) == {"a"}
    assert textures["a"] is first
    send()
    assert not textures
