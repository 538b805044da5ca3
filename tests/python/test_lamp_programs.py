# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lamp's nodes show by the direction is found in its picture, however the lamp is turned, scaled and sheared."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tyndall.emitter_programs import EmitterPictures
from tyndall.lamp_programs import Lamp, LampView, vectors_of
from tyndall.linear_colours import linear_colours
from tyndall.scene_description import Code, LightProjection, LightTexture, Material, SurfaceOp
from tyndall.surface_inputs import PointInput

RANDOM = np.random.default_rng(5)
DIRECTIONS = RANDOM.normal(size=(2000, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)


def sheared(flips: bool = False) -> np.ndarray:  # noqa: FBT001, FBT002
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(RANDOM.normal(size=(3, 3)))[0] @ np.array([[1.2, 0.3, 0], [0.1, 0.8, 0.2], [0, 0, 1]])
    if flips:
        matrix[:3, 0] *= -1.0
    matrix[:3, 3] = 3.0, -2.0, 5.0
    return matrix


def shown(*options: PointInput) -> Material:
    """0.5 of an input, made of the one before, and 0.5."""
    ops = [
        SurfaceOp(code=Code.INPUT, out=index, a=index - 1 if index else 0, option=int(one))
        for index, one in enumerate(options)
    ]
    last = len(ops)
    half = tuple(0.5 * np.eye(3).ravel())
    ops.append(SurfaceOp(code=Code.AFFINE, out=last, a=last - 1, uv_matrix=half, value=(0.5, 0.5, 0.5)))
    return Material(name="lamp", program=tuple(ops), emission_register=last)


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def looked_up(texture: LightTexture, directions: np.ndarray) -> np.ndarray:
    """As native/scene/light_texture.hpp has it."""
    axes = unit(directions @ texture.axes_from_world.T)
    place = np.c_[axes, np.ones(len(axes))] @ texture.place_from_axes.T
    if texture.projection is LightProjection.PERSPECTIVE:
        projected = place[:, :2] / place[:, 2:]
    else:
        x, y, z = place.T
        projected = np.c_[0.5 - np.arctan2(x, y) / (2 * math.pi), 0.5 + np.arctan2(z, np.hypot(x, y)) / math.pi]
    uv = np.c_[projected, np.ones(len(axes))] @ texture.uv_from_projected.T
    pixels = linear_colours(texture.use.image)
    at = uv[:, :2] * pixels.shape[1::-1] - 0.5
    low = np.clip(np.floor(at).astype(int), 0, np.array(pixels.shape[1::-1]) - 2)
    share = np.clip(at - low, 0.0, 1.0)
    found = np.zeros((len(at), 3))
    for dx in (0, 1):
        for dy in (0, 1):
            weight = np.abs(1 - dx - share[:, 0]) * np.abs(1 - dy - share[:, 1])
            found += weight[:, None] * pixels[low[:, 1] + dy, low[:, 0] + dx]
    return found @ texture.gain.T


# Seen to fail with a shape that is transposed, and with the inverse of a turn.
@pytest.mark.parametrize("flips", [False, True])
@pytest.mark.parametrize("half_cone_rad", [None, 0.6, 1.4])
@pytest.mark.parametrize("is_object", [False, True])
@pytest.mark.parametrize("kind", ["normal", "incoming", "incoming in the object", "position"])
def test_each_direction_finds_its_colour(
    kind: str,
    is_object: bool,  # noqa: FBT001
    half_cone_rad: float | None,
    flips: bool,  # noqa: FBT001
) -> None:
    matrix = sheared(flips)
    linear = matrix[:3, :3]
    lamp = Lamp(
        world_from_object=matrix,
        spot_half_angle_rad=half_cone_rad,
        is_object=is_object,
        radius_m=0.7 if kind == "position" else 0.0,
    )
    inputs, expected = {
        "normal": ((PointInput.OBJECT_NORMAL,), unit(DIRECTIONS @ linear)),
        "incoming": ((PointInput.INCOMING,), DIRECTIONS),
        "incoming in the object": (
            (PointInput.INCOMING, PointInput.DIRECTION_TO_OBJECT),
            DIRECTIONS @ np.linalg.inv(linear).T,
        ),
        "position": ((PointInput.OBJECT_POSITION,), 0.7 * DIRECTIONS @ np.linalg.inv(linear).T),
    }[kind]
    view = LampView(shown(*inputs), lamp)
    picture = EmitterPictures().find(view)
    texture = view.texture(picture)
    assert texture is not None
    seen = np.ones(len(DIRECTIONS), bool)
    if half_cone_rad is not None and kind != "position":  # a ball's normals point everywhere
        along = unit(DIRECTIONS @ np.linalg.inv(linear).T)[:, 2] if is_object else DIRECTIONS @ unit(linear[:, 2])
        seen = -along > math.cos(half_cone_rad) + 1e-6
    values = 0.5 * expected + 0.5  # below 0, too
    found = looked_up(texture, DIRECTIONS) * np.array(picture.mean)
    np.testing.assert_allclose(found[seen], values[seen], atol=2e-3)
    assert seen.sum() > 20


def test_what_turns_with_a_lamp_has_one_picture_and_other_places_have_their_own() -> None:
    def key(material: Material, matrix: np.ndarray) -> str:
        return LampView(material, Lamp(world_from_object=matrix)).key

    one, other = np.eye(4), sheared()
    other[:3, :3] = np.linalg.qr(other[:3, :3])[0]
    assert key(shown(PointInput.OBJECT_NORMAL), one) == key(shown(PointInput.OBJECT_NORMAL), other)
    assert key(shown(PointInput.INCOMING), one) == key(shown(PointInput.INCOMING), other)
    assert key(shown(PointInput.POSITION), one) != key(shown(PointInput.POSITION), other)
    larger = 2.0 * one
    in_object = shown(PointInput.INCOMING, PointInput.DIRECTION_TO_OBJECT)
    assert key(in_object, one) == key(in_object, other)
    assert key(in_object, one) != key(in_object, larger)


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1e-4), (1e-5, 1.0, 1e3), (1e-6, 2e-6, 1e-6), (1e5, 1e5, 1e5)])
@pytest.mark.parametrize("half_cone_rad", [None, 0.6])
def test_lamps_of_any_scale_are_drawn(scale: tuple[float, ...], half_cone_rad: float | None) -> None:
    matrix = sheared()
    matrix[:3, :3] = np.linalg.qr(matrix[:3, :3])[0] @ np.diag(scale)
    lamp = Lamp(world_from_object=matrix, spot_half_angle_rad=half_cone_rad)
    picture = EmitterPictures().find(LampView(shown(PointInput.OBJECT_NORMAL), lamp))
    assert np.isfinite(picture.mean).all()
    assert max(picture.mean) > 0.1


def test_a_flat_shear_is_drawn_as_it_stands() -> None:
    matrix = np.eye(4)
    matrix[:3, 1] = 1.0, 1e-9, 0.0
    picture = EmitterPictures().find(LampView(shown(PointInput.OBJECT_NORMAL), Lamp(world_from_object=matrix)))
    assert np.isfinite(picture.mean).all()


def test_a_ball_tells_its_normal_from_the_direction() -> None:
    ball = Lamp(world_from_object=np.eye(4), radius_m=0.5)
    normal, direction = vectors_of(shown(PointInput.NORMAL), ball), vectors_of(shown(PointInput.INCOMING), ball)
    assert (normal.has_normal, normal.has_direction) == (True, False)
    assert (direction.has_normal, direction.has_direction) == (False, True)
    both = vectors_of(shown(PointInput.REFLECTION), ball)
    assert both.has_normal
    assert both.has_direction
