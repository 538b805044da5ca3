# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of surfaces give what Cycles gives: a plane under a sun, before a coloured wall that shows through it.

The sun's irradiance is pi, so the pixel is the diffuse colour, plus emission, plus the wall times what is transparent.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon import last_render
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, Node, empty_scene, light, material, node, plane

IS_4 = bpy.app.version >= (4, 0, 0)
WALL = (0.3, 0.6, 0.2, 1.0)
New, Link = Callable[[str], Node], Callable[..., object]
Socket = bpy.types.NodeSocket
#: Cycles chooses between surface and wall by chance: 256 samples of 64 pixels leave 0.4 % of their contrast, at most.
STOCHASTIC, EXACT = 5e-3, 1e-4


def shown(build: Build) -> bpy.types.Scene:
    scene = empty_scene()
    plane(-1.0, material("Wall", lambda new, _: node(new, "ShaderNodeEmission", Color=WALL).outputs[0]))
    plane(0.0, material("Shown", build))
    light("SUN", (0, 0, 1), energy=math.pi, angle=0.0)
    return scene


def both(build: Build, samples: int = 16) -> tuple[np.ndarray, np.ndarray]:
    scene = shown(build)
    ours = tyndall_pixels(scene).mean(axis=(0, 1))
    return ours, cycles_pixels(scene, samples, seed=1).mean(axis=(0, 1))


def image(
    colour: tuple[float, ...] = (0.2, 0.6, 0.4, 1.0), *, is_float: bool = False, space: str = ""
) -> bpy.types.Image:
    created = bpy.data.images.new("Image", 4, 4, alpha=True, float_buffer=is_float)
    created.generated_color = colour
    if space:
        created.colorspace_settings.name = space
    return created


def texture(new: New, *arguments: object, **options: object) -> Node:
    created = new("ShaderNodeTexImage")
    created.image = image(*arguments, **options)
    return created


def diffuse(new: New, link: Link, colour: Socket) -> Socket:
    shader = new("ShaderNodeBsdfDiffuse")
    link(colour, shader.inputs["Color"])
    return shader.outputs[0]


def principled(new: New, **inputs: object) -> Node:
    """Without gloss, which is not drawn yet."""
    names = {"Emission_Color": "Emission_Color" if IS_4 else "Emission"}
    inputs["Specular_IOR_Level" if IS_4 else "Specular"] = 0.0
    if not IS_4:
        inputs["Roughness"] = 0.0  # 3.x varies its diffuse part with roughness
    return node(new, "ShaderNodeBsdfPrincipled", **{names.get(name, name): value for name, value in inputs.items()})


def through(kind: str, source: str | int = 0, target: str | int = 0, **inputs: object) -> Build:
    """An image, through one node, as the colour of a diffuse surface."""

    def build(new: New, link: Link) -> Socket:
        created = node(new, kind, **inputs)
        link(texture(new).outputs["Color"], created.inputs[target])
        return diffuse(new, link, created.outputs[source])

    return build


def mixed(blend: str, *, clamped: bool = False) -> Build:
    def build(new: New, link: Link) -> Socket:
        created = node(new, "ShaderNodeMixRGB", Fac=0.4, Color2=(0.3, 0.9, 0.5, 1))
        created.blend_type, created.use_clamp = blend, clamped
        link(texture(new).outputs["Color"], created.inputs["Color1"])
        return diffuse(new, link, created.outputs[0])

    return build


def new_mix(data_type: str) -> Build:
    def build(new: New, link: Link) -> Socket:
        created = new("ShaderNodeMix")
        created.data_type = data_type
        sockets = [socket for socket in created.inputs if socket.enabled]
        sockets[0].default_value = 0.25
        link(texture(new).outputs["Color"], sockets[1])
        sockets[2].default_value = {"FLOAT": 0.9, "VECTOR": (0.9, 0.1, 0.5), "RGBA": (0.9, 0.1, 0.5, 1)}[data_type]
        return diffuse(new, link, next(socket for socket in created.outputs if socket.enabled))

    return build


