# SPDX-License-Identifier: GPL-3.0-or-later
"""A floor under a lamp whose nodes vary, and the vectors that its shader sees."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Matrix

from . import cycles_reference
from .engine_pictures import FloatArray, cycles_pixels, tyndall_pixels
from .small_scenes import Node, empty_scene, light, material, node, plane

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


def mixed(first: MakeVector, second: MakeVector, blend: str = "MULTIPLY") -> MakeVector:
    def made(new: New, link: Link) -> Socket:
        mix = node(new, "ShaderNodeMixRGB", Fac=1.0)
        mix.blend_type = blend
        link(first(new, link), mix.inputs["Color1"])
        link(second(new, link), mix.inputs["Color2"])
        return mix.outputs[0]

    return made


def ramped(make: MakeVector) -> MakeVector:
    def made(new: New, link: Link) -> Socket:
        ramp = new("ShaderNodeValToRGB")
        ramp.color_ramp.elements[0].color = (0.9, 0.1, 0.2, 1)
        ramp.color_ramp.elements.new(0.4).color = (0.1, 0.8, 0.3, 1)
        link(make(new, link), ramp.inputs[0])
        return ramp.outputs[0]

    return made


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


PICTURES = Path(__file__).parents[2] / "out" / "cycles_agreement"


def assert_air_like_cycles(
    name: str,
    make_reference: Callable[[], None],
    make_ours: Callable[[], None],
    surface_samples: int = 1,
    methods: tuple[str, ...] = ("EXACT", "EPIPOLAR"),
) -> None:
    """By Cycles' noise, in blocks, with fog, a grid and its shadows; the scenes are made one after the other."""
    make_reference()
    scene = bpy.context.scene
    cycles = tuple(cycles_reference.cycles_pixels(scene, 64, seed=seed) for seed in (1, 2))
    make_ours()
    scene = bpy.context.scene
    on_edges = cycles_reference.pixels_on_edges(scene)

    def ours(seed: int) -> list[FloatArray]:
        return cycles_reference.tyndall_pixels(
            scene, methods, surface_samples=surface_samples, light_samples=64, seed=seed
        )

    firsts = ours(0)
    seconds = ours(1) if surface_samples > 1 else firsts
    for method, first, second in zip(methods, firsts, seconds, strict=True):
        verdict = cycles_reference.agreement((first, second), cycles, on_edges, 64)
        print(f"{name}, {method}: {verdict}")
        if not verdict.holds:
            path = PICTURES / f"{bpy.app.version_string} {name} {method}.png".replace(" ", "_")
            cycles_reference.save_side_by_side(path, (first + second) / 2, (cycles[0] + cycles[1]) / 2)
        assert verdict.holds, verdict


def smooth_picture(name: str = "Slide") -> bpy.types.Image:
    """Colours that flow into one another: few enough of them that no pixel has two."""
    made = picture(name, (12, 12), seed=3)
    values = np.empty(12 * 12 * 4, np.float32)
    made.pixels.foreach_get(values)
    values = values.reshape(12, 12, 4)
    values[..., :3] = (values[..., :3] + np.roll(values[..., :3], 1, axis=0) + np.roll(values[..., :3], 1, axis=1)) / 3
    made.pixels.foreach_set(values.ravel())
    made.pack()
    return made


def bands(new: New, link: Link) -> Socket:
    """By the angle to the light's axis, by arithmetic alone."""
    apart, scaled, wave = new("ShaderNodeSeparateXYZ"), new("ShaderNodeMath"), new("ShaderNodeMath")
    scaled.operation, wave.operation = "MULTIPLY_ADD", "SINE"
    scaled.inputs[1].default_value = 14.0
    link(NORMAL(new, link), apart.inputs[0])
    link(apart.outputs[2], scaled.inputs[0])
    link(scaled.outputs[0], wave.inputs[0])
    shifted = node(new, "ShaderNodeMath")
    shifted.inputs[1].default_value = 1.2
    link(wave.outputs[0], shifted.inputs[0])
    return shifted.outputs[0]


def tree_of(lamp: bpy.types.Object) -> bpy.types.NodeTree:
    if not lamp.data.use_nodes:
        lamp.data.use_nodes = True
    return lamp.data.node_tree


def shows(lamp: bpy.types.Object, make: MakeVector, to: str = "Color") -> None:
    tree = tree_of(lamp)
    emission = next(one for one in tree.nodes if one.type == "EMISSION")
    tree.links.new(make(tree.nodes.new, tree.links.new), emission.inputs[to])


def assert_same_light() -> None:
    scene = bpy.context.scene
    np.testing.assert_allclose(tyndall_pixels(scene), cycles_pixels(scene, 1, seed=1), rtol=2e-3)
