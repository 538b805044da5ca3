# SPDX-License-Identifier: GPL-3.0-or-later
"""IES files of luminaires that nobody sells: each angle has a value of its own."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import bpy
import numpy as np

from .patch_nodes import Link, New, Socket

DOWN, AROUND = tuple(range(0, 181, 15)), tuple(range(0, 361, 45))


def luminaire(
    down: Sequence[float] = DOWN,
    across: Sequence[float] = (0,),
    photometry: int = 1,
    *,
    candelas: float | None = None,
    factors: tuple[float, float, float] = (1.0, 1.0, 1.0),
    tilt: str = "NONE",
) -> str:
    """Text of a file of these angles; ``candelas``: the same everywhere."""
    values = np.random.default_rng(3).uniform(50, 1000, (len(across), len(down))).round(1)
    if candelas is not None:
        values[:] = candelas
    if across[-1] == across[0] + 360:
        values[-1] = values[0]
    lines = [
        "IESNA:LM-63-2002",
        "[TEST] made by a test",
        f"TILT={tilt}",
        f"1 1000 {factors[0]} {len(down)} {len(across)} {photometry} 2 0 0 0",
        f"{factors[1]} {factors[2]} 100",
        *(" ".join(f"{number:g}" for number in row) for row in (down, across, *values)),
    ]
    return "\n".join(lines) + "\n"


def texture(
    new: Callable[[str], bpy.types.Node], text: str | None, name: str = "Luminaire.ies", **inputs: float
) -> bpy.types.Node:
    """An IES Texture node of an internal text; None: of no text."""
    made = new("ShaderNodeTexIES")
    made.mode = "INTERNAL"
    if text is not None:
        made.ies = bpy.data.texts.new(name)
        made.ies.write(text)
    for key, value in inputs.items():
        made.inputs[key].default_value = value
    return made


def _at(place: str | None, text: str, strength: float = 0.01) -> Callable[[New, Link], Socket]:
    def build(new: New, link: Link) -> Socket:
        made = texture(new, text, Strength=strength)
        if place is not None:
            centred = new("ShaderNodeVectorMath")
            centred.operation = "MULTIPLY_ADD"
            centred.inputs[1].default_value, centred.inputs[2].default_value = (2, 2, 2), (-1, -1, -0.7)
            link(new("ShaderNodeTexCoord").outputs[place], centred.inputs[0])
            link(centred.outputs[0], made.inputs["Vector"])
        return made.outputs[0]

    return build


#: For patch_nodes.py.
PHOTOMETRY = {
    "luminaire all around": _at("Generated", luminaire(DOWN, AROUND)),
    "luminaire of one plane": _at("Generated", luminaire(range(0, 91, 10))),
    "luminaire without a vector": _at(None, luminaire(DOWN, AROUND)),
}


def around(new: New, link: Link) -> Socket:
    """All directions over the UV map: longitude and latitude."""

    def computed(operation: str, *operands: Socket | float) -> Socket:
        math_node = new("ShaderNodeMath")
        math_node.operation = operation
        for socket, operand in zip(math_node.inputs, operands, strict=False):
            if isinstance(operand, bpy.types.NodeSocket):
                link(operand, socket)
            else:
                socket.default_value = operand
        return math_node.outputs[0]

    apart, together = new("ShaderNodeSeparateXYZ"), new("ShaderNodeCombineXYZ")
    link(new("ShaderNodeTexCoord").outputs["UV"], apart.inputs[0])
    longitude = computed("MULTIPLY", computed("SUBTRACT", apart.outputs[0], 0.5), 2.0 * math.pi)
    latitude = computed("MULTIPLY", computed("SUBTRACT", apart.outputs[1], 0.5), math.pi)
    beside = computed("COSINE", latitude)
    for axis, turned in enumerate(("SINE", "COSINE")):
        link(computed("MULTIPLY", beside, computed(turned, longitude)), together.inputs[axis])
    link(computed("SINE", latitude), together.inputs[2])
    return together.outputs[0]