def channels_swapped(new: New, link: Link) -> Socket:
    apart, together = new("ShaderNodeSeparateColor"), new("ShaderNodeCombineColor")
    link(texture(new).outputs["Color"], apart.inputs[0])
    link(apart.outputs["Red"], together.inputs["Blue"])
    link(apart.outputs["Green"], together.inputs["Red"])
    return diffuse(new, link, together.outputs[0])


def ramp(new: New, link: Link) -> Socket:
    created = new("ShaderNodeValToRGB")
    first, last = created.color_ramp.elements
    first.position, last.position, last.color = 0.1, 0.8, (0.9, 0.2, 0.3, 1)
    link(texture(new).outputs["Color"], created.inputs[0])
    return diffuse(new, link, created.outputs[0])


def math_node(operation: str, value: float) -> Build:
    def build(new: New, link: Link) -> Socket:
        created = new("ShaderNodeMath")
        created.operation = operation
        created.inputs[1].default_value = value
        link(texture(new).outputs["Color"], created.inputs[0])
        return diffuse(new, link, created.outputs[0])

    return build


def added(new: New, link: Link) -> Socket:
    sum_of_two = new("ShaderNodeAddShader")
    link(node(new, "ShaderNodeEmission", Color=(0.9, 0.8, 0.1, 1), Strength=0.5).outputs[0], sum_of_two.inputs[0])
    link(node(new, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.2, 0.6, 1)).outputs[0], sum_of_two.inputs[1])
    return sum_of_two.outputs[0]


def with_a_volume(new: New, link: Link) -> Socket:
    """A shader of volumes does nothing at a surface."""
    mix = node(new, "ShaderNodeMixShader", Fac=0.25)
    link(diffuse(new, link, texture(new).outputs["Color"]), mix.inputs[1])
    link(new("ShaderNodeVolumeAbsorption").outputs[0], mix.inputs[2])
    return mix.outputs[0]


def nameless_attribute(output: str) -> Build:
    """Not the mesh's colours, which Color Attribute gives without a name."""

    def build(new: New, link: Link) -> Socket:
        glow = node(new, "ShaderNodeEmission", Strength=0.5)
        lighter = node(new, "ShaderNodeMixRGB", Fac=1.0, Color1=(0.3, 0.1, 0.2, 1.0))
        lighter.blend_type = "ADD"
        link(new("ShaderNodeAttribute").outputs[output], lighter.inputs["Color2"])
        link(lighter.outputs[0], glow.inputs["Color"])
        return glow.outputs[0]

    return build


def muted(new: New, link: Link) -> Socket:
    """A muted node hands its first shader on."""
    mix = node(new, "ShaderNodeMixShader", Fac=0.25)
    link(diffuse(new, link, texture(new).outputs["Color"]), mix.inputs[1])
    mix.mute = True
    return mix.outputs[0]


def grouped(new: New, link: Link) -> Socket:
    """A group with a reroute; its input has no link but a value."""
    tree = bpy.data.node_groups.new("Paint", "ShaderNodeTree")
    if IS_4:
        tree.interface.new_socket("Colour", in_out="INPUT", socket_type="NodeSocketColor")
        tree.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    else:
        tree.inputs.new("NodeSocketColor", "Colour")
        tree.outputs.new("NodeSocketShader", "Shader")
    create, connect = tree.nodes.new, tree.links.new
    entry, leave, reroute = create("NodeGroupInput"), create("NodeGroupOutput"), create("NodeReroute")
    connect(entry.outputs[0], reroute.inputs[0])
    connect(diffuse(create, connect, reroute.outputs[0]), leave.inputs[0])
    group = new("ShaderNodeGroup")
    group.node_tree = tree
    group.inputs[0].default_value = (0.3, 0.2, 0.8, 1)
    return group.outputs[0]


def colour_as_surface(new: New, _link: Link) -> Socket:
    """A colour plugged straight into Surface glows."""
    created = new("ShaderNodeRGB")
    created.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
    return created.outputs[0]


def backfacing(new: New, link: Link) -> Socket:
    return diffuse(new, link, new("ShaderNodeNewGeometry").outputs["Backfacing"])


