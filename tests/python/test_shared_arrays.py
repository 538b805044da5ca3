# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that native code shares cannot change under it; any other is copied, and stays the caller's own."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from support.plain_scenes import camera_above, lit_square, placed, square, sun
from tyndall import InvalidInput, Progress, _native
from tyndall.linear_colours import linear_colours, linear_texels
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import Image, Mesh


def shared(values: NDArray[Any]) -> NDArray[Any]:
    array: NDArray[Any] = _native.shared_array(values.shape, values.dtype)
    array[...] = values
    return array


def of_shared_arrays(mesh: Mesh) -> Mesh:
    arrays = {field.name: getattr(mesh, field.name) for field in fields(mesh)}
    given = {name: shared(value) for name, value in arrays.items() if isinstance(value, np.ndarray)}
    return replace(mesh, **given, uv_maps=tuple((name, shared(values)) for name, values in mesh.uv_maps))


def picture(mesh: Mesh) -> NDArray[np.float32]:
    session = Session()
    description = lit_square(instances=(placed(mesh, np.diag([2.0, 2.0, 1.0, 1.0])),), lights=(sun(),))
    session.update(description, Progress())
    return session.render(camera_above(), RenderConfig(pixel_samples=1), Progress()).planes["Combined"]


def test_a_mesh_of_shared_arrays_is_that_of_copied_ones_and_cannot_be_written_any_more() -> None:
    mesh = square()
    own = of_shared_arrays(mesh)
    np.testing.assert_array_equal(picture(own), picture(mesh))
    for array in (own.positions, own.triangles, *(values for _, values in own.uv_maps)):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_what_is_copied_stays_the_callers_own() -> None:
    mesh = square()
    session = Session()
    session.update(lit_square(instances=(placed(mesh, np.eye(4)),), lights=(sun(),)), Progress())
    before = session.render(camera_above(), RenderConfig(pixel_samples=1), Progress()).planes["Combined"]
    mesh.positions[...] = 0.0
    after = session.render(camera_above(), RenderConfig(pixel_samples=1), Progress()).planes["Combined"]
    np.testing.assert_array_equal(before, after)
    assert before[..., :3].any()


# A view may end before the block does: what lies behind a row belongs to the next one.
def test_a_part_of_a_shared_array_is_copied() -> None:
    whole = shared(np.arange(30, dtype=np.float32).reshape(10, 3))
    triangles = np.array([[0, 1, 3]], np.uint32)
    whole[3] = (0.0, 5.0, 1.0)
    _native.TriangleMesh("part", whole[:5], triangles, None, None, (), Progress())
    whole[0] = 7.0
    assert whole[0, 0] == 7.0


@pytest.mark.parametrize("shape", [(-1, 3), (1 << 30, 1 << 30)])
def test_a_shape_that_cannot_be_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(InvalidInput, match="an array of shape"):
        _native.shared_array(shape, np.dtype(np.float32))


@pytest.mark.parametrize("is_srgb", [False, True])
def test_texels_of_a_world_are_its_linear_colours(*, is_srgb: bool) -> None:
    pixels = np.arange(4 * 64, dtype=np.uint8).reshape(8, 8, 4)
    image = Image(key="bytes", name="Bytes", pixels=pixels, is_srgb=is_srgb)
    np.testing.assert_array_equal(linear_texels(image)[..., :3], linear_colours(image))
    floats = Image(key="floats", name="Floats", pixels=shared(pixels.astype(np.float32)), is_srgb=False)
    assert linear_texels(floats) is floats.pixels
