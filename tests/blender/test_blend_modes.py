# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of a transfer function mix as Blender's Mix node does in Cycles, in every mode of the node's menu."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from support.engine_pictures import cycles_pixels
from support.small_scenes import Node, empty_scene, material, plane
from tyndall.native_transfer_functions import compose
from tyndall.scene_description import Image
from tyndall.transfer_functions import BlendMode, Layer, LayerKind, TransferFunction

SIZE_PX = 32
New, Link = Callable[[str], Node], Callable[..., object]


def random_pixels(seed: int) -> NDArray[np.float32]:
    """Colours with alpha in [0, 1]; some are black, white or grey, which modes treat apart."""
    random = np.random.default_rng(seed)
    pixels = random.random((SIZE_PX, SIZE_PX, 4), dtype=np.float32)
    pixels[0, :, :3], pixels[1, :, :3] = 0.0, 1.0
    pixels[2, :, :3] = pixels[2, :, :1]
    pixels[3, ::2, 3], pixels[3, 1::2, 3] = 0.0, 1.0
    return pixels


def texture(new: New, pixels: NDArray[np.float32]) -> Node:
    image = bpy.data.images.new("Image", SIZE_PX, SIZE_PX, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.use_half_precision = False
    image.pixels.foreach_set(pixels.ravel())
    node = new("ShaderNodeTexImage")
    node.image, node.interpolation = image, "Closest"
    return node


def mixed_by_cycles(mode: BlendMode, below: NDArray[np.float32], above: NDArray[np.float32]) -> NDArray[np.float64]:
    """What the node emits, (SIZE_PX, SIZE_PX, 3): `above` over `below`, its alpha is the factor."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        mix = new("ShaderNodeMixRGB")
        mix.blend_type = mode.name
        for name, colours in (("Fac", above[..., 3:]), ("Color1", below[..., :3]), ("Color2", above[..., :3])):
            opaque = np.ones((SIZE_PX, SIZE_PX, 4), np.float32)
            opaque[..., :3] = colours
            link(texture(new, opaque).outputs["Color"], mix.inputs[name])
        emission = new("ShaderNodeEmission")
        link(mix.outputs["Color"], emission.inputs["Color"])
        return emission.outputs[0]

    scene = empty_scene(SIZE_PX)
    plane(0.0, material("Mixed", build), half_side=0.005)  # what the camera sees
    return cycles_pixels(scene, samples=1, seed=1)


@pytest.mark.dealt
@pytest.mark.parametrize("mode", BlendMode)
def test_a_layer_over_an_opaque_one_is_the_mix_node_of_cycles(mode: BlendMode) -> None:
    if mode == BlendMode.EXCLUSION and bpy.app.version < (4, 0, 0):
        pytest.skip("its Mix node has no Exclusion")
    below, above = random_pixels(1), random_pixels(2)[::-1].copy()
    reference = np.maximum(mixed_by_cycles(mode, below, above), 0.0)

    def layer(name: str, pixels: NDArray[np.float32], mode: BlendMode, *, has_alpha: bool) -> Layer:
        image = Image(key=name, name=name, pixels=pixels, is_srgb=False, has_alpha=has_alpha)
        return Layer(name=name, kind=LayerKind.IMAGE, mode=mode, image=image)

    layers = (
        layer("below", below, BlendMode.MIX, has_alpha=False),
        layer("above", above, mode, has_alpha=True),
    )
    ours = compose(TransferFunction(name="f", layers=layers), SIZE_PX)
    assert (ours[..., 3] == 1.0).all()
    # The image is filtered at its texels' centres; Burn and Dodge divide by small numbers.
    difference = np.abs(ours[..., :3] - reference) / np.maximum(reference, 1.0)
    assert np.quantile(difference, 0.99) < 3e-6
    assert difference.max() < 3e-5
