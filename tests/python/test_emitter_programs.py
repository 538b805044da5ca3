# SPDX-License-Identifier: GPL-3.0-or-later
"""What varies over an area light is drawn as fine as it needs, once, and keeps its mean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tyndall.emitter_programs import Emitter, EmitterPictures, FlatView
from tyndall.linear_colours import linear_colours
from tyndall.scene_description import Code, Image, Interpolation, Material, SurfaceOp, TextureUse
from tyndall.surface_inputs import PointInput

UV = (1, 0, 0, 0, 1, 0, 0, 0, 0)


def shown(*ops: SurfaceOp, **fields: object) -> Material:
    """A material that emits what its last operation gives."""
    return Material(name="light", program=ops, emission_register=ops[-1].out, **fields)  # type: ignore[arg-type]


def ramp() -> Material:
    return shown(SurfaceOp(code=Code.UV, out=0, uv_matrix=UV), uv_maps=("",))


def slide(size: tuple[int, int], interpolation: Interpolation = Interpolation.LINEAR) -> Material:
    pixels = np.random.default_rng(2).uniform(0.0, 1.0, (size[1], size[0], 4)).astype(np.float32)
    image = Image(key=f"slide {size}", name="slide", pixels=pixels, is_srgb=False)
    use = TextureUse(image=image, interpolation=interpolation)
    return shown(SurfaceOp(code=Code.TEXTURE, out=0), uv_maps=("",), textures=(use,))


def position() -> Material:
    return shown(SurfaceOp(code=Code.INPUT, out=0, option=int(PointInput.POSITION)))


def emitter(shift: float = 3.0, **changes: object) -> Emitter:
    matrix = np.eye(4)
    matrix[:3, 3] = shift
    return Emitter(world_from_object=matrix, size=(2.0, 1.0), **changes)  # type: ignore[arg-type]


def pixels_of(material: Material, on: Emitter) -> np.ndarray:
    image = EmitterPictures().find(FlatView(material, on)).image
    assert image is not None
    return linear_colours(image)


def test_a_ramp_runs_from_corner_to_corner_in_few_texels() -> None:
    pixels = pixels_of(ramp(), emitter())
    assert pixels.shape == (256, 256, 3)
    np.testing.assert_allclose(pixels[0, :, 0], (np.arange(256) + 0.5) / 256, rtol=1e-6)
    np.testing.assert_allclose(pixels[:, 0, 1], (np.arange(256) + 0.5) / 256, rtol=1e-6)


def test_edges_are_followed_until_they_are_sharp() -> None:
    soft = pixels_of(slide((7, 5)), emitter())
    sharp = pixels_of(slide((7, 5), Interpolation.CLOSEST), emitter())
    assert max(soft.shape) < max(sharp.shape) <= 1024


def test_a_picture_keeps_its_texels_and_a_larger_one_its_means() -> None:
    material = slide((512, 384))
    image = material.textures[0].image
    np.testing.assert_allclose(pixels_of(material, emitter()), linear_colours(image), atol=1e-5)
    large = slide((4096, 2))
    pairs = linear_colours(large.textures[0].image).reshape(1, 2, 2048, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(pixels_of(large, emitter()), pairs, atol=1e-5)


@pytest.mark.parametrize("is_ellipse", [False, True])
def test_the_mean_of_the_picture_is_that_of_the_light(is_ellipse: bool) -> None:  # noqa: FBT001
    material = slide((7, 5), Interpolation.CLOSEST)
    found = EmitterPictures().find(FlatView(material, emitter(is_ellipse=is_ellipse)))
    assert found.image is not None
    mean = linear_colours(found.image).mean(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(mean, found.mean, rtol=1e-4)
    texels = linear_colours(material.textures[0].image)
    x, y = np.meshgrid((np.arange(1400) + 0.5) / 1400, (np.arange(1000) + 0.5) / 1000)
    inside = np.hypot(2 * x - 1, 2 * y - 1) <= 1.0 if is_ellipse else np.ones_like(x, bool)
    brute_force = texels[(y * 5).astype(int), (x * 7).astype(int)][inside].mean(axis=0, dtype=np.float64)
    np.testing.assert_allclose(found.mean, brute_force, rtol=1e-3)


def test_values_that_overflow_are_cut_off_and_warn_nowhere() -> None:
    huge = slide((7, 5))
    texels = np.full((5, 7, 4), 3e38, np.float32)
    texels[0, 0, :3] = np.nan
    image = Image(key="huge", name="huge", pixels=texels, is_srgb=False)
    use = replace(huge.textures[0], image=image)
    assert np.isfinite(EmitterPictures().find(FlatView(replace(huge, textures=(use,)), emitter())).mean).all()


def test_only_what_reads_the_world_is_drawn_again_where_the_light_moves() -> None:
    pictures = EmitterPictures()
    assert pictures.find(FlatView(ramp(), emitter(3.0))).image is pictures.find(FlatView(ramp(), emitter(4.0))).image
    assert (
        pictures.find(FlatView(position(), emitter(3.0))).image
        is not pictures.find(FlatView(position(), emitter(4.0))).image
    )
    np.testing.assert_allclose(pictures.find(FlatView(position(), emitter(3.0))).mean, 3.0, rtol=1e-6)
    assert (
        pictures.find(FlatView(ramp(), emitter(is_ellipse=True))).image
        is not pictures.find(FlatView(ramp(), emitter())).image
    )


def test_up_to_3_x_all_of_it_shows_one_place_of_its_uv_map() -> None:
    found = EmitterPictures().find(FlatView(ramp(), emitter(is_object=False)))
    assert found.image is None
    assert found.mean == (0.0, 0.0, 0.0)
