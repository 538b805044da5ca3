# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures before lights colour surfaces and air as in Cycles: whatever the nodes say of where they are read."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Node, add, empty_scene, light, material, mesh, node, plane, read
from tyndall.scene_description import LightProjection, LightTexture

IS_4 = bpy.app.version >= (4, 0, 0)
Socket = bpy.types.NodeSocket
New, Link = Callable[[str], Node], Callable[..., object]
#: Makes the vector that an image is read at, or nothing.
MakeVector = Callable[[New, Link], "Socket | None"]


def picture(name: str = "Gobo", size: tuple[int, int] = (7, 5), seed: int = 1) -> bpy.types.Image:
    """Colourful, and different in every corner."""
    made = bpy.data.images.new(name, *size)
    values = np.random.default_rng(seed).uniform(0.1, 1.0, (size[1], size[0], 4)).astype(np.float32)
    values[..., 3] = 1.0
    made.pixels.foreach_set(values.ravel())
    made.pack()
    return made


def stage(kind: str, size_px: int = 48, **settings: object) -> bpy.types.Object:
    """A white floor of 4 m under a light that is turned and scaled about all axes, 5 m above."""
    scene = empty_scene(size_px)
    scene.camera.data.ortho_scale = 4.0
    scene.camera.location.z = 20.0
    lambert = material("Lambert", lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)).outputs[0])
    plane(material=lambert, half_side=50.0)
    settings = {"energy": 1000.0, "shadow_soft_size": 0.0, **settings}
    if kind == "SUN":
        settings = {"energy": 3.0, "angle": 0.0}
    if kind == "SPOT":
        settings = {"spot_size": math.radians(80), "spot_blend": 0.0, **settings}
    lamp = light(kind, (0, 0, 0), **settings)
    turn = Euler((0.2, 0.3, 0.5)).to_matrix().to_4x4()
    lamp.matrix_world = Matrix.Translation((0.4, -0.3, 5)) @ turn @ Matrix.Diagonal((1.5, 0.7, 1.2, 1))
    return lamp


def read_through(
    lamp: bpy.types.Object, vector: MakeVector, kind: str = "ShaderNodeTexImage", **options: object
) -> bpy.types.Node:
    """Give the light an image as its colour; return its node."""
    data = lamp.data
    if not data.use_nodes:
        data.use_nodes = True
    tree = data.node_tree
    emission = next(one for one in tree.nodes if one.type == "EMISSION")
    image = tree.nodes.new(kind)
    image.image = picture()
    for name, value in options.items():
        setattr(image, name, value)
    source = vector(tree.nodes.new, tree.links.new)
    if source is not None:
        tree.links.new(source, image.inputs["Vector"])
    tree.links.new(image.outputs["Color"], emission.inputs["Color"])
    return image


def output(kind: str, name: str) -> MakeVector:
    return lambda new, _link: next(one for one in new(kind).outputs if one.identifier == name)


def mapped(vector: MakeVector, vector_type: str = "POINT", **inputs: object) -> MakeVector:
    def make(new: New, link: Link) -> Socket:
        made = node(new, "ShaderNodeMapping")
        made.vector_type = vector_type
        for name, value in inputs.items():
            made.inputs[name].default_value = value
        link(vector(new, link), made.inputs["Vector"])
        return made.outputs[0]

    return make


def thrown(vector: MakeVector) -> MakeVector:
    """The gobo set-up of the tutorials: x and y over z."""

    def make(new: New, link: Link) -> Socket:
        apart, together = new("ShaderNodeSeparateXYZ"), new("ShaderNodeCombineXYZ")
        link(vector(new, link), apart.inputs[0])
        for axis in range(2):
            divide = new("ShaderNodeMath")
            divide.operation = "DIVIDE"
            link(apart.outputs[axis], divide.inputs[0])
            link(apart.outputs[2], divide.inputs[1])
            link(divide.outputs[0], together.inputs[axis])
        return together.outputs[0]

    return make


NORMAL, UV = output("ShaderNodeTexCoord", "Normal"), output("ShaderNodeTexCoord", "UV")
TURNED = {"Location": (0.3, -0.2, 0.1), "Rotation": (0.4, 0.3, 0.8), "Scale": (1.5, 0.8, 1.2)}
PLACES: dict[str, MakeVector] = {
    "nothing": lambda _new, _link: None,
    "UV": UV,
    "normal": NORMAL,
    "geometry normal": output("ShaderNodeNewGeometry", "Normal"),
    "true normal": output("ShaderNodeNewGeometry", "True Normal"),
    "incoming": output("ShaderNodeNewGeometry", "Incoming"),
    "parametric": output("ShaderNodeNewGeometry", "Parametric"),
    "mapped UV": mapped(UV, **TURNED),
    "mapped normal": mapped(NORMAL, **TURNED),
    "normal as a texture": mapped(NORMAL, "TEXTURE", **TURNED),
    "normal as a vector": mapped(NORMAL, "VECTOR", Rotation=(0.4, 0.3, 0.8), Scale=(1.5, 0.8, 1.2)),
    "thrown": thrown(NORMAL),
    "thrown and mapped": mapped(thrown(NORMAL), **TURNED),
    "mapped and thrown": thrown(mapped(NORMAL, Rotation=(0.1, 0.2, 0.8), Location=(0.1, 0.0, -0.2))),
}


def assert_like_cycles(bound: float = 2e-3) -> None:
    """Pixel by pixel: lights without a size leave no noise."""
    scene = bpy.context.scene
    reference = cycles_pixels(scene, 1, seed=1)
    ours = tyndall_pixels(scene)
    level = reference.mean()
    assert level > 0.01
    # Cycles' filter of 0.01 px and half a texel's rounding show where one texel meets the next.
    error = np.abs(ours - reference) / level
    assert np.median(error) < bound / 4
    assert np.quantile(error, 0.98) < bound
    assert (reference.std(axis=(0, 1)) > 0.05 * level).all()  # the picture is seen


@pytest.mark.parametrize("kind", ["SPOT", "POINT"])
@pytest.mark.parametrize("place", PLACES)
def test_an_image_is_read_where_cycles_reads_it(kind: str, place: str) -> None:
    lamp = stage(kind)
    read_through(lamp, PLACES[place])
    if not IS_4 and place in {"nothing", "UV", "mapped UV"}:  # 3.x has one texel for all
        scene = bpy.context.scene
        np.testing.assert_allclose(tyndall_pixels(scene), cycles_pixels(scene, 1, seed=1), rtol=2e-3)
        return
    assert_like_cycles()