def image_as(**options: object) -> Build:
    return lambda new, link: diffuse(new, link, texture(new, **options).outputs["Color"])


EXACTLY: dict[str, Build] = {
    "principled": lambda new, _: principled(new, Base_Color=(0.3, 0.5, 0.7, 1)).outputs[0],
    "principled that glows": lambda new, _: principled(
        new, Base_Color=(0.3, 0.5, 0.7, 1), Emission_Color=(1, 0.5, 0.2, 1), Emission_Strength=0.5
    ).outputs[0],
    "sum of shaders": added,
    "colour as surface": colour_as_surface,
    "image": image_as(),
    "image of floats": image_as(is_float=True),
    "image that is no colour": image_as(space="Non-Color"),
    "mix": mixed("MIX"),
    "mix, add": mixed("ADD"),
    "mix, multiply": mixed("MULTIPLY"),
    "mix, subtract, clamped": mixed("SUBTRACT", clamped=True),
    "mix, screen": mixed("SCREEN"),
    "new mix of numbers": new_mix("FLOAT"),
    "new mix of vectors": new_mix("VECTOR"),
    "new mix of colours": new_mix("RGBA"),
    "ramp": ramp,
    "grey": through("ShaderNodeRGBToBW"),
    "multiply": math_node("MULTIPLY", 0.5),
    "add": math_node("ADD", 0.25),
    "divide": math_node("DIVIDE", 4.0),
    "channels": channels_swapped,
    "invert": through("ShaderNodeInvert", target="Color"),
    "brightness": through("ShaderNodeBrightContrast", target="Color", Bright=0.1, Contrast=0.3),
    "gamma of a constant": lambda new, link: diffuse(
        new, link, node(new, "ShaderNodeGamma", Color=(0.2, 0.5, 0.8, 1), Gamma=2.2).outputs[0]
    ),
    "backfacing": backfacing,
    "muted": muted,
    "volume": with_a_volume,
    "group": grouped,
}


@pytest.mark.parametrize("name", EXACTLY)
def test_opaque_surfaces(name: str) -> None:
    """To the fifth digit: no part of these is left to chance."""
    ours, cycles = both(EXACTLY[name])
    assert ours == pytest.approx(cycles, abs=EXACT, rel=EXACT)


@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_an_attribute_without_a_name_is_none_of_the_meshs(output: str) -> None:
    scene = shown(nameless_attribute(output))
    for thing in scene.objects:
        if thing.type == "MESH":
            colours = thing.data.color_attributes.new("Paint", "FLOAT_COLOR", "CORNER")
            colours.data.foreach_set("color", [0.2, 0.4, 0.6, 0.5] * len(colours.data))
    ours, cycles = tyndall_pixels(scene), cycles_pixels(scene, 4, seed=1)
    assert ours == pytest.approx(cycles, abs=EXACT)


def cut_out(new: New, _link: Link) -> Socket:
    """Alpha cuts the glow, too."""
    colours = {"Base_Color": (0.3, 0.5, 0.7, 1), "Emission_Color": (1, 0.5, 0.2, 1)}
    return principled(new, **colours, Emission_Strength=0.5, Alpha=0.3).outputs[0]


def mixed_with_transparent(new: New, link: Link) -> Socket:
    mix = node(new, "ShaderNodeMixShader", Fac=0.25)
    link(node(new, "ShaderNodeBsdfTransparent", Color=(0.9, 0.8, 0.1, 1)).outputs[0], mix.inputs[1])
    link(node(new, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.2, 0.6, 1)).outputs[0], mix.inputs[2])
    return mix.outputs[0]


def leaf(*, is_float: bool) -> Build:
    def build(new: New, link: Link) -> Socket:
        picture, shader = texture(new, (0.2, 0.6, 0.4, 0.5), is_float=is_float), principled(new)
        link(picture.outputs["Color"], shader.inputs["Base Color"])
        link(picture.outputs["Alpha"], shader.inputs["Alpha"])
        return shader.outputs[0]

    return build


BY_CHANCE: dict[str, Build] = {
    "alpha": cut_out,
    "mix with transparent": mixed_with_transparent,
    "image with alpha in use": leaf(is_float=False),
    "image of floats with alpha in use": leaf(is_float=True),
}


