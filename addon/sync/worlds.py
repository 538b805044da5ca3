# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one radiance, or one equirectangular image of it; and the medium that fills space, if there is one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tyndall.scene_description import Code, Material, Medium, SurfaceOp, World

from ..shader_nodes import shader_tree
from .node_graph import Socket, output_input
from .program import BLACK, WHITE, Value
from .value_nodes import Domain, ValueReader
from .volume_nodes import read_volume

if TYPE_CHECKING:
    import bpy
    from numpy.typing import NDArray

    from .images import ImageReader
    from .reports import Reports

    _Register = NDArray[np.float64]

#: Stands for a Sky Texture: the mean radiance of its default without the sun, as a plane in Cycles receives it.
_CLEAR_SKY: Value = (2.0, 2.6, 3.6)
_SKIES: dict[str, Value] = {"PREETHAM": (0.37, 0.57, 1.06), "HOSEK_WILKIE": (0.050, 0.085, 0.146)}


def read_world(world: bpy.types.World | None, reports: Reports, images: ImageReader) -> tuple[World, Medium | None]:
    """A scene without a world is black. The medium's index is left to the caller."""
    if world is None:
        return World(name="no world"), None
    tree = shader_tree(world)
    if tree is None:
        return World(name=world.name, radiance=tuple(world.color)), None
    reader = ValueReader(f'World "{world.name}"', reports, images, Domain.WORLD)
    surface, volume = (output_input(tree, name) for name in ("Surface", "Volume"))
    background = BLACK if surface is None else _background(reader, surface, WHITE)
    medium = None
    if volume is not None:
        constants = ValueReader(reader.culprit, reports, images, Domain.CONSTANT)
        medium = read_volume(constants, volume, world.name)
    return _world(reader, world.name, background), medium


def _background(reader: ValueReader, at: Socket, weight: Value) -> Value:
    program, source = reader.program, at.source()
    if not source.socket.is_output or weight == BLACK:
        return BLACK
    if source.socket.type != "SHADER":
        return program.multiply(weight, _colour(reader, at))
    node_type = source.node.type
    if node_type in {"BACKGROUND", "EMISSION"}:
        strength = reader.number(source.input("Strength"), 1.0)
        return program.multiply(weight, program.multiply(_colour(reader, source.input("Color")), strength))
    if node_type == "ADD_SHADER":
        one, other = (_background(reader, shader, weight) for shader in source.inputs()[:2])
        return program.add(one, other)
    if node_type == "MIX_SHADER":
        share, first, second = source.inputs()[:3]
        share_of_second = program.clamp(reader.number(share))
        return program.add(
            _background(reader, first, program.multiply(weight, program.complement(share_of_second))),
            _background(reader, second, program.multiply(weight, share_of_second)),
        )
    reader.unsupported(source, "is no background: black")
    return BLACK


def _colour(reader: ValueReader, at: Socket) -> Value:
    source = at.source()
    if source.socket.is_output and source.node.type == "TEX_SKY":
        reader.unsupported(source, "is drawn as one even blue, without its sun: add a Sun light")
        return _SKIES.get(source.node.sky_type, _CLEAR_SKY)
    return reader.colour(at)


def _world(reader: ValueReader, name: str, background: Value) -> World:
    """A world is a colour times its image. What a program adds to that is drawn as the mean of black and white."""
    if reader.environment is None:
        return World(name=name, radiance=_evaluate(reader, background, 0.5))
    image, image_from_world = reader.environment
    dark, grey, light = (np.array(_evaluate(reader, background, texel)) for texel in (0.0, 0.5, 1.0))
    if dark.any() or not np.allclose(grey, light / 2):
        reader.note("only a colour times an image is supported: other arithmetic on the image is left out")
    return World(name=name, radiance=tuple(light - dark), image=image, image_from_world=image_from_world)


def _evaluate(reader: ValueReader, value: Value, texel: float) -> tuple[float, float, float]:
    """The value where every texture shows a grey ``texel``."""
    material = reader.program.material("", (value, BLACK, BLACK))
    if not material.program:
        return material.diffuse
    return _run(material, texel)


def _run(material: Material, texel: float) -> tuple[float, float, float]:
    registers: dict[int, NDArray[np.float64]] = {}
    for op in material.program:
        a, b, c = (registers.get(register, np.zeros(3)) for register in (op.a, op.b, op.c))
        registers[op.out] = _result(op, a, b, c, np.full(3, texel))
    red, green, blue = registers[material.diffuse_register]
    return float(red), float(green), float(blue)


def _result(op: SurfaceOp, a: _Register, b: _Register, c: _Register, texel: _Register) -> _Register:
    """What native/shading computes, here for the few operations of a world."""
    return {
        Code.CONSTANT: np.array(op.value),
        Code.TEXTURE: texel,
        Code.TEXTURE_ALPHA: np.ones(3),
        Code.MULTIPLY: a * b,
        Code.ADD: a + b,
        Code.SUBTRACT: a - b,
        Code.MIX: a + (b - a) * np.clip(c, 0, 1),
        Code.CLAMP: np.clip(a, 0, 1),
        Code.AVERAGE: np.full(3, a.mean()),
        Code.BACKFACING: np.zeros(3),
    }[op.code]
