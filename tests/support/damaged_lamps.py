# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose nodes are broken: what luminaires' files hold, falloffs, gobos without images."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from pathlib import Path

import bpy

from support.agreement_shapes import diffuse
from support.damaged_nodes import ABSURD, NOT_NUMBERS, on_soup, spoil, surface_of
from support.damages import Random, Scene, damage, light_object
from support.photometry_files import AROUND, DOWN, luminaire

#: Of the third line of numbers, by which the candelas are multiplied.
_BEYOND_FLOATS, _BEYOND_DOUBLES = 1e60, "1e999"


def lamp_of_nodes(name: str, kind: str = "POINT") -> tuple[bpy.types.NodeTree, bpy.types.Node]:
    """Its tree, and the Emission node in it."""
    data = light_object(name, kind).data
    data.energy = 20.0
    if not data.use_nodes:
        data.use_nodes = True
    tree = data.node_tree
    tree.nodes.clear()
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputLight")
    emission.inputs["Strength"].default_value = 1.0
    tree.links.new(emission.outputs[0], output.inputs[0])
    return tree, emission


def ies_lamp(name: str, kind: str = "POINT") -> bpy.types.Node:
    """The IES Texture of a lamp, which is its strength."""
    tree, emission = lamp_of_nodes(name, kind)
    texture = tree.nodes.new("ShaderNodeTexIES")
    texture.mode = "EXTERNAL"
    texture.inputs["Strength"].default_value = 0.01
    tree.links.new(texture.outputs[0], emission.inputs["Strength"])
    return texture


def _external(contents: bytes) -> Callable[[bpy.types.Node, str], None]:
    def give(texture: bpy.types.Node, name: str) -> None:
        path = Path(bpy.app.tempdir) / f"{name}.ies"
        path.write_bytes(contents)
        texture.filepath = str(path)

    return give


def _internal(texture: bpy.types.Node, name: str, text: str) -> None:
    texture.mode = "INTERNAL"
    texture.ies = bpy.data.texts.new(name)
    texture.ies.write(text)


@damage(
    "luminaires whose files are gone, no files, cut off, or of other bytes",
    ("Gone Luminaire", "Folder Luminaire", "Cut Luminaire", "Empty Luminaire", "Binary Luminaire"),
    "light",
)
def _(_scene: Scene, random: Random) -> None:
    ies_lamp("Gone Luminaire").filepath = "//nowhere/gone.ies"
    ies_lamp("Folder Luminaire").filepath = bpy.app.tempdir
    whole = luminaire(DOWN, AROUND).encode()
    _external(whole[: int(random.integers(1, len(whole) - 10))])(ies_lamp("Cut Luminaire", "SPOT"), "cut")
    _external(b"")(ies_lamp("Empty Luminaire"), "empty")
    _external(b"IESNA\0\xff\xfe\nTILT=NONE\n" + random.bytes(300))(ies_lamp("Binary Luminaire", "AREA"), "binary")


@damage(
    "luminaires of numbers beyond measure, or of none",
    ("Float Luminaire", "Double Luminaire", "NaN Luminaire", "Text Luminaire"),
    "light",
)
def _(_scene: Scene, _random: Random) -> None:
    _internal(ies_lamp("Float Luminaire"), "float", luminaire(DOWN, AROUND, factors=(_BEYOND_FLOATS, 1.0, 1.0)))
    text = luminaire(DOWN, AROUND, candelas=7.25)
    _internal(ies_lamp("Double Luminaire", "SPOT"), "double", text.replace("7.25", _BEYOND_DOUBLES, 3))
    _internal(ies_lamp("NaN Luminaire"), "nan", text.replace("7.25", "nan", 1))
    _internal(ies_lamp("Text Luminaire"), "text", "import bpy\n" * 20)


@damage("luminaires of absurd counts, angles and factors", None, "light")
def _(_scene: Scene, random: Random) -> None:
    factor = float(random.choice([0.0, -1.0, 1e30, 1e-30]))
    texts = (
        luminaire(DOWN, AROUND, factors=(factor, 1.0, 1.0)),
        luminaire(DOWN, AROUND).replace(f" {len(DOWN)} {len(AROUND)} ", " 1000000000 1000000000 "),
        luminaire(DOWN, AROUND).replace(f" {len(DOWN)} {len(AROUND)} ", " 2097152 1 "),
        luminaire((0, 1e30), (0, 360)),
        luminaire((0, 1e-30, 180), (0, 1e-30, 360)),
        luminaire((-720, 0, 720), (-720, 720)),
    )
    for index, text in enumerate(texts):
        _internal(ies_lamp(f"Odd Luminaire {index}", str(random.choice(["POINT", "SPOT", "SUN", "AREA"]))), "odd", text)


@damage("luminaires on surfaces, asked for directions that are none", "Luminaire Soup")
def _(_scene: Scene, random: Random) -> None:
    material = diffuse((0.5, 0.5, 0.5))
    tree, shader, _output = surface_of(material)
    whole, gone = tree.nodes.new("ShaderNodeTexIES"), tree.nodes.new("ShaderNodeTexIES")
    _internal(whole, "whole", luminaire(DOWN, AROUND))
    gone.mode, gone.filepath = "EXTERNAL", "//gone.ies"
    spoil(whole, random, ABSURD, 1.0)
    divided = tree.nodes.new("ShaderNodeVectorMath")
    divided.operation = str(random.choice(["DIVIDE", "NORMALIZE"]))
    tree.links.new(divided.outputs[0], whole.inputs["Vector"])
    tree.links.new(whole.outputs[0], shader.inputs["Color"])
    tree.links.new(gone.outputs[0], shader.inputs["Roughness"])
    on_soup(material, random, "Luminaire Soup")