@pytest.mark.parametrize("name", BY_CHANCE)
def test_surfaces_that_let_light_through(name: str) -> None:
    ours, cycles = both(BY_CHANCE[name], samples=256)
    assert ours == pytest.approx(cycles, abs=STOCHASTIC)


@pytest.mark.parametrize("is_float", [False, True])
def test_colours_of_an_image_whose_alpha_nobody_uses_are_multiplied_with_it(*, is_float: bool) -> None:
    """Eight bits before the multiplication, or after it: up to one step of 255."""
    ours, cycles = both(
        lambda new, link: diffuse(new, link, texture(new, (0.2, 0.6, 0.4, 0.5), is_float=is_float).outputs[0])
    )
    assert ours == pytest.approx(cycles, abs=EXACT if is_float else 1 / 255)


@pytest.mark.parametrize("x", [0.0, 2.0], ids=["inside", "outside"])
def test_outside_a_clipped_image_is_transparent_though_the_image_is_not(x: float) -> None:
    def build(new: New, link: Link) -> Socket:
        picture, mix = texture(new), new("ShaderNodeMixShader")
        picture.extension = "CLIP"
        place = node(new, "ShaderNodeMapping", Location=(x, 0, 0))
        link(new("ShaderNodeTexCoord").outputs["UV"], place.inputs["Vector"])
        link(place.outputs[0], picture.inputs["Vector"])
        link(picture.outputs["Alpha"], mix.inputs[0])
        link(new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
        link(diffuse(new, link, picture.outputs["Color"]), mix.inputs[2])
        return mix.outputs[0]

    ours, cycles = both(build)
    assert ours == pytest.approx(cycles, abs=EXACT)
    if x:
        assert ours == pytest.approx(WALL[:3], abs=EXACT)


def test_a_missing_image_is_magenta_and_named() -> None:
    def build(new: New, link: Link) -> Socket:
        picture = texture(new)
        picture.image.name = "Lost"
        picture.image.source, picture.image.filepath = "FILE", "/nowhere/lost.png"
        picture.image.reload()
        return diffuse(new, link, picture.outputs["Color"])

    ours, cycles = both(build)
    assert ours == pytest.approx((1, 0, 1))
    assert cycles == pytest.approx((1, 0, 1))
    assert any("Lost" in line and "lost.png" in line for line in last_render.statistics_of("Scene")["reports"])


def test_a_colour_that_glows_from_heat() -> None:
    """Two fits to the same measured curves differ by up to 1 %."""
    ours, cycles = both(lambda new, _: node(new, "ShaderNodeBlackbody", Temperature=3500.0).outputs[0])
    assert ours == pytest.approx(cycles, rel=0.01)


def test_an_unknown_shader_falls_back_with_one_line() -> None:
    def build(new: New, link: Link) -> Socket:
        mix = new("ShaderNodeMixShader")
        link(new("ShaderNodeBsdfGlass").outputs[0], mix.inputs[1])
        link(new("ShaderNodeBsdfRefraction").outputs[0], mix.inputs[2])
        return mix.outputs[0]

    ours = tyndall_pixels(shown(build))
    assert np.isfinite(ours).all()
    lines = [line for line in last_render.statistics_of("Scene")["reports"] if '"Shown"' in line]
    assert len(lines) == 1
    assert "Glass" in lines[0]
    assert "Refraction" in lines[0]


def test_materials_without_nodes_show_their_own_colour() -> None:
    """Up to 4.5; from 5.0 on all have nodes."""
    if bpy.app.version >= (5, 0, 0):
        pytest.skip("every material has nodes")
    scene = shown(lambda new, _: node(new, "ShaderNodeEmission").outputs[0])
    shown_material = bpy.data.materials["Shown"]
    shown_material.use_nodes = False
    shown_material.diffuse_color = (0.1, 0.2, 0.3, 1)
    assert tyndall_pixels(scene).mean(axis=(0, 1)) == pytest.approx((0.1, 0.2, 0.3), rel=1e-4)