@damage("falloffs whose strength or smoothness is not a number", ("Mad Falloff POINT", "Mad Falloff AREA"), "light")
def _(_scene: Scene, random: Random) -> None:
    for kind in ("POINT", "SPOT", "AREA", "SUN"):
        tree, emission = lamp_of_nodes(f"Mad Falloff {kind}", kind)
        falloff = tree.nodes.new("ShaderNodeLightFalloff")
        tree.links.new(falloff.outputs[int(random.integers(3))], emission.inputs["Strength"])
        falloff.inputs[int(random.integers(2))].default_value = float(random.choice(NOT_NUMBERS))


@damage("falloffs of absurd strength and smoothness", None, "light")
def _(_scene: Scene, random: Random) -> None:
    for kind in ("POINT", "SPOT", "AREA", "SUN"):
        tree, emission = lamp_of_nodes(f"Falloff {kind}", kind)
        falloff = tree.nodes.new("ShaderNodeLightFalloff")
        tree.links.new(falloff.outputs[int(random.integers(3))], emission.inputs["Strength"])
        strengths = [0.0, 1e30, 1.0] if kind == "SUN" else [0.0, -1.0, -1e30, 1e30, 1.0]  # below 0 it takes light away
        falloff.inputs["Strength"].default_value = float(random.choice(strengths))
        falloff.inputs["Smooth"].default_value = float(random.choice([0.0, -1.0, 1e30, 3e38, 1e-38]))
    material = diffuse((0.5, 0.5, 0.5))
    tree, _shader, output = surface_of(material)
    glow, falloff = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeLightFalloff")
    spoil(falloff, random, ABSURD, 1.0)
    tree.links.new(falloff.outputs[int(random.integers(3))], glow.inputs["Strength"])
    tree.links.new(glow.outputs[0], output.inputs["Surface"])
    on_soup(material, random, "Falling Glow")


@damage("lamps that throw images which are gone", ("Gobo POINT", "Gobo SPOT"), "light")
def _(_scene: Scene, random: Random) -> None:
    for kind in ("POINT", "SPOT", "AREA", "SUN"):
        tree, emission = lamp_of_nodes(f"Gobo {kind}", kind)
        image = bpy.data.images.new(f"gone {kind}.png", 8, 8)
        image.source, image.filepath = "FILE", f"//nowhere/gone {kind}.png"
        texture, normal = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeTexCoord")
        texture.image = image
        texture.extension = str(random.choice(["REPEAT", "CLIP", "EXTEND"]))
        tree.links.new(normal.outputs["Normal"], texture.inputs[0])
        tree.links.new(texture.outputs[0], emission.inputs["Color"])
        if random.integers(2):  # no single image any more
            gamma = tree.nodes.new("ShaderNodeGamma")
            gamma.inputs["Gamma"].default_value = 2.2
            tree.links.new(texture.outputs[0], gamma.inputs[0])
            tree.links.new(gamma.outputs[0], emission.inputs["Color"])


@damage("lamps whose nodes give what is not a number", None, "light")
def _(_scene: Scene, random: Random) -> None:
    for kind in ("POINT", "SPOT", "AREA", "SUN"):
        tree, emission = lamp_of_nodes(f"Endless {kind}", kind)
        geometry, math = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeMath")
        math.operation = str(random.choice(["DIVIDE", "LOGARITHM", "POWER", "EXPONENT", "TANGENT"]))
        math.inputs[1].default_value = float(random.choice([0.0, -1e30, 1e30]))
        tree.links.new(geometry.outputs["Normal"], math.inputs[int(random.integers(2))])
        tree.links.new(math.outputs[0], emission.inputs[str(random.choice(["Color", "Strength"]))])


@damage("emission strengths at the end of floats", None, "darkness")  # below 0, too, which takes all light away
def _(_scene: Scene, random: Random) -> None:
    for kind in ("POINT", "SPOT", "AREA", "SUN"):
        tree, emission = lamp_of_nodes(f"Strong {kind}", kind)
        emission.inputs["Strength"].default_value = float(random.choice([1e38, 3e38, -1e38, 1e-38]))
        emission.inputs["Color"].default_value = (float(random.choice([1.0, 1e38, -1.0])), 0.5, 1.0, 1.0)
        if random.integers(2):
            checker = tree.nodes.new("ShaderNodeTexChecker")
            spoil(checker, random, (1e38, -1e38, inf, nan, 1.0), 1.0)
            tree.links.new(checker.outputs[0], emission.inputs["Color"])
    material = diffuse((0.5, 0.5, 0.5))
    tree, _shader, output = surface_of(material)
    glow = tree.nodes.new("ShaderNodeEmission")
    glow.inputs["Strength"].default_value = float(random.choice([1e38, 3e38, -1e38]))
    tree.links.new(glow.outputs[0], output.inputs["Surface"])
    on_soup(material, random, "Strong Glow")
